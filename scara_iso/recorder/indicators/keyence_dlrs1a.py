"""Keyence GT2 and GT-70A through the DL-RS1A: ``SR,00,002,+012.3456``.

``SR,ID,NNN`` reads data number NNN of unit ID (002 is the raw value R.V., 000 the comparator value
P.V., which may be held); ``M0`` reads every unit. The manual's table of special values is cut off
in the copies: its sister SK-1000 sends letters for an amplifier error, and all nines out of range.
"""

from __future__ import annotations

from dataclasses import replace

from scara_iso.recorder.indicators._dialect import Dialect, Event
from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

_DATA = rb"SR,(?P<channel>\d\d),(?P<mode>000|002),"
_FAULTS = (
    FaultLine(_DATA + rb"(?P<code>[+-]E{2,4}\.E{2,5})", "error of the amplifier", code="{code}"),
    FaultLine(_DATA + rb"(?P<code>[+-]0?9+\.9+)", "out of range", code="{code}"),
    FaultLine(
        rb"ER,[A-Z0-9]{2},(?P<kind>\d\d)",
        {
            "00": "invalid command",
            "20": "wrong length",
            "21": "wrong number of parameters",
            "22": "wrong parameter",
            "29": "communication error",
            "65": "no such unit",
        },
        code="ER {kind}",
    ),
)


def _amplifier(key: str, instruments: str, decimals: int) -> Dialect:
    def every_unit(line: bytes) -> tuple[Event, ...]:
        """Return what ``M0`` brings: the value of each unit, in their order."""
        head, *values = line.split(b",")
        singly = [
            event
            for unit, value in enumerate(values if head == b"M0" else ())
            for event in dialect.parse(b"SR,%02d,000,%b" % (unit, value))
        ]
        whole = 0 < len(singly) == len(values)
        return tuple(replace(event, raw=line) for event in singly) if whole else ()

    dialect = line_dialect(
        key=key,
        instruments=instruments,
        cable="DL-RS1A communication unit, RS-232",
        line="9600 8N1",
        reading=_DATA + rb"(?P<sign>[+-])(?P<digits>\d{3}\.\d{%d})" % decimals,
        form="SR,{channel},002,{sign}{digits}",
        units={None: ""},
        modes={b"000": "P.V.", b"002": "R.V."},
        faults=_FAULTS,
        other=every_unit,
        terminator=b"\r\n",
        longest_frame=2 + 15 * (6 + decimals),
        digits=3 + decimals,
        decimals=(decimals,),
        request_template=b"SR,{channel},002\r\n",
        channels=tuple(f"{number:02}" for number in range(15)),
        channel="00",
        source="Keyence DL-RS1A manual pp. 9-13",
        confidence="high",
        unverified=("the table of special values (letters and all nines are refused)",),
    )
    return dialect


DIALECTS = (
    _amplifier("keyence-dlrs1a", "Keyence GT2 through DL-RS1A", 4),
    _amplifier("keyence-dlrs1a-gt70a", "Keyence GT-70A through DL-RS1A", 3),
)
