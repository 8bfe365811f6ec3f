"""What ``ports`` publishes: schemas ``scara-iso/ports/1``, ``dialects/1`` and ``probe/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from scara_iso.base.published import publish
from scara_iso.recorder import Device, Dialect, Reading
from scara_iso.reporting.ports import Probe


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPorts:
    """``ports``."""

    schema: Literal["scara-iso/ports/1"]
    """Name and number of this schema."""
    ports: tuple[Device, ...]
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

    schema: Literal["scara-iso/dialects/1"]
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

    schema: Literal["scara-iso/probe/1"]
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
    """Of a wrong parity."""


def published_dialects(found: Mapping[str, Dialect]) -> PublishedDialects:
    """Return what is said of dialects."""
    said = {key: publish(PublishedDialect, one, line=str(one.line)) for key, one in found.items()}
    return PublishedDialects(schema="scara-iso/dialects/1", dialects=said)


def published_probe(probe: Probe) -> PublishedProbe:
    """Return what a port sent."""
    return PublishedProbe(
        schema="scara-iso/probe/1",
        port=probe.port,
        line=probe.line,
        seconds=probe.seconds,
        received=probe.received.hex(),
        dialects={
            key: tuple(
                publish(ProbedReading, one, value=one.text)
                for one in probe.events[key]
                if isinstance(one, Reading)
            )
            for key in probe.matches()
        },
        diagnosis=probe.diagnosis(),
    )
