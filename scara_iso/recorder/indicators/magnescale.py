"""Magnescale LT10A/LT11A/LT20A counters and MG80 modules: ``A+12.345``, ``00NMG-09.9999``.

Channel A or B, or module and counter, 0 to F; mode N current, P peak-to-peak, I minimum, A maximum;
unit M or I; judgement, of which E is an alarm; sign + or blank. Alarms begin with ``E`` or ``F``.
"""

from __future__ import annotations

from typing import Any

from scara_iso.recorder.indicators._dialect import Dialect
from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

_UNSET = "baud, data bits, parity and stop bits"


def _counter(header: bytes, *, width: int, **fields: Any) -> Dialect:
    """Return the dialect of values of ``width`` characters, several on a line."""
    channel = rb"(?P<channel>%b)" % header
    ahead = channel + rb"(?:[NPIA][MI])?(?P<code>(?:(?<=[MI])[UGLE])?"
    return line_dialect(
        line="9600 8N1",
        reading=channel
        + rb"(?:(?P<unit>(?P<held>[NPIA])[MI])(?P<mode>[UGLE])?)?"
        + rb"(?P<sign>[+\- ])(?=[\d.]{%d}(?![\d.]))(?P<digits>\d+\.\d+)" % width,
        form="{channel}{unit}{sign}{digits}",
        between=b" ",
        refused={
            "mode": {b"E": "alarm"},
            "held": {
                b"P": "peak-to-peak value, not the reading",
                b"I": "minimum value, not the reading",
                b"A": "maximum value, not the reading",
            },
        },
        faults=(
            FaultLine(ahead + rb"(?:[+\- ]F[\d.]+|EF))", "overflow", code="{code}"),
            FaultLine(ahead + rb"(?:EO?|  Error ))", "alarm", code="{code}"),
        ),
        terminator=b"\r\n",
        digits=width - 1,
        confidence="medium",
        **fields,
    )


DIALECTS = (
    _counter(
        rb"[AB]",
        width=6,
        key="magnescale",
        instruments="Magnescale LT10A and LT11A counters with RS-232C (-C models)",
        cable="RS-232C socket of the counter",
        longest_frame=2 * 12 + 1,
        decimals=(3, 1, 2, 4),
        units={None: "", "mm": "NM", "inch": "NI"},
        request_template=b"R\r\n",
        channels=("A", "B"),
        channel="A",
        source="Magnescale LT10A/LT11A manual pp. 16, 37",
        unverified=(_UNSET,),
    ),
    _counter(
        rb"[AB]",
        width=7,
        key="magnescale-lt20a",
        instruments="Magnescale LT20A and LT30 counters with RS-232C",
        cable="RS-232C socket of the counter",
        longest_frame=2 * 13 + 1,
        decimals=(4, 1, 2, 3, 5),
        units={None: "", "mm": "NM", "inch": "NI"},
        request_template=b"R\r\n",
        channels=("A", "B"),
        channel="A",
        source="Magnescale LT20A/LT30 manual pp. 40-41",
        unverified=(_UNSET, "the request (that of the LT10A)"),
    ),
    _counter(
        rb"[0-9A-F]{2}",
        width=7,
        key="magnescale-mg80",
        instruments="Magnescale MG80-SC1 modules",
        cable="RS-232C of the main module; CR or CR LF by switch 2",
        longest_frame=16 * 14 + 15,
        decimals=(4, 1, 2, 3, 5),
        units={None: "", "mm": "NM"},
        also={b"NI": "inch"},
        channels=tuple(f"{module:X}{counter:X}" for module in range(16) for counter in range(16)),
        channel="00",
        source="Magnescale MG80-SC1 manual pp. 39-40",
        unverified=(_UNSET, "the request (this driver listens)"),
    ),
)
