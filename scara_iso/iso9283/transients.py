"""Stabilisation time and overshoot of a table of visits, whether or not 30 of them count."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

from scara_iso.iso9283.characteristics import overshoot, stabilisation_time
from scara_iso.iso9283.results import Characteristic
from scara_iso.run import Run
from scara_iso.signals import SegmentedStream


def arrival_characteristics(run: Run) -> Iterator[Characteristic]:
    """Yield them for every pose, of all its visits: each arrival is one of the clauses' three."""
    yield from stabilisation_time.stabilisation_times(run, run.rows_by_pose())
    yield from overshoot.overshoots(run, run.rows_by_pose())


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class StreamVisits(SegmentedStream):
    """The visits of a stream, the table that they are, and what the arrivals give."""

    characteristics: tuple[Characteristic, ...]
    """Stabilisation time and overshoot (7.4, 7.5) of each pose with three arrivals or more."""


def with_arrivals(found: SegmentedStream) -> StreamVisits:
    """Return the visits with their `arrival_characteristics`."""
    stated = {one.name: getattr(found, one.name) for one in fields(found)}
    return StreamVisits(**stated, characteristics=tuple(arrival_characteristics(found.run)))
