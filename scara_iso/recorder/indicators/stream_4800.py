"""Low-cost USB cables that send without being asked: sign, seven digits, point.

Source: INSPEC 711-201B USB interface, seller's page: 4800 baud, 8 data bits, 1 stop bit, ten bytes
every 300 ms, beginning with + or - followed by seven digits and a point. No unit.
"""

from __future__ import annotations

from scara_iso.recorder.indicators._dialect import LineSettings
from scara_iso.recorder.indicators._grammar import line_dialect

DIALECT = line_dialect(
    key="stream-4800",
    instruments="INSPEC 711-201B and similar USB cables that send all the time",
    cable="the USB cable of the gauge",
    line=LineSettings(4800, 8, "N", 1),
    reading=rb"(?P<sign>[+-])(?=[\d.]{8}\Z)(?P<digits>\d+\.\d+)",
    form="{sign}{digits}",
    units={None: ""},
    longest_frame=9,
    digits=7,
    decimals=(3, 1, 2, 4, 5, 6),
    source="INSPEC 711-201B, seller's page",
    confidence="low",
    unverified=(
        "the line end (CR is a guess; CR, LF and both are taken)",
        "what an error looks like",
        "a value may be 0.3 s old when it arrives",
    ),
)
