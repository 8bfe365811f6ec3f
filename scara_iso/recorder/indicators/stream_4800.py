"""Low-cost USB cables that send without being asked: sign, seven digits, point.

Source: INSPEC 711-201B USB interface, seller's page: 4800 baud, 8 data bits, 1 stop bit, ten bytes
every 300 ms, beginning with + or - followed by seven digits and a point. No unit.
"""

from __future__ import annotations

import re

from scara_iso.recorder.indicators._dialect import Dialect, Event, LineSettings, Reading
from scara_iso.recorder.indicators._grammar import decimal_text, show_digits, spell

_READING = re.compile(rb"([+-])(?=[\d.]{8}\Z)(\d+\.\d+)")


def parse(line: bytes) -> tuple[Event, ...]:
    """Return what one line says."""
    if found := _READING.fullmatch(line):
        return (Reading(decimal_text(found[1], found[2]), None, None, None, line),)
    return ()


def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
    """Return the line of a cable whose gauge shows ``text``."""
    spell(unit, {None: ""}, key=DIALECT.key)
    sign, digits = show_digits(text, digits=7, decimals=DIALECT.decimals)
    return f"{sign}{digits}\r".encode("ascii")


DIALECT = Dialect(
    key="stream-4800",
    instruments="INSPEC 711-201B and similar USB cables that send all the time",
    cable="the USB cable of the gauge",
    line=LineSettings(4800, 8, "N", 1),
    parse=parse,
    compose=compose,
    longest_frame=9,
    digits=7,
    decimals=(3, 1, 2, 4, 5, 6),
    units=(None,),
    source="INSPEC 711-201B, seller's page",
    confidence="low",
    unverified=(
        "the line end (CR is a guess; CR, LF and both are taken)",
        "what an error looks like",
        "a value may be 0.3 s old when it arrives",
    ),
)
