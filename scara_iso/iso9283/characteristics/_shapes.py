"""What several characteristics share: pairs of poses, groups of arrivals, blocks, streams."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple, TypeAlias

import numpy as np

from scara_iso.base.quantities import Dimension, Estimate
from scara_iso.iso9283.core.figures import PoseResult
from scara_iso.iso9283.core.results import (
    Characteristic,
    Characteristics,
    Measured,
    limit_names,
    poses_in_cycles,
)
from scara_iso.iso9283.core.statistics import components, even_estimate, largest_distance
from scara_iso.run import Axis, FloatArray, IntArray, Run

_FEWEST_CYCLES = 2
_FEWEST_ARRIVALS = 3
_MOST_POSES = 10

Readings: TypeAlias = Mapping[str, FloatArray]
"""By axis, shape (n,) each."""
RowsOfPoses: TypeAlias = Iterable[tuple[str | None, IntArray]]
"""Label of each pose, and its rows."""


class Distances(NamedTuple):
    """Two poses, and how far apart they were attained in each cycle that has both."""

    between: tuple[str, str]
    of: str
    axes: Sequence[Axis]
    apart: FloatArray
    """Second minus first, shape (axes, cycles), in mm."""
    commanded: FloatArray | None
    """Of the command poses, shape (axes,); None without a scale that both share."""

    @property
    def attained(self) -> FloatArray:
        """Distance in each cycle, shape (cycles,); along one axis it is signed."""
        if len(self.axes) == 1:
            return np.asarray(self.apart[0])
        return np.asarray(np.sqrt((self.apart**2).sum(axis=0)))

    def characteristic(self, code: str, estimate: Estimate) -> Characteristic:
        """Return the figure of the pair, ``P1-P2``."""
        pair = "-".join(self.between)
        limited_by = (f"{code}:{pair}", code)
        return Characteristic(code, pair, self.of, estimate, limited_by, between=self.between)


def distances(test: Measured) -> Iterator[Distances]:
    """Yield those of each pair of poses along each axis that is a length, in XY and in XYZ.

    In XY and XYZ only on one scale; nothing where cycle does not follow cycle.
    """
    poses, run = poses_in_cycles(test), test.run
    if len(poses) > _MOST_POSES:
        return
    lengths = [
        (of, names)
        for of, names in components(run)
        if run.axes[names[0]].dimension is Dimension.LENGTH
    ]
    for first, second in combinations(poses, 2):
        (pose, way), (other, other_way) = (run.arrival_at(p.label) for p in (first, second))
        rows = _visited_in_turn(first, second) if pose != other and way == other_way else None
        if rows is None:
            continue
        between = (str(first.label), str(second.label))
        for of, names in lengths:
            axes = [run.axes[name] for name in names]
            commanded = _commanded(run, names, first, second)
            if len(axes) == 1 or commanded is not None:
                apart = np.stack([one.readings[rows[1]] - one.readings[rows[0]] for one in axes])
                yield Distances(between, of, axes, apart, commanded)


def _visited_in_turn(first: PoseResult, second: PoseResult) -> tuple[IntArray, IntArray] | None:
    """Return the rows of the cycles that both have, None unless cycle follows cycle."""
    _, i, j = np.intersect1d(first.cycle, second.cycle, return_indices=True)
    one, other = first.rows[i], second.rows[j]
    ends, starts = np.maximum(one, other)[:-1], np.minimum(one, other)[1:]
    return (one, other) if len(one) >= _FEWEST_CYCLES and np.all(ends < starts) else None


def _commanded(
    run: Run, names: Sequence[str], first: PoseResult, second: PoseResult
) -> FloatArray | None:
    """Return the command pose of the second minus that of the first, where both are on one scale.

    Two equal ones are a dial that was set to zero at each of them: no scale is shared.
    """
    apart = []
    for name in names:
        one, other = run.command_of(name, first.label), run.command_of(name, second.label)
        if one is None or other is None or not run.dial_zero_is_command:
            return None
        apart.append(other - one)
    return np.array(apart) if any(apart) else None


def readings_of(pose: PoseResult) -> Readings:
    """Return the readings that count."""
    return {name: axis.readings for name, axis in pose.axes.items()}


def each_in_blocks(test: Measured) -> Iterator[tuple[PoseResult, list[Readings]]]:
    """Yield each pose of a drift test with the readings of each block; of another test none."""
    for course in test.drift or ():
        readings = readings_of(course.pose).items()
        yield course.pose, [{n: one[rows] for n, one in readings} for rows in course.visits]


def farthest_apart(
    code: str,
    clause: str,
    pose: str | None,
    groups: Sequence[Readings],
    pairs: Sequence[tuple[int, int]],
    runs: Sequence[Run],
) -> Characteristics:
    """Yield the largest distance between the barycentres of pairs of groups of readings at a pose.

    Along each axis that all groups have, in XY and in XYZ; ``runs`` are those that they are of.
    """
    for of, names in components(runs[0]):
        if all(set(names) <= set(one) for one in groups):
            positions = [np.stack([one[name] for name in names]) for one in groups]
            axes = [run.axes[name] for run in runs for name in names]
            estimate = largest_distance(positions, pairs, axes=axes, clause=clause)
            named = limit_names(code, pose, of)
            yield Characteristic(code, pose, of, estimate, named, of_means=True)


def counted(test: Measured) -> RowsOfPoses:
    """Return the rows that count of each pose."""
    return [(pose.label, pose.rows) for pose in test.poses]


def mean_of_arrivals(
    run: Run,
    poses: RowsOfPoses,
    column: Callable[[Axis], tuple[str, str, float | None]],
    code: str,
    clause: str,
) -> Characteristics:
    """Yield the mean of a column of each axis at each pose that has enough arrivals.

    ``column`` gives an axis' column, its unit, and the standard uncertainty of one of its values.
    The columns are of a table that was made of a stream.
    """
    for label, rows in poses:
        for axis in run.axes.values():
            name, unit, reading_u = column(axis)
            if name in run.covariates and len(rows) >= _FEWEST_ARRIVALS:
                values, n = run.covariates[name][rows], len(rows)
                estimate = even_estimate(
                    float(values.mean()),
                    unit,
                    sampling=float(values.std(ddof=1)) / math.sqrt(n),
                    reading_u=reading_u,
                    freedom=n - 1,
                    n=n,
                    clause=clause,
                    least=0.0,
                )
                where = (label, axis.name, estimate, (code,), reading_u)
                yield Characteristic(code, *where, counted="arrivals")
