"""What dialects share: decimal numbers, the spelling of units, and lines described by patterns.

No source met so far sends a decimal comma, an exponent or a digit that is not ASCII on a serial
line; a dialect's pattern takes none of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from scara_iso.base.errors import UsageError
from scara_iso.base.published import fill
from scara_iso.recorder.indicators._dialect import (
    DeviceNotice,
    Dialect,
    Event,
    InstrumentFault,
    LineSettings,
    Reading,
)

UNITS = {b"mm": "mm", b"in": "inch", b"inch": "inch", b"um": "um", b"deg": "deg", b"rad": "rad"}
"""Units by their spelling on the wire, in lower case."""

_DECIMAL = re.compile(r"(-?)([0-9]+)(?:\.([0-9]+))?")


def decimal_text(sign: bytes, digits: bytes) -> str:
    """Return the number that a display shows: ``-``, no leading zeros or blanks, all decimals.

    ``sign`` is ``-`` or anything that means plus; ``digits`` holds digits and at most one point or
    comma.
    """
    text = digits.decode("ascii").replace(",", ".").lstrip("0 ").removesuffix(".")
    if text[:1] in ("", "."):
        text = "0" + text
    return "-" + text if sign == b"-" else text


def show_digits(
    text: str, *, digits: int, decimals: Collection[int], fill: str = "0"
) -> tuple[str, str]:
    """Return sign (``+`` or ``-``) and digits of ``text`` as a display of fixed width sends them.

    The result has ``digits`` digits and the point. Raises `UsageError` for what is no decimal
    number, does not fit, or has a number of decimals that the display does not have.
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
    return found[1] or "+", f"{whole}.{fraction}".rjust(digits + 1, fill)


Parse = Callable[[bytes], tuple[Event, ...]]


@dataclass(frozen=True, slots=True)
class FaultLine:
    """A line, or a part of one, that is no reading, and why.

    ``messages`` are chosen by the pattern's group ``kind``, that of ``""`` for any other.
    ``code`` is made of the pattern's groups; its group ``channel`` says whose fault it is.
    """

    pattern: bytes
    messages: str | Mapping[str, str]
    code: str = "{line}"

    def event(self, found: re.Match[bytes]) -> InstrumentFault:
        """Return what a matching line says."""
        groups = {name: _text(group or b"") for name, group in found.groupdict().items()}
        message = self.messages
        if not isinstance(message, str):
            message = message.get(groups["kind"], message.get("", "unknown error"))
        code = self.code.format(line=_text(found[0]), **groups)
        return InstrumentFault(code, message, found.string, groups.get("channel"))


@dataclass(frozen=True, slots=True, kw_only=True)
class LineGrammar:
    """The lines of an instrument, described by patterns, each of a whole line."""

    reading: bytes
    """A line with the group ``digits`` and, where it states them, ``sign``, ``places`` (how many
    digits follow the point, where none is sent), ``high`` (more digits, before them), ``unit``,
    ``channel`` and ``mode``."""
    form: str
    """That line as it is sent, with ``{sign}``, ``{digits}``, ``{unit}`` and ``{channel}``; with
    ``{number}`` for a number without leading blanks and plus, ``{figures}`` and ``{places}`` for
    one without a point."""
    units: Mapping[str | None, str]
    """How a unit is written."""
    also: Mapping[bytes, str] = field(default_factory=dict)
    """Units by other spellings, which are read."""
    signs: tuple[str, str] = ("+", "-")
    """Plus and minus."""
    fill: str = "0"
    """What stands for leading zeros."""
    modes: Mapping[bytes, str] = field(default_factory=dict)
    """The meaning of what ``mode`` holds; otherwise it is shown as sent."""
    refused: Mapping[str, Mapping[bytes, str]] = field(default_factory=dict)
    """By group, which contents make a fault of a reading, and why."""
    faults: Sequence[FaultLine] = ()
    """They come before readings: what an instrument calls an error is no number."""
    notices: Sequence[bytes] = ()
    """Lines that may have the groups ``unit``, ``low`` (the battery) and ``on`` (switched on)."""
    between: bytes | None = None
    """What parts several values of a line, each of a channel of its own, where there may be more
    than one: a part that is none of the above spoils all."""
    other: Parse = lambda _: ()
    """Takes a line that is none of these."""
    spelt: Mapping[bytes, str | None] = field(init=False, repr=False)
    """Units by all their spellings."""

    def __post_init__(self) -> None:
        sent = {word.encode(): unit for unit, word in self.units.items()}
        fill(self, spelt={**UNITS, **sent, **self.also})

    def parser(self) -> Parse:
        """Return the function from a line to its events."""
        end = rb"\Z" if self.between is None else rb"\Z|" + self.between
        makers: list[tuple[bytes, Callable[[re.Match[bytes]], Event]]] = [
            *((fault.pattern, fault.event) for fault in self.faults),
            (self.reading, self._value),
            *((pattern, self._notice) for pattern in self.notices),
        ]
        known = [(re.compile(rb"(?:%b)(?=%b)" % (one, end)), make) for one, make in makers]

        def parse(line: bytes) -> tuple[Event, ...]:
            events: list[Event] = []
            at = 0
            while at <= len(line):
                for pattern, make in known:
                    if found := pattern.match(line, at):
                        events.append(make(found))
                        at = found.end() + 1
                        break
                else:
                    return self.other(line)
            channels = {getattr(event, "channel", None) for event in events}
            return tuple(events) if len(channels) == len(events) else ()

        return parse

    def compose(self, dialect: Dialect, text: str, unit: str | None, channel: str | None) -> bytes:
        """Return the line by which an instrument shows a value; raises as `show_digits`."""
        sign, digits = show_digits(
            text, digits=dialect.digits, decimals=dialect.decimals, fill=self.fill
        )
        if unit not in self.units:
            known = ", ".join(map(str, self.units))
            raise UsageError(f"{dialect.key} cannot state {unit}", remedy=f"it knows {known}")
        line = self.form.format(
            sign=self.signs[sign == "-"],
            digits=digits,
            number=sign.strip("+") + digits.lstrip(),
            figures=digits.replace(".", ""),
            places=len(text.partition(".")[2]),
            unit=self.units[unit],
            channel=channel or dialect.channel or "".join(dialect.channels[:1]),
        )
        return line.encode("ascii") + dialect.terminator

    def _value(self, found: re.Match[bytes]) -> Event:
        """Return the reading that a line is, or the fault where it holds another value."""
        groups = found.groupdict()
        channel = _name(groups.get("channel"))
        for group, messages in self.refused.items():
            if message := messages.get(groups[group]):
                return InstrumentFault(_text(groups[group]), message, found.string, channel)
        digits = (groups.get("high") or b"") + groups["digits"]
        if "places" in groups:
            point = len(digits) - int(groups["places"])
            digits = digits[:point] + b"." + digits[point:]
        minus = groups.get("sign") == self.signs[1].encode()
        mode = (groups.get("mode") or b"").strip()
        return Reading(
            decimal_text(b"-" if minus else b"", digits),
            self._unit(groups.get("unit")),
            channel,
            self.modes.get(mode, _name(mode)) or None,
            found.string,
        )

    def _notice(self, found: re.Match[bytes]) -> DeviceNotice:
        groups = found.groupdict()
        message = _text(found.string) + ": battery low" * bool(groups.get("low"))
        unit = self._unit(groups.get("unit"))
        return DeviceNotice(message, found.string, unit, switched_on=bool(groups.get("on")))

    def _unit(self, word: bytes | None) -> str | None:
        if word is None:
            return None
        return self.spelt[word if word in self.spelt else word.strip().lower()]


def line_dialect(**fields: Any) -> Dialect:
    """Return a dialect of such lines; ``fields`` are those of `LineGrammar` and `Dialect`.

    ``line`` may be a text as ``9600 8N1``.
    """
    lines = LineGrammar(
        **{name: fields.pop(name) for name in LineGrammar.__slots__ if name in fields}
    )

    def compose(text: str, unit: str | None, channel: str | None) -> bytes:
        return lines.compose(dialect, text, unit, channel)

    if isinstance(fields["line"], str):
        fields["line"] = LineSettings.of(fields["line"])
    dialect = Dialect(parse=lines.parser(), compose=compose, units=tuple(lines.units), **fields)
    return dialect


def _text(data: bytes) -> str:
    return data.decode("ascii").strip()


def _name(data: bytes | None) -> str | None:
    return None if data is None else data.decode("ascii")
