"""Mahr Federal Maxum III: `` + 1.234M  `` and a line feed.

Source: Maxum III manual 2239028 Rev D p. 51: dynamic mode (A, M, L, T with hold, a, m, l, t
without, blank for the standard product), polarity, blank, four digits with the point (or three
and a blank), M (mm) or I (inch), limit (0 above, U below), blank, LF.
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

_READING = re.compile(rb"([AMLTamlt ])([+\- ]) (\d\.\d{3}|\.\d{4}|\.\d{3}(?= ))( ?)([MI])([0OU ]) ")
_UNITS = {b"M": "mm", b"I": "inch"}
_MODES = {b"a": "actual", b"m": "maximum", b"l": "minimum", b"t": "TIR"}
_LIMITS = {b"0": "above limit", b"O": "above limit", b"U": "below limit", b" ": None}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line says; held values, maximum, minimum and TIR are faults."""
    if (found := _READING.fullmatch(line)) is None:
        return ()
    mode, sign, digits, blank, unit, limit = found.groups()
    if len(digits + blank) != 5:
        return ()
    if mode not in b"a ":
        hold = " on hold" if mode.isupper() else ""
        message = f"{_MODES[mode.lower()]} value{hold}, not the reading"
        return (InstrumentFault(mode.decode(), message, line),)
    return (Reading(decimal_text(sign, digits), _UNITS[unit], None, _LIMITS[limit], line),)


def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
    """Return the line of a gauge in standard mode that shows ``text``."""
    sign, digits = show_digits(text, digits=4, decimals=DIALECT.decimals)
    return f" {sign} {digits}{spell(unit, {'mm': 'M', 'inch': 'I'}, key=DIALECT.key)}  \n".encode()


DIALECT = Dialect(
    key="maxum",
    instruments="Mahr Federal Maxum III with cable 2239036 or 2239038",
    cable="output cable 2239036 or 2239038",
    line=LineSettings(9600, 8, "N", 1),
    parse=parse,
    compose=compose,
    terminator=b"\n",
    longest_frame=11,
    digits=4,
    decimals=(3, 4),
    units=("mm", "inch"),
    source="Mahr Federal Maxum III manual 2239028 Rev D p. 51",
    confidence="medium",
    unverified=(
        "the request (this dialect listens)",
        "how a plus sign is sent (plus or blank are taken)",
        "the bare gauge: 2400 7N2",
    ),
)
