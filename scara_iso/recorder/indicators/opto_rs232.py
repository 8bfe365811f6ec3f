"""Opto-RS232: ``+001.234``, the line of Sylvac, Bowers, Fowler, Käfer, TESA, Trimos and IBR.

Sources: Bowers "Sylvac Opto Instruments" pp. 13-14 (word for word Käfer in Checkline J-CC p. 2,
and Sylvac Power p. 15): 4800 baud, 7 data bits, even parity, 2 stop bits; sign (+, - or blank),
digits, point, digits, CR; ``ERR`` and a number; ``SY...`` when switched on. UniCal p. 65: commands,
echo, tolerance sign. TESA TT80 pp. 94-95; Trimos Vectra p. 32, Mestra p. 21; IBR C200 p. 39.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from scara_iso.recorder.indicators._dialect import (
    DeviceNotice,
    Event,
    InstrumentFault,
    LinePulse,
    LineSettings,
)
from scara_iso.recorder.indicators._grammar import (
    UNITS,
    line_dialect,
    show_digits,
    spell,
)

_AFTER = rb"(?: ?(?P<unit>mm|in|MM|IN))?(?P<mode>[<=>])?"
_FAULT = re.compile(rb"(?i:ERR(\d{1,2}))|OV")
_FAULTS = {
    b"0": "sensor error (speed, scale)",
    b"1": "command not understood",
    b"2": "parity error: check the port's settings",
    b"3": "measuring range exceeded",
}
_NOTICE = re.compile(
    rb"(?i:SY[0-9A-Z][ -~]{0,28}|BAT[01]|\?|PRI|(?:UNI|SET|ID|MOD|BAT|VER|PRE|ECO|AOFF)\?"
    rb"|OUT[01]|STO[01]|KEY[01]|RES[23]|AOFF[01]|ECO[01]|NOR|REF[12]?|MIN|MAX|DEL|TOL[01]?|RST"
    rb"|(MM|IN)(?: RES[23]| REF[12]| KEY[01]| B[01])*)"
)


def _other_line(line: bytes) -> tuple[Event, ...]:
    text = line.decode("ascii", "replace")
    if found := _FAULT.fullmatch(line):
        message = _FAULTS.get(found[1], "unknown error") if found[1] else "outside the range"
        return (InstrumentFault(text, message, line),)
    if found := _NOTICE.fullmatch(line):
        low = ": battery low" if text.upper().endswith((" B0", "BAT0")) else ""
        unit = UNITS[found[1].lower()] if found[1] else None
        return (DeviceNotice(text + low, line, unit, switched_on=text.upper().startswith("SY")),)
    return ()


def _number(digits: int) -> bytes:
    # The sources leave the number of digits to "unit and resolution"; each maker's examples have
    # one width. A fixed width tells a line that lost a byte, which has no other mark.
    width = rb"%d" % (digits + 1)
    return rb"(?P<sign>[+\- ])(?=[\d.]{%b}(?![\d.]))(?P<digits>\d*\.\d+)%b" % (width, _AFTER)


def _compose_trimos(text: str, unit: str | None, _channel: str | None) -> bytes:
    sign, shown = show_digits(text, digits=8, decimals=range(1, 9), fill=" ")
    spell(unit, {None: ""}, key="opto-rs232-trimos")
    number = shown.lstrip()
    return f"{('-' if sign == '-' else '') + number:>10}\r".encode("ascii")


_FAMILY: dict[str, Any] = {
    "form": "{sign}{digits}{unit}",
    "units": {None: "", "mm": "mm", "inch": "in"},
    "other": _other_line,
    "line": LineSettings(4800, 7, "E", 2, dtr=True, rts=False),
    "longest_frame": 32,
    "request_template": b"?\r",
}
_SIX: dict[str, Any] = {
    **_FAMILY,
    "reading": _number(6),
    "digits": 6,
    "decimals": (3, 1, 2, 4, 5, 6),
    "confidence": "high",
}
_OF_SYLVAC = "Bowers Sylvac Opto Instruments pp. 13-14; Checkline J-CC p. 2; UniCal p. 65"

_SYLVAC = line_dialect(
    **_SIX,
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
)

_SIMPLEX = line_dialect(
    **_SIX
    | {
        "line": LineSettings(4800, 7, "E", 2, dtr=True, rts=True),
        "request_template": None,
    },
    key="opto-rs232-simplex",
    instruments="the same instruments on a simplex cable (request by the DTR line)",
    cable="Opto-RS232 simplex cable (powered by RTS on); DTR off for 0.15 s asks",
    request_line=LinePulse("dtr", level=False, seconds=0.15),
    source=_OF_SYLVAC,
    unverified=("six digits for every instrument",),
)

_TESA = line_dialect(
    **_SIX,
    key="opto-rs232-tesa",
    instruments="TESA TT80 and TT90, bidirectional cable 04761049",
    cable="bidirectional cable 04761049",
    terminator=b"\r\n",
    source="TESA (Hexagon) TT80 manual pp. 94-95",
    unverified=("errors other than ERR and a number", "mil display with five or seven digits"),
)

_TRIMOS = replace(
    line_dialect(
        **_FAMILY | {"units": {None: ""}},
        reading=rb"(?=.{10}\Z) *(?P<sign>-?) *(?P<digits>\d*\.\d+)",
        key="opto-rs232-trimos",
        instruments="Trimos Mestra and Vectra height gauges (numerical values only)",
        cable="RS-232 of the height gauge",
        digits=8,
        decimals=(4, 1, 2, 3, 5, 6),
        source="Trimos Vectra manual p. 32; Mestra manual p. 21",
        confidence="medium",
        unverified=(
            "line settings and request: those of the family",
            "ten characters for every resolution",
        ),
    ),
    compose=_compose_trimos,
)

_IBR = line_dialect(
    **_FAMILY,
    reading=_number(7),
    key="opto-rs232-ibr",
    instruments="IBR C200, and any Opto-RS232 instrument that sends seven digits",
    cable="RS-232 of the column, or a duplex cable",
    digits=7,
    decimals=(4, 1, 2, 3, 5, 6),
    source="IBR C200 manual p. 39",
    confidence="medium",
    unverified=("modem lines: those of the duplex Opto-RS232 cable",),
)

DIALECTS = (_SYLVAC, _SIMPLEX, _TESA, _TRIMOS, _IBR)
