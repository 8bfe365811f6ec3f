"""What is typed, or comes as key presses: a number with its point or comma, alone on its line.

No plug-in of this folder, since no instrument sends it on a serial line: it may have any number of
digits, so a lost one leaves no trace but the number of decimals.
"""

from __future__ import annotations

import re

from scara_iso.base.errors import UsageError
from scara_iso.recorder.indicators._dialect import Dialect, Event, LineSettings, Reading
from scara_iso.recorder.indicators._grammar import decimal_text

_READING = re.compile(rb"([+-]?)([0-9]{1,5}[.,][0-9]{1,6})")


def parse(line: bytes) -> tuple[Event, ...]:
    """Return the reading that a line spells, nothing for anything else."""
    if found := _READING.fullmatch(line.strip(b" ")):
        text = decimal_text(found[1], found[2].replace(b",", b"."))
        return (Reading(text, None, None, None, line),)
    return ()


def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
    """Return the line that types ``text``."""
    line = text.encode("ascii", "replace")
    if unit is not None or not _READING.fullmatch(line):
        raise UsageError(f"{text!r} is not a number with its decimals", remedy="write 0.812")
    return line + b"\r"


KEYBOARD = Dialect(
    key="keyboard",
    instruments="a person at the keyboard, or an indicator whose cable types its readings",
    line=LineSettings(),
    parse=parse,
    compose=compose,
    longest_frame=32,
    digits=6,
    decimals=(3, 1, 2, 4, 5),
    units=(None,),
    source="none: the grammar is this program's",
    confidence="low",
    unverified=("the digits: a line typed has no parity and no checksum",),
)
