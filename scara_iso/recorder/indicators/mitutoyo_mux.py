"""Mitutoyo MUX-10 text frames: ``01A+0000.123``.

Source: Mitutoyo QM-Height 99MAF600B p. 67: D1 code "0", D2 channel, D3 item "A", D4 sign, D5-D12
data with a floating point, D13 CR. ASD GageMux manual p. 6 agrees. The unit is not sent.
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
from scara_iso.recorder.indicators._grammar import decimal_text, show_digits, spell

_READING = re.compile(rb"0([1-9])A([+-])(?=[\d.]{8}\Z)(\d+\.\d+)")
_FAULT = re.compile(rb"9([1-9])(\d)")
_FAULTS = {b"1": "no data", b"2": "format error", b"9": "system error"}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line says; ``911`` is "channel 1, no data" and never the number 911."""
    if found := _READING.fullmatch(line):
        channel, sign, digits = found.groups()
        return (Reading(decimal_text(sign, digits), None, channel.decode("ascii"), None, line),)
    if found := _FAULT.fullmatch(line):
        code, channel = line.decode("ascii"), found[1].decode("ascii")
        return (InstrumentFault(code, _FAULTS.get(found[2], "unknown fault"), line, channel),)
    return ()


def compose(text: str, unit: str | None, channel: str | None) -> bytes:
    """Return the frame of an interface whose gauge shows ``text``."""
    spell(unit, {None: ""}, key=DIALECT.key)
    sign, digits = show_digits(text, digits=7, decimals=DIALECT.decimals)
    return f"0{channel or 1}A{sign}{digits}\r".encode("ascii")


DIALECT = Dialect(
    key="mitutoyo-mux",
    instruments="Mitutoyo MUX-10F, USB-ITN (virtual COM port), QM-Height USB, GageMux",
    cable=(
        "USB or RS-232 of the interface. USB-ITN: install the maker's virtual COM port "
        "(Windows); on Linux it is a keyboard and shows no port"
    ),
    line=LineSettings(9600, 8, "N", 1),
    parse=parse,
    compose=compose,
    longest_frame=12,
    digits=7,
    decimals=(3, 1, 2, 4, 5, 6),
    units=(None,),
    request_template=b"{channel}\r",
    channels=tuple("123456789"),
    channel="1",
    answer_time_s=2.5,
    source="Mitutoyo QM-Height 99MAF600B p. 67; ASD GageMux p. 6; faults: mitutoyo_reader",
    confidence="high",
    unverified=(
        "the request of the MUX-10F (channel digit and CR is what the USB-ITN takes)",
        "the meaning of the fault codes (read from a program, not from a manual)",
    ),
)
