"""Metro Mux4 and Mux8: ``V2: mm       -00001.250000``.

Source: Metro Datavac Mux4 manual: ``Vx: uuuu ttt seeeee.dddddd`` CR LF; ``1`` to ``8`` without CR
asks a channel; ``Nxy:Ex`` is an error (E1 communication, E3 reading).
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

_READING = re.compile(rb"V([1-8]): (mm  |in  |inch|um  ) ([ -~]{3}) ([+-])(\d{5}\.\d{6})")
_FAULT = re.compile(rb"N([1-8])[ -~]?:E(\d)")
_FAULTS = {b"1": "communication error", b"3": "reading error"}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line says."""
    if found := _READING.fullmatch(line):
        channel, unit, kind, sign, digits = found.groups()
        if kind != b"   ":
            # The source does not explain this field; its only example leaves it blank.
            code = kind.decode("ascii").strip()
            return (InstrumentFault(code, f"value of type {code}", line, channel.decode()),)
        text = decimal_text(sign, digits)
        return (Reading(text, UNITS[unit.rstrip()], channel.decode(), None, line),)
    if found := _FAULT.fullmatch(line):
        code, message = f"E{found[2].decode()}", _FAULTS.get(found[2], "unknown error")
        return (InstrumentFault(code, message, line, found[1].decode()),)
    return ()


def compose(text: str, unit: str | None, channel: str | None) -> bytes:
    """Return the line of a multiplexer whose gauge shows ``text``."""
    sign, digits = show_digits(text, digits=11, decimals=DIALECT.decimals)
    name = spell(unit, {"mm": "mm", "inch": "in", "um": "um"}, key=DIALECT.key)
    return f"V{channel or 1}: {name:4}     {sign}{digits}\r\n".encode("ascii")


DIALECT = Dialect(
    key="metro-mux",
    instruments="Metro Mux4 and Mux8 multiplexers",
    cable="USB of the multiplexer (COM port)",
    line=LineSettings(9600, 8, "N", 1),
    parse=parse,
    compose=compose,
    terminator=b"\r\n",
    longest_frame=26,
    digits=11,
    decimals=(6,),
    units=("mm", "inch", "um"),
    request_template=b"{channel}",
    channels=tuple("12345678"),
    channel="1",
    source="Metro Datavac Mux4 manual (frame; errors p. 7)",
    confidence="high",
    unverified=(
        "line settings (the multiplexer is on USB)",
        "how inch and um are spelt, and the field between unit and value (blank is taken)",
    ),
)
