"""The report on serial ports, dialects and a probed line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from scara_iso.recorder import DeviceNotice, Dialect, Event, Garbage, InstrumentFault, Reading
from scara_iso.reporting.blocks import Block, Report, Section, Table, Text


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
