"""Mitutoyo ID-H0530/0560 on RS-232C: ``GN01,+0016.2345``.

Source: ID-H0560 manual 99MAH016B p. 4-5: ``GA**`` asks gauge ``**``; the answer begins with GN
(normal), GX (max), GM (min) or GW (TIR). The unit is not sent.
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

_READING = re.compile(rb"G([NXMW])(\d\d),([+-])(?=[\d.]{9}\Z)(\d+\.\d+)")
_NOTICE = re.compile(rb"(?:CH|DH)\d\d(?:,(?:OK|[+-]NG|JOFF|F-LOCK))?")
_HELD = {b"X": "maximum", b"M": "minimum", b"W": "TIR (maximum less minimum)"}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one answer says; a maximum, minimum or TIR is a fault."""
    if found := _READING.fullmatch(line):
        mode, channel, sign, digits = found.groups()
        if mode in _HELD:
            message = f"the gauge sends the {_HELD[mode]}, not the reading"
            return (InstrumentFault(f"G{mode.decode()}", message, line, channel.decode()),)
        return (Reading(decimal_text(sign, digits), None, channel.decode(), None, line),)
    if _NOTICE.fullmatch(line):
        return (DeviceNotice(line.decode("ascii"), line),)
    return ()


def compose(text: str, unit: str | None, channel: str | None) -> bytes:
    """Return the answer of a gauge in normal mode that shows ``text``."""
    spell(unit, {None: ""}, key=DIALECT.key)
    sign, digits = show_digits(text, digits=8, decimals=DIALECT.decimals)
    return f"GN{channel or '01'},{sign}{digits}\r\n".encode("ascii")


DIALECT = Dialect(
    key="mitutoyo-idh",
    instruments="Mitutoyo ID-H0530 and ID-H0560, RS-232C output",
    cable="RS-232C cable of the gauge",
    line=LineSettings(9600, 8, "N", 1),
    parse=parse,
    compose=compose,
    terminator=b"\r\n",
    longest_frame=15,
    digits=8,
    decimals=(4, 1, 2, 3, 5, 6),
    units=(None,),
    request_template=b"GA{channel}\r\n",
    channels=tuple(f"{number:02}" for number in range(100)),
    channel="01",
    source="Mitutoyo ID-H0560 99MAH016B p. 4-5",
    confidence="high",
    unverified=("baud, data bits, parity and stop bits", "error replies"),
)
