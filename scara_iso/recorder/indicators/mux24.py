"""MUX 2 and MUX 4: ``1 MW+003.4665 inch``; ``3 TO 999999.99 mm`` is an error.

Source: Adept Science knowledge base, article 68CE: 9600 8N1, powered from the port's DTR line;
``1`` asks channel 1; type ``TO`` means "error reading from gauge".
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
from scara_iso.recorder.indicators._grammar import UNITS, decimal_text, show_digits, spell

_READING = re.compile(rb"([1-4]) MW([+\- ])(?=[\d.]{8} )(\d+\.\d+) (mm|inch)")
_OTHER = re.compile(rb"([1-4]) ([A-Z]{2})[+\- ][\d.]{8,9} (?:mm|inch)")


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line says; every type but ``MW`` is a fault."""
    if found := _READING.fullmatch(line):
        channel, sign, digits, unit = found.groups()
        text = decimal_text(sign, digits)
        return (Reading(text, UNITS[unit], channel.decode("ascii"), None, line),)
    if found := _OTHER.fullmatch(line):
        channel, kind = found.groups()
        what = "error reading the gauge" if kind == b"TO" else "no measured value"
        return (InstrumentFault(kind.decode(), what, line, channel.decode()),)
    return ()


def compose(text: str, unit: str | None, channel: str | None) -> bytes:
    """Return the line of a multiplexer whose gauge shows ``text``."""
    sign, digits = show_digits(text, digits=7, decimals=DIALECT.decimals)
    name = spell(unit, {"mm": "mm", "inch": "inch"}, key=DIALECT.key)
    return f"{channel or 1} MW{sign}{digits} {name}\r\n".encode("ascii")


DIALECT = Dialect(
    key="mux24",
    instruments="MUX 2 and MUX 4 multiplexers (powered by the DTR line)",
    cable="RS-232, powered by the port's DTR line",
    line=LineSettings(9600, 8, "N", 1, dtr=True),
    parse=parse,
    compose=compose,
    terminator=b"\r\n",
    longest_frame=19,
    digits=7,
    decimals=(4, 1, 2, 3, 5, 6),
    units=("mm", "inch"),
    request_template=b"{channel}",
    channels=("1", "2", "3", "4"),
    channel="1",
    source="Adept Science knowledge base, article 68CE",
    confidence="high",
    unverified=("types other than MW and TO (refused)", "the width of the number in mm"),
)
