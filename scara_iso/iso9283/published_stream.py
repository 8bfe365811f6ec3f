"""What ``visits`` publishes of a stream: schema ``scara-iso/visits/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from scara_iso.base.published import Count, Unit, publish
from scara_iso.iso9283.results import Characteristic
from scara_iso.iso9283.transients import StreamVisits
from scara_iso.run import AxisKey
from scara_iso.signals import Doubt, Rule, Visit


@dataclass(frozen=True)
class VisitNumber:
    """Which visit it is."""

    visit: Annotated[int, ("minimum", 1)]
    """In the order of time."""
    cycle: Annotated[int, ("minimum", 1)]
    """Of its pose."""


@dataclass(frozen=True, slots=True)
class NumberedVisit(Visit, VisitNumber):
    """One stay at a pose; lengths in mm, angles in degrees."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedVisits:
    """``visits`` of a stream."""

    schema: Literal["scara-iso/visits/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    source: str
    """The file."""
    read_as: str
    """How it was understood."""
    samples: Count
    """Of the whole stream."""
    rate_hz: Annotated[float, ("unit", "Hz"), ("minimum", 0)]
    """Samples a second, the median."""
    sha256: str | None
    """Of the stream's bytes; null where it is no file."""
    rule: Rule
    """What distinguished rest from motion."""
    units: Mapping[AxisKey, Unit]
    """By axis."""
    visits: tuple[NumberedVisit, ...]
    """In the order of time."""
    doubts: tuple[Doubt, ...]
    """What is not plainly a visit."""
    notes: tuple[str, ...]
    """What else is to be known of the reading."""
    characteristics: tuple[Characteristic, ...]
    """Stabilisation time and overshoot of each pose."""


def published_visits(found: StreamVisits) -> PublishedVisits:
    """Return what ``visits`` says."""
    run = found.run
    visits = enumerate(zip(found.visits, run.cycle.tolist(), strict=True), 1)
    return publish(
        PublishedVisits,
        found,
        schema="scara-iso/visits/1",
        unit="mm",
        source=run.origin.source,
        read_as=run.origin.understood,
        sha256=run.metadata.get("stream_sha256"),
        units={name: axis.unit for name, axis in run.axes.items()},
        visits=tuple(publish(NumberedVisit, one, visit=k, cycle=n) for k, (one, n) in visits),
    )
