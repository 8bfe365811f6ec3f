"""Heidenhain ND 2xx display units: ``-      5.23  =A``.

Sign; ten characters with the point; blank; unit (blank mm, ``"`` inch, ``?`` fault); sorting;
series (S MIN, A ACTL, G MAX, D DIFF). Ctrl-B calls the value.
"""

from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

DIALECT = line_dialect(
    key="heidenhain-nd",
    instruments="Heidenhain ND 2xx B display units with a length gauge",
    cable="RS-232-C socket of the display",
    line="9600 7E2",
    reading=rb'(?=.{15}\Z)(?P<sign>[+-])(?P<digits> *\d*\.\d+) (?P<unit>[ "?])(?P<mode>[<=>? ])'
    rb"(?P<series>[SAGD ])",
    form="{sign}{digits} {unit}  ",
    fill=" ",
    units={"mm": " ", "inch": '"'},
    refused={
        "unit": {b"?": "the display reports a fault (ENQ asks which)"},
        "series": {
            b"S": "minimum of a series, not the reading",
            b"G": "maximum of a series, not the reading",
            b"D": "difference of a series, not the reading",
        },
    },
    faults=(FaultLine(rb"\x15[\x00-\xff]*", "the display refused a command", code="NAK"),),
    terminator=b"\r\n",
    longest_frame=15,
    digits=9,
    decimals=(4, 1, 2, 3, 5, 6),
    request_template=b"\x02",
    answer_time_s=0.3,
    source="Heidenhain ND 281 B manual p. 47; ND 281 B v1 p. 42; ND 221 B p. 34",
    confidence="high",
    unverified=(
        "the baud rate is parameter P50 of the display",
        "ND 280 and ND 287 (whose format can be changed in its menu)",
    ),
)
