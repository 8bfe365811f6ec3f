"""Stabilisation time and overshoot of a table of visits, whether or not 30 of them count."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from scara_iso.base.published import Unit, fill, publish, published
from scara_iso.iso9283.characteristics import overshoot, stabilisation_time
from scara_iso.iso9283.core.results import Characteristic
from scara_iso.run import AxisKey
from scara_iso.signals import SegmentedStream, Visit


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


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class StreamVisits(SegmentedStream):
    """``visits`` of a stream: the table that they are, and what the arrivals give."""

    schema: Literal["scara-iso/visits/1"] = "scara-iso/visits/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    source: str = field(init=False)
    """The file."""
    read_as: str = field(init=False)
    """How it was understood."""
    sha256: str | None = field(init=False)
    """Of the stream's bytes; null where it is no file."""
    units: Mapping[AxisKey, Unit] = field(init=False)
    """By axis."""
    numbered: tuple[NumberedVisit, ...] = field(init=False, metadata=published("visits"))
    """In the order of time."""
    characteristics: tuple[Characteristic, ...]
    """Stabilisation time and overshoot (7.4, 7.5) of each pose with three arrivals or more."""

    def __post_init__(self) -> None:
        run = self.run
        visits = enumerate(zip(self.visits, run.cycle.tolist(), strict=True), 1)
        fill(
            self,
            source=run.origin.source,
            read_as=run.origin.understood,
            sha256=run.metadata.get("stream_sha256"),
            units={name: axis.unit for name, axis in run.axes.items()},
            numbered=tuple(publish(NumberedVisit, one, visit=k, cycle=n) for k, (one, n) in visits),
        )


def with_arrivals(found: SegmentedStream) -> StreamVisits:
    """Return the visits with what every pose gives: each arrival is one of the clauses' three."""
    run = found.run
    times = stabilisation_time.stabilisation_times(run, run.rows_by_pose())
    beyond = overshoot.overshoots(run, run.rows_by_pose())
    return publish(StreamVisits, found, characteristics=(*times, *beyond))
