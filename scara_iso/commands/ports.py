"""`ports`: which ports are there, what they speak, which indicators are known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from scara_iso import recorder
from scara_iso.base.errors import UsageError
from scara_iso.base.published import publish
from scara_iso.commands.shared.options import argument, option, takes_options_of
from scara_iso.commands.shared.output import Answer
from scara_iso.reporting import Block, Section, Table, Text

SECONDS = 3.0
_QUIET_S = 0.2
_NOT_TRIED = (
    "From documents, rated high (the maker's own, or two that agree), medium or low. None was "
    "tried on an instrument: compare the first reading with the display."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPorts:
    """``ports``."""

    schema: Literal["scara-iso/ports/1"] = "scara-iso/ports/1"
    """Name and number of this schema."""
    ports: tuple[recorder.Device, ...]
    """By name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedDialect:
    """What a family of indicators speaks."""

    instruments: str
    """Makers and models."""
    line: str
    """Settings of the serial line."""
    sends_unit: bool
    """Whether a reading names its unit."""
    confidence: Literal["high", "medium", "low"]
    """How sure the source is."""
    source: str
    """Document that states it."""
    unverified: tuple[str, ...]
    """What no source states: the user checks it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedDialects:
    """``ports`` of the dialects."""

    schema: Literal["scara-iso/dialects/1"] = "scara-iso/dialects/1"
    """Name and number of this schema."""
    dialects: Mapping[str, PublishedDialect]
    """By key."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbedReading:
    """A reading as a dialect understands it."""

    value: str
    """As sent."""
    unit: str | None
    """Null where it is not sent."""
    channel: str | None
    """Of a box with several gauges."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedProbe:
    """``ports`` listening to one."""

    schema: Literal["scara-iso/probe/1"] = "scara-iso/probe/1"
    """Name and number of this schema."""
    port: str
    """Its address."""
    line: str
    """Settings of the serial line."""
    seconds: Annotated[float, ("unit", "s"), ("minimum", 0)]
    """How long it was listened to."""
    received: Annotated[str, ("pattern", "^([0-9a-f]{2})*$")]
    """Bytes in hexadecimal."""
    dialects: Mapping[str, tuple[ProbedReading, ...]]
    """Those that understand every line, by key, with what they read."""
    diagnosis: str | None
    """Of a wrong parity, or of a loopback plug in place of an indicator."""


@takes_options_of(
    None,
    "json",
    name=argument(
        "Maker or driver that --dialects lists: mahr.",
        "NAME",
        show_default=False,
        autocompletion=lambda: list(recorder.find_dialects()),
    ),
    dialects=option("List the drivers and their indicators."),
    probe=option("Listen to a port for 3 s.", metavar="PORT"),
    ask=option(
        "Driver for --probe: its settings, and its request once a second.",
        metavar="DRIVER",
        autocompletion=lambda: list(recorder.find_dialects()),
    ),
)
def ports_command(
    name: str | None = None,
    *,
    dialects: bool = False,
    probe: str | None = None,
    ask: str | None = None,
) -> Answer:
    """List serial ports or the drivers of indicators, or show what a port sends.

    Example: scara-iso ports --probe /dev/ttyUSB0 --ask opto-rs232
    """
    if name is not None and not dialects:
        raise UsageError(
            f"{name}: only --dialects takes a name", remedy=f"scara-iso ports --dialects {name}"
        )
    if ask is not None and probe is None:
        raise UsageError("--ask needs a port", remedy="give --probe PORT too")
    if probe is not None and dialects:
        raise UsageError("--probe and --dialects are two questions", remedy="leave out either")
    if probe is not None:
        return _probe(probe, ask)
    return _dialects(name or "") if dialects else _list()


def _list() -> Answer:
    devices = recorder.list_devices()
    text = "No serial port was found. sim: simulates one: `gauge=X=opto-rs232@sim:`"
    table = Table(
        ("port", "identity", "description"),
        tuple((device.name, str(device), device.description) for device in devices),
    )
    published = PublishedPorts(ports=devices)
    shown = Section("Serial ports", (table if devices else Text(text),))
    return Answer(published, lambda: (shown,))


def _dialects(name: str) -> Answer:
    found = {
        key: dialect
        for key, dialect in recorder.find_dialects().items()
        if name.casefold() in f"{key} {dialect.instruments}".casefold()
    }
    if not found:
        raise UsageError(f"no driver is called {name!r}", remedy="scara-iso ports --dialects")
    dialects = {
        key: publish(PublishedDialect, one, line=str(one.line)) for key, one in found.items()
    }
    published = PublishedDialects(dialects=dialects)
    head = Section("Indicators", (Text(_NOT_TRIED),))
    each = (Section(one.key, tuple(_dialect(one))) for one in found.values())
    return Answer(published, lambda: (head, *each))


def _dialect(dialect: recorder.Dialect) -> Iterator[Block]:
    unit = "asked for" if dialect.unit_request else "by option"
    unit = "in the frame" if dialect.sends_unit else unit
    yield Text(dialect.instruments)
    yield Text(f"line {dialect.line}, request {_request(dialect)}, unit {unit}")
    yield Text(f"source ({dialect.confidence}): {dialect.source}", "quiet")
    if dialect.unverified:
        yield Text(f"unverified: {'; '.join(dialect.unverified)}", "bad")


def _request(dialect: recorder.Dialect) -> str:
    if dialect.request_template is not None:
        return _bytes(dialect.request_template)
    pulse = dialect.request_line
    return f"pulse on {pulse.line.upper()}" if pulse else "none: sends by itself"


def _probe(address: str, key: str | None) -> Answer:
    dialect = recorder.find_dialect(key or "mitutoyo-mux")  # 9600 8N1 where no other is named
    received = _listen(address, dialect, asked=key is not None)
    events = {
        k: tuple(recorder.Decoder(d).feed(received)) for k, d in recorder.find_dialects().items()
    }
    matches = {k: found for k, found in events.items() if _understood(found)}
    garbage = (e for found in events.values() for e in found if isinstance(e, recorder.Garbage))
    wrong = (one.reason for one in garbage if one.reason.startswith("looks like"))
    is_echo = recorder.is_echo(received, dialect.request)
    diagnosis = recorder.ECHO if is_echo else next(wrong, None)
    published = PublishedProbe(
        port=address,
        line=str(dialect.line),
        seconds=SECONDS,
        received=received.hex(),
        dialects={k: tuple(_readings(found)) for k, found in matches.items()},
        diagnosis=diagnosis,
    )
    heading = f"{address} at {dialect.line}, {SECONDS:g} s"
    shown = Section(heading, tuple(_probed(received, matches, diagnosis)))
    return Answer(published, lambda: (shown,))


def _listen(address: str, dialect: recorder.Dialect, *, asked: bool) -> bytes:
    """Return what a port sends in a while, ``asked`` once a second or by itself."""
    clock = recorder.choose_clock([address])
    port = recorder.open_port(address, dialect, axis="X", clock=clock, asked=asked)
    received, asked_at = b"", _QUIET_S - 1.0
    try:
        while clock.now() < SECONDS:
            received += port.read()
            if asked and clock.now() >= asked_at + 1.0:
                asked_at = clock.now()
                port.ask(dialect)
            clock.idle(min(SECONDS, asked_at + 1.0) if asked else SECONDS)
    finally:
        port.close()
    return received


def _understood(events: Sequence[recorder.Event]) -> bool:
    """Say whether every whole line is a frame, and one at least a value or a fault."""
    return any(
        isinstance(e, recorder.Reading | recorder.InstrumentFault) for e in events
    ) and not any(isinstance(e, recorder.Garbage) for e in events)


def _readings(events: Sequence[recorder.Event]) -> Iterator[ProbedReading]:
    for event in events:
        if isinstance(event, recorder.Reading):
            yield publish(ProbedReading, event, value=event.text)


def _probed(
    received: bytes, matches: Mapping[str, Sequence[recorder.Event]], diagnosis: str | None
) -> Iterator[Block]:
    if not received:
        yield Text(
            "Nothing was received. Press DATA on the indicator, or ask: `ask=opto-rs232`", "bad"
        )
        return
    yield Text(f"{len(received)} bytes: {_bytes(received)}")
    yield Text(received.hex(" "), "quiet")
    for key, events in matches.items():
        yield Text(f"{key}: {', '.join(filter(None, map(_shown, events)))}", "good")
    if not matches:
        yield Text("No driver understands this.", "bad")
    if diagnosis:
        yield Text(diagnosis, "bad")


def _shown(event: recorder.Event) -> str:
    match event:
        case recorder.Reading(text=text, unit=unit, channel=channel):
            place = f" (channel {channel})" if channel else ""
            return f"{text} {unit or '(no unit)'}{place}"
        case recorder.InstrumentFault(code=code):
            return f"fault {code}"
        case recorder.DeviceNotice(message=message):
            return message
    return ""


def _bytes(data: bytes) -> str:
    return repr(data)[2:-1]
