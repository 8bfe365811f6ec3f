"""Stabilisation time and overshoot of a table of visits, whether or not 30 of them count."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.characteristics import overshoot, stabilisation_time
from scara_iso.iso9283.results import Characteristic
from scara_iso.run import Run


def arrival_characteristics(run: Run) -> Iterator[Characteristic]:
    """Yield them for every pose, of all its visits: each arrival is one of the clauses' three."""
    yield from stabilisation_time.stabilisation_times(run, run.rows_by_pose())
    yield from overshoot.overshoots(run, run.rows_by_pose())
