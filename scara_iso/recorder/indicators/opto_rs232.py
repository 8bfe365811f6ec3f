"""Opto-RS232: ``+001.234``, the line of Sylvac, Bowers, Fowler, Käfer, TESA, Trimos and IBR.

Sign (+, - or blank), digits, point, digits, then unit and tolerance sign where they are sent;
``ERR`` and a number; ``SY...`` when switched on. The sources leave the number of digits to "unit
and resolution"; each maker's examples have one width, and a fixed width tells a line that lost a
byte, which has no other mark.
"""

from __future__ import annotations

from typing import Any

from scara_iso.recorder.indicators._dialect import Dialect, LinePulse, LineSettings
from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

_AFTER = rb"(?: ?(?P<unit>mm|in|MM|IN))?(?P<mode>[<=>])?"


def _cable(width: int, **fields: Any) -> Dialect:
    """Return the dialect of an instrument that sends ``width`` digits, on one maker's cable."""
    family: dict[str, Any] = {
        "reading": rb"(?P<sign>[+\- ])(?=[\d.]{%d}(?![\d.]))(?P<digits>\d*\.\d+)%b"
        % (width + 1, _AFTER),
        "form": "{sign}{digits}{unit}",
        "units": {None: "", "mm": "mm", "inch": "in"},
        "decimals": (3, 1, 2, 4, 5, 6),
        "line": LineSettings.of("4800 7E2", dtr=True, rts=False),
        "longest_frame": 32,
        "request_template": b"?\r",
        "confidence": "high",
        "faults": (
            FaultLine(
                rb"(?i:ERR)(?P<kind>\d{1,2})",
                {
                    "0": "sensor error (speed, scale)",
                    "1": "command not understood",
                    "2": "parity error: check the port's settings",
                    "3": "measuring range exceeded",
                },
            ),
            FaultLine(rb"OV", "outside the range"),
        ),
        "notices": (
            rb"(?i:(?P<on>SY[0-9A-Z][ -~]{0,28}))",
            rb"(?i:BAT(?:1|(?P<low>0)))",
            rb"(?i:(?P<unit>MM|IN)(?: RES[23]| REF[12]| KEY[01]| B[01])*?(?P<low> B0)?)",
            rb"(?i:\?|PRI|NOR|MIN|MAX|DEL|RST|(?:UNI|SET|ID|MOD|BAT|VER|PRE|ECO|AOFF)\?)",
            rb"(?i:(?:OUT|STO|KEY|AOFF|ECO)[01]|RES[23]|REF[12]?|TOL[01]?)",
        ),
    }
    return line_dialect(digits=width, **family | fields)


_OF_SYLVAC = "Bowers Sylvac Opto Instruments pp. 13-14; Checkline J-CC p. 2; UniCal p. 65"

DIALECTS = (
    _cable(
        6,
        key="opto-rs232",
        instruments="Sylvac, Bowers, Fowler, Käfer with six digits; duplex Opto-RS232 or USB cable",
        cable="Opto-RS232 duplex cable (powered by DTR on and RTS off), or the maker's USB cable",
        unit_request=b"UNI?\r",
        source=_OF_SYLVAC,
        unverified=(
            "how long a duplex cable must be powered before the first request (allow 0.2 s)",
            "six digits for every instrument: one with seven is read by opto-rs232-ibr",
            "MarCator 1086/1087: no manual page found; a unit after the number is taken if sent",
        ),
    ),
    _cable(
        6,
        key="opto-rs232-simplex",
        instruments="the same instruments on a simplex cable (request by the DTR line)",
        cable="Opto-RS232 simplex cable (powered by RTS on); DTR off for 0.15 s asks",
        line=LineSettings.of("4800 7E2", dtr=True, rts=True),
        request_template=None,
        request_line=LinePulse("dtr", level=False, seconds=0.15),
        source=_OF_SYLVAC,
        unverified=("six digits for every instrument",),
    ),
    _cable(
        6,
        key="opto-rs232-tesa",
        instruments="TESA TT80 and TT90, bidirectional cable 04761049",
        cable="bidirectional cable 04761049",
        terminator=b"\r\n",
        source="TESA (Hexagon) TT80 manual pp. 94-95",
        unverified=("errors other than ERR and a number", "mil display with five or seven digits"),
    ),
    _cable(
        8,
        key="opto-rs232-trimos",
        instruments="Trimos Mestra and Vectra height gauges (numerical values only)",
        cable="RS-232 of the height gauge",
        reading=rb"(?=.{10}\Z) *(?P<sign>-?) *(?P<digits>\d*\.\d+)",
        form="{number:>10}",
        fill=" ",
        units={None: ""},
        decimals=(4, 1, 2, 3, 5, 6),
        source="Trimos Vectra manual p. 32; Mestra manual p. 21",
        confidence="medium",
        unverified=(
            "line settings and request: those of the family",
            "ten characters for every resolution",
        ),
    ),
    _cable(
        7,
        key="opto-rs232-ibr",
        instruments="IBR C200, and any Opto-RS232 instrument that sends seven digits",
        cable="RS-232 of the column, or a duplex cable",
        decimals=(4, 1, 2, 3, 5, 6),
        source="IBR C200 manual p. 39",
        confidence="medium",
        unverified=("modem lines: those of the duplex Opto-RS232 cable",),
    ),
)
