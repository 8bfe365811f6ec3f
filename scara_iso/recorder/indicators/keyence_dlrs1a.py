"""Keyence GT2 and GT-70A through the DL-RS1A: ``SR,00,002,+012.3456``.

Source: Keyence DL-RS1A manual pp. 9-13: ``SR,ID,NNN`` reads data number NNN of unit ID (002 is the
raw value R.V., 000 the comparator value P.V., which may be held); ``M0`` reads every unit; ``ER``
is an error. Nine characters on the GT2, eight on the GT-70A. The unit is not sent.
"""

from __future__ import annotations

import re
from dataclasses import replace

from scara_iso.recorder.indicators._dialect import (
    Dialect,
    Event,
    InstrumentFault,
    LineSettings,
    Reading,
)
from scara_iso.recorder.indicators._grammar import Compose, Parse, decimal_text, show_digits, spell

_FAULT = re.compile(rb"ER,([A-Z0-9]{2}),(\d\d)")
_FAULTS = {
    b"00": "invalid command",
    b"20": "wrong length",
    b"21": "wrong number of parameters",
    b"22": "wrong parameter",
    b"29": "communication error",
    b"65": "no such unit",
}
# The manual's table of special values is cut off in the copies. Its sister SK-1000 sends letters
# for an amplifier error, and all nines for over and under range.
_LETTERS = re.compile(rb"[+-]E{2,4}\.E{2,5}")
_NINES = re.compile(rb"[+-]0?9+\.9+")


def _parser(field: bytes) -> Parse:
    one = rb"(?:[+-]" + field + rb"|[+-]E{2,4}\.E{2,5})"
    single = re.compile(rb"SR,(\d\d),(000|002),(" + one + rb")")
    every = re.compile(rb"M0((?:," + one + rb"){1,15})")

    def parse(line: bytes) -> tuple[Event, ...]:
        if found := single.fullmatch(line):
            mode = "R.V." if found[2] == b"002" else "P.V."
            return (_value(found[3], found[1].decode("ascii"), mode, line),)
        if found := every.fullmatch(line):
            fields = found[1][1:].split(b",")
            return tuple(_value(f, f"{unit:02}", "P.V.", line) for unit, f in enumerate(fields))
        if found := _FAULT.fullmatch(line):
            message = _FAULTS.get(found[2], "unknown error")
            return (InstrumentFault(f"ER {found[2].decode()}", message, line),)
        return ()

    return parse


def _value(field: bytes, channel: str, mode: str, line: bytes) -> Event:
    if _LETTERS.fullmatch(field):
        return InstrumentFault(field.decode(), "error of the amplifier", line, channel)
    if _NINES.fullmatch(field):
        return InstrumentFault(field.decode(), "out of range", line, channel)
    return Reading(decimal_text(field[:1], field[1:]), None, channel, mode, line)


def _composer(decimals: int) -> Compose:
    def compose(text: str, unit: str | None, channel: str | None) -> bytes:
        spell(unit, {None: ""}, key="keyence-dlrs1a")
        sign, digits = show_digits(text, digits=3 + decimals, decimals=(decimals,))
        return f"SR,{channel or '00'},002,{sign}{digits}\r\n".encode("ascii")

    return compose


_GT2 = Dialect(
    key="keyence-dlrs1a",
    instruments="Keyence GT2 through DL-RS1A",
    cable="DL-RS1A communication unit, RS-232",
    line=LineSettings(9600, 8, "N", 1),
    parse=_parser(rb"\d{3}\.\d{4}"),
    compose=_composer(4),
    terminator=b"\r\n",
    longest_frame=2 + 15 * 10,
    digits=7,
    decimals=(4,),
    units=(None,),
    request_template=b"SR,{channel},002\r\n",
    channels=tuple(f"{number:02}" for number in range(15)),
    channel="00",
    source="Keyence DL-RS1A manual pp. 9-13",
    confidence="high",
    unverified=("the table of special values (letters and all nines are refused)",),
)

_GT70A = replace(
    _GT2,
    key="keyence-dlrs1a-gt70a",
    instruments="Keyence GT-70A through DL-RS1A",
    cable="DL-RS1A communication unit, RS-232",
    parse=_parser(rb"\d{3}\.\d{3}"),
    compose=_composer(3),
    longest_frame=2 + 15 * 9,
    digits=6,
    decimals=(3,),
)

DIALECTS = (_GT2, _GT70A)
