"""What is said of ports, dialects and a probed line, and while a recording runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from scara_iso.diagnosis import PAUSE
from scara_iso.recorder import (
    DeviceNotice,
    Dialect,
    Event,
    Garbage,
    InstrumentFault,
    NextWay,
    Reading,
    Watched,
)
from scara_iso.reporting.blocks import Block, Report, Section, Table, Text
from scara_iso.reporting.digits import words


@dataclass(frozen=True, slots=True)
class Probe:
    """What a port sent: the bytes, and for each dialect what it makes of them."""

    port: str
    seconds: float
    line: str
    received: bytes
    events: Mapping[str, tuple[Event, ...]]

    def matches(self) -> tuple[str, ...]:
        """Return the dialects that understand every whole line and read at least one value."""
        return tuple(
            key
            for key, events in self.events.items()
            if any(isinstance(e, Reading | InstrumentFault) for e in events)
            and not any(isinstance(e, Garbage) for e in events)
        )

    def diagnosis(self) -> str | None:
        """Return what the garbage says about the parity of the line, if anything."""
        garbage = [
            e.reason for events in self.events.values() for e in events if isinstance(e, Garbage)
        ]
        return next((reason for reason in garbage if reason.startswith("looks like")), None)


def ports_report(devices: Iterable[tuple[str, str, str]]) -> Report:
    """Return the ports of this machine: name, description and USB identity of each."""
    rows = tuple(devices)
    if not rows:
        text = "No serial port was found. sim: simulates one: `gauge=X=opto-rs232@sim:`"
        return (Section("Serial ports", (Text(text),)),)
    table = Table(("port", "identity", "description"), rows)
    return (Section("Serial ports", (table,)),)


def dialects_report(dialects: Iterable[Dialect]) -> Report:
    """Return a section for each dialect: who speaks it, settings, and what is unverified."""
    return tuple(
        Section(f"{d.key} ({d.confidence} confidence)", tuple(_dialect_blocks(d))) for d in dialects
    )


def _dialect_blocks(dialect: Dialect) -> list[Block]:
    ask = _request(dialect)
    unit = (
        "in the frame"
        if dialect.sends_unit
        else ("asked for" if dialect.unit_request else "by option")
    )
    blocks: list[Block] = [
        Text(dialect.instruments),
        Text(f"line {dialect.line}, request {ask}, unit {unit}"),
        Text(f"source: {dialect.source}", "quiet"),
    ]
    if dialect.unverified:
        blocks.append(Text(f"unverified: {'; '.join(dialect.unverified)}", "bad"))
    return blocks


def _request(dialect: Dialect) -> str:
    if dialect.request_template is not None:
        return _bytes(dialect.request_template)
    pulse = dialect.request_line
    return f"pulse on {pulse.line.upper()}" if pulse else "none: sends by itself"


def probe_report(probe: Probe) -> Report:
    """Return what a probed port sent and which dialects it speaks."""
    heading = f"{probe.port} at {probe.line}, {probe.seconds:g} s"
    if not probe.received:
        text = "Nothing was received. Press DATA on the indicator, or ask: `ask=opto-rs232`"
        return (Section(heading, (Text(text, "bad"),)),)
    blocks: list[Block] = [
        Text(f"{len(probe.received)} bytes: {_bytes(probe.received)}"),
        Text(probe.received.hex(" "), "quiet"),
    ]
    blocks += [_match(key, probe.events[key]) for key in probe.matches()]
    if not probe.matches():
        blocks.append(Text("No dialect understands this.", "bad"))
    if diagnosis := probe.diagnosis():
        blocks.append(Text(diagnosis, "bad"))
    return (Section(heading, tuple(blocks)),)


def _match(key: str, events: Sequence[Event]) -> Text:
    said = [_said(event) for event in events]
    return Text(f"{key}: {', '.join(filter(None, said))}", "good")


def _said(event: Event) -> str:
    match event:
        case Reading(text=text, unit=unit, channel=channel):
            place = f" (channel {channel})" if channel else ""
            return f"{text} {unit or '(no unit)'}{place}"
        case InstrumentFault(code=code):
            return f"fault {code}"
        case DeviceNotice(message=message):
            return message
    return ""


def _bytes(data: bytes) -> str:
    return repr(data)[2:-1]


_RIVALS = 2
_WORTH = 0.02
"""Chance of a right name that is worth more cycles."""
_STANDS_OUT = 0.5
"""Share from which a cause is called the likeliest: below, fewer than half are right (watch.py)."""
_UNKNOWN = "look at robot, fixture and indicator"
_YOURS = "Nothing stops by itself; a test that is stopped early does not meet ISO 9283"


def warning(watched: Watched) -> tuple[str, ...]:
    """Return the lines of an alarm: what, since when, what to do now; none where there is none."""
    if watched.says != "structure":
        return ()
    from scara_iso.effects import find_effects  # noqa: PLC0415 - no part of the start

    since = watched.since or 1
    named = {effect.name: effect for effect in find_effects()}
    effect = named.get(watched.effect or "")
    likeliest = _named(watched) if effect else f"nothing known fits yet{_others(watched)}"
    begun = f"since cycle {since}" if since > 2 else "from the start"
    do = effect.at_once if effect else _UNKNOWN
    strike = f"strike cycles {since}-{watched.cycle}, or" if since > 2 else "then"
    return (
        f"More than scatter: {likeliest}, {begun} (evidence {watched.evidence:.3g}, alarm at 20)",
        f"{do[0].upper()}{do[1:]}; {strike} start again",
        *_apart(watched),
        _YOURS,
    )


def _apart(watched: Watched) -> Iterator[str]:
    """Yield what would tell the rivals apart, and how well."""
    now, ways = watched.share or 0.0, watched.next or ()
    if ways and max(one.right for one in ways) < now + _WORTH:
        yield "Neither ten more cycles nor a pause will tell them apart"
    elif ways:
        then = ", ".join(f"{one.right:.0%} after {_way(one)}" for one in ways)
        yield f"To tell them apart: a name is right in {now:.0%} now, in {then}"


def _way(one: NextWay) -> str:
    behind = f"a pause as long as {PAUSE} cycles (p) and " if one.pause else ""
    return f"{behind}{one.cycles} cycles"


def _named(watched: Watched) -> str:
    """Return the likeliest effect with its share, and its rivals while there are any."""
    name = words(watched.effect or "")
    if watched.share is None:
        return f"likeliest {name}"
    so_far = "likeliest so far" if watched.rivals else "likeliest"
    if watched.share < _STANDS_OUT:
        so_far = "too early for a cause:"
    return f"{so_far} {name} ({watched.share:.0%}){_others(watched)}"


def _others(watched: Watched) -> str:
    """Return the likeliest rivals."""
    first = list((watched.rivals or {}).items())[:_RIVALS]
    return "".join(f" or {words(name)} ({share:.0%})" for name, share in first)
