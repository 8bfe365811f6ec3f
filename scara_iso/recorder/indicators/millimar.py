"""Mahr Millimar C1202 (``1 +123.45 mm =``) and C1208/C1216/C1240 (``+012.345mm``).

Sources: Millimar C1202 manual p. 82: 9600 7E2, ``?`` reads the three features, separated by
``;``, leading zeros included; C1208/C1216/C1240 manual pp. 69-70, protocols OPTORSS and OPTORSD.
The M1240 and ASCII protocols of the latter send no unit, and are not read here.
"""

from __future__ import annotations

import re

from scara_iso.recorder.indicators._dialect import (
    Dialect,
    Event,
    InstrumentFault,
    LineSettings,
    Reading,
)
from scara_iso.recorder.indicators._grammar import (
    UNITS,
    decimal_text,
    line_dialect,
    show_digits,
    spell,
)

_FEATURE = re.compile(
    rb"([123]) (?:([+-])(?=[\d.]{6} )(\d+\.\d+) (mm|um|inch|deg|rad)(?: ([<=>](?: [<=>])?))?"
    rb"|(ERR6|[+-]\d+:\d\d:\d\d dms))"
)
_SPELLINGS: dict[str | None, str] = {"mm": "mm", "um": "um", "inch": "inch"}


def parse_features(line: bytes) -> tuple[Event, ...]:
    """Return an event for each feature in one answer of the C1202; one bad feature spoils it."""
    found = [_FEATURE.fullmatch(part) for part in line.split(b";")]
    numbers = [feature[1] for feature in found if feature]
    if len(numbers) < len(found) or len(set(numbers)) < len(numbers):
        return ()
    return tuple(_feature(feature, line) for feature in found if feature)


def _feature(found: re.Match[bytes], line: bytes) -> Event:
    number, sign, digits, unit, judgement, other = found.groups()
    channel = number.decode("ascii")
    match other:
        case b"ERR6":
            return InstrumentFault("ERR6", "the feature is switched off", line, channel)
        case bytes():
            message = "the feature shows degrees, minutes and seconds: set it to degrees"
            return InstrumentFault("dms", message, line, channel)
    mode = judgement.decode("ascii") if judgement else None
    return Reading(decimal_text(sign, digits), UNITS[unit], channel, mode, line)


def compose_feature(text: str, unit: str | None, channel: str | None) -> bytes:
    """Return the answer of a C1202 to ``M1?`` when the feature shows ``text``."""
    sign, digits = show_digits(text, digits=5, decimals=_C1202.decimals)
    name = spell(unit, {**_SPELLINGS, "deg": "deg", "rad": "rad"}, key=_C1202.key)
    return f"{channel or 1} {sign}{digits} {name}\r".encode("ascii")


_C1202 = Dialect(
    key="millimar",
    instruments="Mahr Millimar C1202",
    cable="duplex cable of the maker",
    line=LineSettings(9600, 7, "E", 2),
    parse=parse_features,
    compose=compose_feature,
    longest_frame=3 * 24,
    digits=5,
    decimals=(2, 1, 3, 4),
    units=("mm", "um", "inch", "deg", "rad"),
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
    line=LineSettings(4800, 7, "E", 2),
    reading=rb"(?P<sign>[+\- ])(?=[\d.]{7}(?![\d.]))(?P<digits>\d+\.\d+)(?P<unit>mm|inch|in|um)",
    form="{sign}{digits}{unit}",
    units=_SPELLINGS,
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
