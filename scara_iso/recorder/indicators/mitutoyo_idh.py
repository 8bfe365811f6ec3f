"""Mitutoyo ID-H0530/0560 on RS-232C: ``GN01,+0016.2345``; GN is normal, GX max, GM min, GW TIR."""

from scara_iso.recorder.indicators._grammar import line_dialect

DIALECT = line_dialect(
    key="mitutoyo-idh",
    instruments="Mitutoyo ID-H0530 and ID-H0560, RS-232C output",
    cable="RS-232C cable of the gauge",
    line="9600 8N1",
    reading=rb"(?P<kind>G[NXMW])(?P<channel>\d\d),"
    rb"(?P<sign>[+-])(?=[\d.]{9}\Z)(?P<digits>\d+\.\d+)",
    form="GN{channel},{sign}{digits}",
    units={None: ""},
    refused={
        "kind": {
            b"GX": "the gauge sends the maximum, not the reading",
            b"GM": "the gauge sends the minimum, not the reading",
            b"GW": "the gauge sends the TIR (maximum less minimum), not the reading",
        }
    },
    notices=(rb"(?:CH|DH)\d\d(?:,(?:OK|[+-]NG|JOFF|F-LOCK))?",),
    terminator=b"\r\n",
    longest_frame=15,
    digits=8,
    decimals=(4, 1, 2, 3, 5, 6),
    request_template=b"GA{channel}\r\n",
    channels=tuple(f"{number:02}" for number in range(100)),
    channel="01",
    source="Mitutoyo ID-H0560 99MAH016B p. 4-5",
    confidence="high",
    unverified=("baud, data bits, parity and stop bits", "error replies"),
)
