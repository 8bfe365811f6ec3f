"""What dialects share: decimal numbers, the spelling of units, and lines described by patterns.

No source met so far sends a decimal comma, an exponent or a digit that is not ASCII on a serial
line; a dialect's pattern takes none of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from scara_iso.base.errors import UsageError
from scara_iso.recorder.indicators._dialect import (
    DeviceNotice,
    Dialect,
    Event,
    InstrumentFault,
    Reading,
)

UNITS = {b"mm": "mm", b"in": "inch", b"inch": "inch", b"um": "um", b"deg": "deg", b"rad": "rad"}
"""Units by their spelling on the wire, in lower case."""

_DECIMAL = re.compile(r"(-?)([0-9]+)(?:\.([0-9]+))?")


def decimal_text(sign: bytes, digits: bytes) -> str:
    """Return the number that a display shows: ``-``, no leading zeros or blanks, all decimals.

    ``sign`` is ``-`` or anything that means plus; ``digits`` holds digits and at most one point.
    """
    text = digits.decode("ascii").lstrip("0 ").removesuffix(".")
    if text[:1] in ("", "."):
        text = "0" + text
    return "-" + text if sign == b"-" else text


def show_digits(
    text: str, *, digits: int, decimals: Collection[int], point: bool = True, fill: str = "0"
) -> tuple[str, str]:
    """Return sign (``+`` or ``-``) and digits of ``text`` as a display of fixed width sends them.

    The result has ``digits`` digits and, if ``point``, the point. Raises `UsageError` for what is
    no decimal number, does not fit, or has a number of decimals that the display does not have.
    """
    found = _DECIMAL.fullmatch(text)
    if found is None:
        raise UsageError(f"{text!r} is not a decimal number")
    whole, fraction = found[2].lstrip("0"), found[3] or ""
    if len(fraction) not in decimals or len(whole) + len(fraction) > digits:
        raise UsageError(
            f"{text} does not fit a display of {digits} digits",
            remedy=f"decimals: {', '.join(map(str, decimals))}",
        )
    if not whole and len(fraction) < digits:
        whole = "0"
    shown = f"{whole}.{fraction}" if point else whole + fraction
    return found[1] or "+", shown.rjust(digits + point, fill)


def spell(unit: str | None, spellings: Mapping[str | None, str], *, key: str) -> str:
    """Return how dialect ``key`` writes ``unit``; `UsageError` where it has no word for it."""
    if unit not in spellings:
        known = ", ".join(str(name) for name in spellings)
        raise UsageError(f"{key} cannot state the unit {unit}", remedy=f"it knows {known}")
    return spellings[unit]


Parse = Callable[[bytes], tuple[Event, ...]]
Compose = Callable[[str, str | None, str | None], bytes]
Messages = Mapping[bytes, str]


def line_dialect(
    *,
    reading: bytes,
    form: str,
    units: Mapping[str | None, str],
    fill: str = "0",
    refused: Mapping[str, Messages] | None = None,
    faults: Mapping[bytes, Messages] | None = None,
    notices: Sequence[bytes] = (),
    other: Parse = lambda _: (),
    **fields: Any,
) -> Dialect:
    """Return a dialect whose lines are described by patterns, each of a whole line.

    ``reading`` has the group ``digits`` and, where the line states them, ``sign``, ``unit``,
    ``channel`` and ``mode``. ``form`` is that line as a display sends it, with ``{sign}``
    (or ``{minus}``, where a plus is a blank), ``{digits}``, ``{unit}`` and ``{channel}``; ``fill``
    stands for leading zeros, and ``units`` says how a unit is written. ``refused`` says of a group
    which contents make a fault of a reading. A pattern of ``faults`` may have the groups
    ``channel``, ``code`` and ``kind``, which chooses the message. ``notices`` may have ``unit``;
    ``other`` takes what none of these matches. ``fields`` are those of `Dialect`.
    """
    spelt = UNITS | {word.encode(): unit for unit, word in units.items()}
    whole, refusals = re.compile(reading), refused or {}
    others = [(re.compile(pattern), messages) for pattern, messages in (faults or {}).items()]
    noticed = [re.compile(pattern) for pattern in notices]

    def parse(line: bytes) -> tuple[Event, ...]:
        if found := whole.fullmatch(line):
            return (_value(found, refusals, spelt),)
        for pattern, messages in others:
            if found := pattern.fullmatch(line):
                return (_fault(found, messages),)
        for pattern in noticed:
            if found := pattern.fullmatch(line):
                unit = found.groupdict().get("unit")
                name = None if unit is None else spelt[unit]
                return (DeviceNotice(_text(line), line, name),)
        return other(line)

    def compose(text: str, unit: str | None, channel: str | None) -> bytes:
        sign, digits = show_digits(
            text, digits=dialect.digits, decimals=dialect.decimals, fill=fill
        )
        line = form.format(
            sign=sign,
            minus=sign.replace("+", " "),
            digits=digits,
            unit=spell(unit, units, key=dialect.key),
            channel=channel or dialect.channel or "".join(dialect.channels[:1]),
        )
        return line.encode("ascii") + dialect.terminator

    dialect = Dialect(parse=parse, compose=compose, units=tuple(units), **fields)
    return dialect


def _value(
    found: re.Match[bytes], refused: Mapping[str, Messages], spelt: Mapping[bytes, str | None]
) -> Event:
    """Return the reading that a line is, or the fault where it holds another value."""
    said = found.groupdict()
    channel, mode = said.get("channel"), (said.get("mode") or b"").strip()
    for group, messages in refused.items():
        if message := messages.get(said[group]):
            return InstrumentFault(_text(said[group]), message, found.string, _name(channel))
    unit = said.get("unit")
    name = None if unit is None else spelt[unit] if unit in spelt else spelt[unit.strip().lower()]
    text = decimal_text(said.get("sign") or b"", said["digits"])
    return Reading(text, name, _name(channel), _name(mode or None), found.string)


def _fault(found: re.Match[bytes], messages: Messages) -> InstrumentFault:
    said = found.groupdict()
    code = said.get("code", found.string)
    message = messages.get(said.get("kind", code), messages.get(b"", "unknown fault"))
    return InstrumentFault(_text(code), message, found.string, _name(said.get("channel")))


def _text(data: bytes) -> str:
    return data.decode("ascii").strip()


def _name(data: bytes | None) -> str | None:
    return None if data is None else data.decode("ascii")
