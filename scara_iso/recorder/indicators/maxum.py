"""Mahr Federal Maxum III: `` + 1.234M  `` and a line feed.

Dynamic mode (A, M, L, T with hold, a, m, l, t without, blank for the standard product), polarity,
blank, four digits with the point (or three and a blank), M (mm) or I (inch), limit (0 above, U
below), blank, LF.
"""

from scara_iso.recorder.indicators._grammar import line_dialect

DIALECT = line_dialect(
    key="maxum",
    instruments="Mahr Federal Maxum III with cable 2239036 or 2239038",
    cable="output cable 2239036 or 2239038",
    line="9600 8N1",
    reading=rb"(?P<kind>[AMLTamlt ])(?P<sign>[+\- ]) (?=[\d.]{5}[MI]|\.\d{3} [MI])"
    rb"(?P<digits>\d?\.\d+) ?(?P<unit>[MI])(?P<mode>[0OU ]) ",
    form=" {sign} {digits}{unit}  ",
    units={"mm": "M", "inch": "I"},
    modes={b"0": "above limit", b"O": "above limit", b"U": "below limit"},
    refused={
        "kind": {
            b"A": "actual value on hold, not the reading",
            b"M": "maximum value on hold, not the reading",
            b"L": "minimum value on hold, not the reading",
            b"T": "TIR value on hold, not the reading",
            b"m": "maximum value, not the reading",
            b"l": "minimum value, not the reading",
            b"t": "TIR value, not the reading",
        }
    },
    terminator=b"\n",
    longest_frame=11,
    digits=4,
    decimals=(3, 4),
    source="Mahr Federal Maxum III manual 2239028 Rev D p. 51",
    confidence="medium",
    unverified=(
        "the request (this driver listens)",
        "how a plus sign is sent (plus or blank are taken)",
        "the bare gauge: 2400 7N2",
    ),
)
