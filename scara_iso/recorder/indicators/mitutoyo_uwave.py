"""Mitutoyo U-WAVE-R, the radio receiver: ``DT10005+00000020.06M`` when a DATA key is pressed.

Source: U-WAVEPAK manual 99MAL216A 6.1 as implemented by Ihorhaleliuka/Mitutoyo-U-WAVE-R, and
UWaveStrategy of ramso-adnarim/SelectML, which agree: ``DT1``, group, channel, sign, eleven
characters with the point, unit ``M``, ``I`` or ``0``.
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

_READING = re.compile(rb"DT1(\d{4})([+-])(?=[\d.]{11}[MI0]\Z)(\d+\.\d+)([MI0])")
_STATUS = re.compile(rb"ST1(\d\d|FF)(\d\d|FF)([0-9A-F]{10})(\d\d)")
_UNITS = {b"M": "mm", b"I": "inch", b"0": None}
_CODES = {
    b"00": "battery low",
    b"01": "instrument does not answer",
    b"02": "unregistered transmitter",
    b"03": "measurement lost",
    b"04": "transmitter disconnected",
    b"05": "no data",
    b"50": "request packet error",
    b"51": "end of search",
    b"99": "data cancelled",
}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one packet says; the channel is group and channel, four digits."""
    if found := _READING.fullmatch(line):
        channel, sign, digits, unit = found.groups()
        text = decimal_text(sign, digits)
        return (Reading(text, _UNITS[unit], channel.decode("ascii"), None, line),)
    if found := _STATUS.fullmatch(line):
        group, channel, _, code = found.groups()
        message = _CODES.get(code, "unknown status")
        if code in (b"00", b"51"):
            return (DeviceNotice(message, line),)
        whose = None if b"FF" in (group, channel) else (group + channel).decode("ascii")
        return (InstrumentFault(f"ST1 {code.decode()}", message, line, whose),)
    return ()


def compose(text: str, unit: str | None, channel: str | None) -> bytes:
    """Return the packet of a transmitter whose gauge shows ``text``."""
    sign, digits = show_digits(text, digits=10, decimals=DIALECT.decimals)
    letter = spell(unit, {"mm": "M", "inch": "I", None: "0"}, key=DIALECT.key)
    return f"DT1{channel or '0000'}{sign}{digits}{letter}\r".encode("ascii")


DIALECT = Dialect(
    key="mitutoyo-uwave",
    instruments="Mitutoyo U-WAVE-R receiver (virtual COM port), readings sent by the DATA key",
    cable="USB of the receiver; the transmitter's DATA key sends",
    line=LineSettings(57600, 8, "N", 1),
    parse=parse,
    compose=compose,
    longest_frame=20,
    digits=10,
    decimals=(3, 1, 2, 4, 5, 6),
    units=("mm", "inch", None),
    channels=tuple(f"{number:04}" for number in range(10_000)),
    source="Mitutoyo U-WAVEPAK 99MAL216A 6.1 (by way of two independent programs)",
    confidence="high",
    unverified=("status codes: one program; the manual itself was not read",),
)
