"""Mitutoyo Digimatic: 13 nibbles (52 bits) that a microcontroller passes on as hexadecimal text.

Source: Mitutoyo "DIGIMATIC CODE OUTPUT I/F SPECIFICATIONS", Manual No. 4330, 6.1 and 6.2:
D1 type of data, D2-D4 F, D5 sign, D6-D11 digits, D12 decimals, D13 unit and GO/NG judgement.
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

# Some bridges print the value after the nibbles ("FFFF000566541 0.5665 in"). The nibbles say it
# all, and such a bridge calls every GO/NG frame "in": the text is not read.
_PRINTED = rb"(?: +-?\d*\.?\d+ (?:in|mm))?"
_NORMAL = re.compile(rb"FFFF([08])(\d{6})([0-5])([0-7])" + _PRINTED)
# "Digimatic 2" (QM-Height 99MAF600B p. 59): D1 = 8, D2 = F, and D3 D4 are two more digits.
_LONG = re.compile(rb"8F(\d\d)([08])(\d{6})([0-5])([0-7])" + _PRINTED)
_OTHER = re.compile(rb"([2-7])FFF[08]\d{6}[0-5][0-7]" + _PRINTED)
_NO_UNIT = re.compile(rb"FFFF[08]\d{6}[0-5][89A-F]" + _PRINTED)

_UNITS: dict[bytes, tuple[str, str | None]] = {
    b"0": ("mm", None),
    b"2": ("mm", "+NG"),
    b"3": ("mm", "GO"),
    b"4": ("mm", "-NG"),
    b"1": ("inch", None),
    b"5": ("inch", "+NG"),
    b"6": ("inch", "GO"),
    b"7": ("inch", "-NG"),
}
_TYPES = {
    b"2": "MAX of the statistics",
    b"3": "MIN of the statistics",
    b"4": "mean of the statistics",
    b"5": "sigma of the statistics",
    b"6": "MAX hold",
    b"7": "MIN hold",
}


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line of 13 nibbles says; nothing unless every nibble is in its range."""
    if found := _NORMAL.fullmatch(line):
        sign, digits, decimals, unit = found.groups()
        return (_reading(sign, digits, decimals, unit, line),)
    if found := _LONG.fullmatch(line):
        more, sign, digits, decimals, unit = found.groups()
        return (_reading(sign, more + digits, decimals, unit, line),)
    if found := _OTHER.fullmatch(line):
        return (InstrumentFault(f"D1={found[1].decode()}", f"{_TYPES[found[1]]} value", line),)
    if _NO_UNIT.fullmatch(line):
        # A dial always has a unit; nibble 8 is also what inch becomes with its bits reversed.
        return (InstrumentFault("D13", "the frame states no unit", line),)
    return ()


def _reading(sign: bytes, digits: bytes, decimals: bytes, unit: bytes, line: bytes) -> Reading:
    point = len(digits) - int(decimals)
    name, judgement = _UNITS[unit]
    text = decimal_text(b"-" if sign == b"8" else b"", digits[:point] + b"." + digits[point:])
    return Reading(text, name, None, judgement, line)


def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
    """Return the line a bridge sends for a gauge that shows ``text``."""
    sign, digits = show_digits(text, digits=6, decimals=DIALECT.decimals, point=False)
    decimals = len(text.partition(".")[2])
    nibble = spell(unit, {"mm": "0", "inch": "1"}, key=DIALECT.key)
    return f"FFFF{'8' if sign == '-' else '0'}{digits}{decimals}{nibble}\r\n".encode("ascii")


DIALECT = Dialect(
    key="digimatic-hex",
    instruments="Mitutoyo Digimatic gauges behind an Arduino or Pico bridge that sends the nibbles",
    cable=(
        "Arduino or Pico bridge on the Digimatic connector that prints the 13 nibbles as "
        "hexadecimal"
    ),
    line=LineSettings(9600, 8, "N", 1),
    parse=parse,
    compose=compose,
    terminator=b"\r\n",
    longest_frame=32,
    digits=6,
    decimals=(3, 0, 1, 2, 4, 5),
    units=("mm", "inch"),
    answer_time_s=2.5,
    source="Mitutoyo Manual No. 4330, 6.1-6.2; LSM-6200 99MBC095A p. 6-28; 99MAF600B p. 59",
    confidence="high",
    unverified=(
        "the bridge's line settings and request (this dialect listens)",
        "Digimatic 2 frames (8 digits): one source, whose own example contradicts itself",
    ),
)
