"""Mahr Millimar C1202 (``1 +123.45 mm =``) and C1208/C1216/C1240 (``+012.345mm``).

``?`` reads the three features of the C1202, separated by ``;``. The M1240 and ASCII protocols of
the others send no unit, and are not read here.
"""

from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

_LENGTHS: dict[str | None, str] = {"mm": "mm", "um": "um", "inch": "inch"}

_C1202 = line_dialect(
    key="millimar",
    instruments="Mahr Millimar C1202",
    cable="duplex cable of the maker",
    line="9600 7E2",
    reading=rb"(?P<channel>[123]) (?P<sign>[+-])(?=[\d.]{6} )(?P<digits>\d+\.\d+) "
    rb"(?P<unit>mm|um|inch|deg|rad)(?: (?P<mode>[<=>](?: [<=>])?))?",
    form="{channel} {sign}{digits} {unit}",
    units={**_LENGTHS, "deg": "deg", "rad": "rad"},
    between=b";",
    faults=(
        FaultLine(rb"(?P<channel>[123]) ERR6", "the feature is switched off", code="ERR6"),
        FaultLine(
            rb"(?P<channel>[123]) [+-]\d+:\d\d:\d\d dms",
            "the feature shows degrees, minutes and seconds: set it to degrees",
            code="dms",
        ),
    ),
    longest_frame=3 * 24,
    digits=5,
    decimals=(2, 1, 3, 4),
    request_template=b"M{channel}?\r",
    channels=("1", "2", "3"),
    channel="1",
    source="Mahr Millimar C1202 manual p. 82",
    confidence="high",
    unverified=("five digits for every unit and resolution, as in the manual's examples",),
)

_C1240 = line_dialect(
    key="millimar-c1240",
    instruments="Mahr Millimar C1208, C1216, C1240 with protocol OPTORSS or OPTORSD",
    cable="RS 232 socket; choose protocol OPTORSS or OPTORSD in the menu",
    line="4800 7E2",
    reading=rb"(?P<sign>[+\- ])(?=[\d.]{7}(?![\d.]))(?P<digits>\d+\.\d+)(?P<unit>mm|inch|in|um)",
    form="{sign}{digits}{unit}",
    units=_LENGTHS,
    notices=(rb"(?P<unit>mm|in|inch|um) ?", rb"MAHR[ -~]{0,24}"),
    terminator=b"\r\n",
    longest_frame=32,
    digits=6,
    decimals=(3, 1, 2, 4, 5),
    request_template=b"?\r",
    unit_request=b"UNI?\r",
    source="Mahr Millimar C1208/C1216/C1240 manual pp. 60, 67-70",
    confidence="high",
    unverified=(
        "line settings (chosen in the instrument's menu FORMAT)",
        "that a plus sign or a blank is sent before a positive value",
    ),
)

DIALECTS = (_C1202, _C1240)
