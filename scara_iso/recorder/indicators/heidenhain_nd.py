"""Heidenhain ND 2xx display units: ``-      5.23  =A``.

Source: Heidenhain ND 281 B manual p. 47: sign; ten characters with the point, leading zeros as
blanks; blank; unit (blank mm, ``"`` inch, ``?`` fault); sorting; series (S MIN, A ACTL, G MAX,
D DIFF); CR LF. Ctrl-B calls the value.
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

_READING = re.compile(rb'(?=.{15}\Z)([+-])( *\d*\.\d+) ([ "?])([<=>? ])([SAGD ])')
_UNITS = {b" ": "mm", b'"': "inch"}
_SERIES = {b"S": "minimum", b"G": "maximum", b"D": "difference"}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line says; minimum, maximum and difference of a series are faults."""
    if found := _READING.fullmatch(line):
        sign, digits, unit, sorting, series = found.groups()
        if unit == b"?":
            return (InstrumentFault("?", "the display reports a fault (ENQ asks which)", line),)
        if series in _SERIES:
            message = f"{_SERIES[series]} of a series, not the reading"
            return (InstrumentFault(series.decode(), message, line),)
        mode = None if sorting == b" " else sorting.decode("ascii")
        return (Reading(decimal_text(sign, digits), _UNITS[unit], None, mode, line),)
    if line[:1] == b"\x15":
        return (InstrumentFault("NAK", "the display refused a command", line),)
    return ()


def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
    """Return the line of a display that shows ``text``."""
    sign, digits = show_digits(text, digits=9, decimals=DIALECT.decimals, fill=" ")
    mark = spell(unit, {"mm": " ", "inch": '"'}, key=DIALECT.key)
    return f"{sign}{digits} {mark}  \r\n".encode("ascii")


DIALECT = Dialect(
    key="heidenhain-nd",
    instruments="Heidenhain ND 2xx B display units with a length gauge",
    cable="RS-232-C socket of the display",
    line=LineSettings(9600, 7, "E", 2),
    parse=parse,
    compose=compose,
    terminator=b"\r\n",
    longest_frame=15,
    digits=9,
    decimals=(4, 1, 2, 3, 5, 6),
    units=("mm", "inch"),
    request_template=b"\x02",
    answer_time_s=0.3,
    source="Heidenhain ND 281 B manual p. 47; ND 281 B v1 p. 42; ND 221 B p. 34",
    confidence="high",
    unverified=(
        "the baud rate is parameter P50 of the display",
        "ND 280 and ND 287 (whose format can be changed in its menu)",
    ),
)
