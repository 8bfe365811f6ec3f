"""Chicago Dial Indicator (Logic) and Starrett IQ: ``+  2.1380, MM``.

Sources: CDI "USB and RS232 communication protocol" (polarity, eight characters with the point,
comma, blank, IN or MM, CR LF); Starrett IQ manual p. 17 agrees byte for byte.
"""

from __future__ import annotations

import re

from scara_iso.recorder.indicators._dialect import (
    DeviceNotice,
    Dialect,
    Event,
    InstrumentFault,
    LineSettings,
    Reading,
)
from scara_iso.recorder.indicators._grammar import decimal_text, show_digits, spell

_READING = re.compile(rb"([+-])(?=[ \d.]{8},)( *\d*\.\d+), (MM|IN)")
_FAULT = re.compile(rb"NOT FOUND|NO ACCESS|OUT OF BOUNDS|NON NUMERIC")
_UNITS = {b"MM": "mm", b"IN": "inch"}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line says."""
    if found := _READING.fullmatch(line):
        sign, digits, unit = found.groups()
        return (Reading(decimal_text(sign, digits), _UNITS[unit], None, None, line),)
    if _FAULT.fullmatch(line):
        text = line.decode("ascii")
        return (InstrumentFault(text, f"the gauge refused a command: {text.lower()}", line),)
    return (DeviceNotice("command accepted", line),) if line == b"SUCCESS" else ()


def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
    """Return the line of a gauge that shows ``text``."""
    sign, digits = show_digits(text, digits=7, decimals=DIALECT.decimals, fill=" ")
    name = spell(unit, {"mm": "MM", "inch": "IN"}, key=DIALECT.key)
    return f"{sign}{digits}, {name}\r\n".encode("ascii")


DIALECT = Dialect(
    key="cdi-starrett-iq",
    instruments="Chicago Dial Indicator Logic, Starrett IQ (USB, RS232 or UART)",
    cable=(
        "USB (appears as a COM port), RS232 or UART cable of the maker; the gauge needs "
        "outside power"
    ),
    line=LineSettings(9600, 8, "N", 1),
    parse=parse,
    compose=compose,
    terminator=b"\r\n",
    longest_frame=13,
    digits=7,
    decimals=(4, 1, 2, 3, 5),
    units=("mm", "inch"),
    request_template=b"R\r",
    source="CDI USB and RS232 communication protocol; Starrett IQ manual p. 17",
    confidence="high",
    unverified=(
        "blanks between digits, which CDI's note allows 'for readability', are refused",
        "whether a value held by H is marked (send no H)",
    ),
)
