"""Distances between two poses that are visited in each cycle, for AD and RD."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.figures import PoseResult
from scara_iso.iso9283.results import Measured, poses_in_cycles
from scara_iso.run import Axis, FloatArray, IntArray, Run

_FEWEST_CYCLES = 2
_MOST_POSES = 10


@dataclass(frozen=True, eq=False, slots=True)
class Distances:
    """Two poses, and how far apart they were attained in each cycle that has both."""

    between: tuple[str, str]
    of: str
    axes: Sequence[Axis]
    apart: FloatArray
    """Second minus first, shape (axes, cycles), in mm."""
    commanded: FloatArray | None
    """Of the command poses, shape (axes,); None without a scale that both share."""

    @property
    def pose(self) -> str:
        """Name of the pair: ``P1-P2``."""
        return "-".join(self.between)

    @property
    def attained(self) -> FloatArray:
        """Distance in each cycle, shape (cycles,); along one axis it is signed."""
        if len(self.axes) == 1:
            return np.asarray(self.apart[0])
        return np.asarray(np.sqrt((self.apart**2).sum(axis=0)))


def distances(test: Measured) -> Iterator[Distances]:
    """Yield those of each pair of poses along each axis that is a length, in XY and in XYZ.

    In XY and XYZ only on one scale; nothing where cycle does not follow cycle.
    """
    poses = poses_in_cycles(test)
    if len(poses) > _MOST_POSES:
        return
    for first, second in combinations(poses, 2):
        (pose, way), (other, other_way) = (test.run.arrival_at(p.label) for p in (first, second))
        rows = _visited_in_turn(first, second) if pose != other and way == other_way else None
        if rows is not None:
            yield from _between(test.run, first, second, rows)


def _between(
    run: Run, first: PoseResult, second: PoseResult, rows: tuple[IntArray, IntArray]
) -> Iterator[Distances]:
    labels = (str(first.label), str(second.label))
    lengths = {n: axis for n, axis in run.axes.items() if axis.dimension is Dimension.LENGTH}
    for of, names in (*((n, n) for n in lengths), ("XY", "XY"), ("XYZ", "XYZ")):
        group = [of] if of in lengths else list(names)
        if not set(group) <= set(lengths):
            continue
        axes = [lengths[name] for name in group]
        commanded = _commanded(run, group, first.label, second.label)
        if len(axes) == 1 or commanded is not None:
            apart = np.stack([axis.readings[rows[1]] - axis.readings[rows[0]] for axis in axes])
            yield Distances(labels, of, axes, apart, commanded)


def _visited_in_turn(first: PoseResult, second: PoseResult) -> tuple[IntArray, IntArray] | None:
    """Return the rows of the cycles that both have, None unless cycle follows cycle."""
    _, i, j = np.intersect1d(first.cycle, second.cycle, return_indices=True)
    one, other = first.rows[i], second.rows[j]
    ends, starts = np.maximum(one, other)[:-1], np.minimum(one, other)[1:]
    return (one, other) if len(one) >= _FEWEST_CYCLES and np.all(ends < starts) else None


def _commanded(
    run: Run, names: Sequence[str], first: str | None, second: str | None
) -> FloatArray | None:
    """Return the command pose of the second minus that of the first, where both are on one scale.

    Two equal ones are a dial that was set to zero at each of them: no scale is shared.
    """
    pairs = [(run.command_of(name, first), run.command_of(name, second)) for name in names]
    known = [(one, other) for one, other in pairs if one is not None and other is not None]
    if not run.dial_zero_is_command or len(known) < len(pairs):
        return None
    apart = np.array([other - one for one, other in known])
    return apart if np.any(apart != 0) else None
