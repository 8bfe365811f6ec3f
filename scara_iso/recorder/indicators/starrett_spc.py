"""Old Starrett SPC output (TTL level): 25 characters at 1200 baud, bit 8 undefined.

Source: Matronics converter, DiagramRev2.pdf: 13 blanks, sign (blank or ``-``), seven characters
with the point, blank, ``in`` or ``mm``, CR. One reverse-engineered source.
"""

from __future__ import annotations

import re

from scara_iso.recorder.indicators._dialect import Dialect, Event, LineSettings, Reading
from scara_iso.recorder.indicators._grammar import UNITS, decimal_text, show_digits, spell

_READING = re.compile(rb" {13}([ -])(?=[ \d.]{7} [im])( *\d*\.\d+) (in|mm)")


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line, bit 8 cleared, says."""
    if found := _READING.fullmatch(line):
        sign, digits, unit = found.groups()
        return (Reading(decimal_text(sign, digits), UNITS[unit], None, None, line),)
    return ()


def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
    """Return the line of a gauge that shows ``text``."""
    sign, digits = show_digits(text, digits=6, decimals=DIALECT.decimals, fill=" ")
    name = spell(unit, {"mm": "mm", "inch": "in"}, key=DIALECT.key)
    return f"{' ' * 13}{'-' if sign == '-' else ' '}{digits} {name}\r".encode("ascii")


DIALECT = Dialect(
    key="starrett-spc",
    instruments="old Starrett gauges with SPC output (TTL level: needs a level converter)",
    cable="SPC connector through a level converter (TTL, not RS-232)",
    line=LineSettings(1200, 8, "N", 2),
    parse=parse,
    compose=compose,
    longest_frame=24,
    digits=6,
    decimals=(3, 1, 2, 4, 5),
    units=("mm", "inch"),
    bit_8_undefined=True,
    source="Matronics converter, DiagramRev2.pdf",
    confidence="medium",
    unverified=("everything: one reverse-engineered source", "what an error looks like"),
)
