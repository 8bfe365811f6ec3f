"""Mitutoyo U-WAVE-R, the radio receiver: ``DT10005+00000020.06M`` when a DATA key is pressed.

Source: U-WAVEPAK manual 99MAL216A 6.1 as implemented by Ihorhaleliuka/Mitutoyo-U-WAVE-R, and
UWaveStrategy of ramso-adnarim/SelectML, which agree: ``DT1``, group, channel, sign, eleven
characters with the point, unit ``M``, ``I`` or ``0``.
"""

from __future__ import annotations

import re

from scara_iso.recorder.indicators._dialect import (
    DeviceNotice,
    Event,
    InstrumentFault,
    LineSettings,
)
from scara_iso.recorder.indicators._grammar import line_dialect

_STATUS = re.compile(rb"ST1(\d\d|FF)(\d\d|FF)([0-9A-F]{10})(\d\d)")
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


def _status(line: bytes) -> tuple[Event, ...]:
    found = _STATUS.fullmatch(line)
    if found is None:
        return ()
    group, channel, _, code = found.groups()
    message = _CODES.get(code, "unknown status")
    if code in (b"00", b"51"):
        return (DeviceNotice(message, line),)
    whose = None if b"FF" in (group, channel) else (group + channel).decode("ascii")
    return (InstrumentFault(f"ST1 {code.decode()}", message, line, whose),)


DIALECT = line_dialect(
    key="mitutoyo-uwave",
    instruments="Mitutoyo U-WAVE-R receiver (virtual COM port), readings sent by the DATA key",
    cable="USB of the receiver; the transmitter's DATA key sends",
    line=LineSettings(57600, 8, "N", 1),
    reading=rb"DT1(?P<channel>\d{4})"
    rb"(?P<sign>[+-])(?=[\d.]{11}[MI0]\Z)(?P<digits>\d+\.\d+)(?P<unit>[MI0])",
    form="DT1{channel}{sign}{digits}{unit}",
    units={"mm": "M", "inch": "I", None: "0"},
    other=_status,
    longest_frame=20,
    digits=10,
    decimals=(3, 1, 2, 4, 5, 6),
    channels=tuple(f"{number:04}" for number in range(10_000)),
    source="Mitutoyo U-WAVEPAK 99MAL216A 6.1 (by way of two independent programs)",
    confidence="high",
    unverified=("status codes: one program; the manual itself was not read",),
)
