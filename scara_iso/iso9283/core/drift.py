"""A drift test (7.6): which row belongs to which block of visits, and how a pose moves over hours.

Its course is by block; the fit says when it is steady.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from scara_iso.base.errors import DataError, Fault, UsageError
from scara_iso.base.published import INTERNAL, Interval, fill, published
from scara_iso.base.quantities import Dimension, parse_number
from scara_iso.iso9283.core.cycles import UsedCycles
from scara_iso.iso9283.core.figures import PoseResult
from scara_iso.iso9283.core.statistics import largest_distance
from scara_iso.run import Axis, FloatArray, IntArray, Run

VISITS = "visits_per_block"
_LONG = 3.0  # times the usual step of time: a warm-up motion between two blocks takes longer
_FEWEST = 2  # blocks, and visits in each


def block_of_rows(run: Run) -> IntArray | None:
    """Return the block of each row, from 0, shape (rows,); None unless the run is a drift test.

    It is one where it has a column ``block`` of numbers that come in order, beside its times, or
    says ``# test: drift``; without the column ``# visits_per_block: 10`` then parts the blocks,
    else a gap in time of more than three usual steps. Raises `DataError` where a stated drift test
    has no such blocks.
    """
    stated = run.metadata.get("test", "").strip().lower() == "drift"
    block, time = run.covariates.get("block"), run.covariates.get("time_s")
    if not stated and (block is None or time is None):
        return None
    if block is None and VISITS in run.metadata:
        block = _from_count(run)
    elif block is None and time is not None:
        block = blocks_from_gaps(time)
    fault = _fault(run, block)
    if fault is None and block is not None:
        return np.asarray(np.unique(block, return_inverse=True)[1])
    if stated:
        raise DataError(
            f"is stated as a drift test, and {fault}",
            where=run.origin.source,
            remedy="number the blocks of visits in a column 'block', and state each row's time_s",
        )
    return None


def every_visit(run: Run, block: IntArray, *, asked: bool) -> UsedCycles:
    """Return all rows of a drift test; each block may count its visits anew.

    ``asked`` tells whether the user wants a first cycle left out, or another number: `UsageError`.
    `DataError` where the visits of a block are not counted one by one.
    """
    if asked:
        raise UsageError(
            "every visit of a drift test counts: none is discarded, and their number is free",
            remedy="leave `first_cycle_discarded=` and `cycles=` out",
        )
    poses = list(run.rows_by_pose())
    faults = [fault for _, rows in poses for fault in _count_faults(run, block, rows)]
    if faults:
        raise DataError(
            "the blocks of the drift test do not count their visits one by one",
            where=run.origin.source,
            remedy="number the visits 1, 2, 3 .. in each block, or through all of them",
            faults=faults,
        )
    return UsedCycles(
        poses=tuple(label for label, _ in poses),
        rows=tuple(rows for _, rows in poses),
        read=min(len(rows) for _, rows in poses),
        discarded=(),
        missing=tuple(() for _ in poses),
        all_count=True,
    )


def _count_faults(run: Run, block: IntArray, rows: IntArray) -> Iterator[Fault]:
    same, steps = np.diff(block[rows]) == 0, np.diff(run.cycle[rows])
    for k in np.flatnonzero(same & (steps != 1)):
        line = None if run.lines is None else int(run.lines[rows[k + 1]])
        before, here = run.cycle[rows[k]], run.cycle[rows[k + 1]]
        what = f"visit {here} comes after visit {before} of the same block"
        yield Fault(what, line=line, sheet=run.origin.sheet)


def _visits_of_blocks(block: IntArray, rows: IntArray) -> list[IntArray]:
    """Return which of ``rows`` each block holds, in order, as places in ``rows``."""
    mine = block[rows]
    return [np.flatnonzero(mine == one) for one in np.unique(mine)]


def blocks_from_gaps(time: FloatArray) -> FloatArray:
    """Return the number of gaps in time before each row, shape (rows,)."""
    steps = np.diff(time)
    return np.concatenate([[0.0], np.cumsum(steps > _LONG * np.median(steps))])


def _from_count(run: Run) -> FloatArray | None:
    visits = parse_number(run.metadata[VISITS])
    if visits is None or visits < 1 or visits != int(visits):
        return None
    block = np.empty(len(run))
    for _, rows in run.rows_by_pose():
        block[rows] = np.arange(len(rows)) // int(visits)
    return block


def _fault(run: Run, block: FloatArray | None) -> str | None:
    if block is None:
        return f"neither a column 'block', nor '# {VISITS}: 10', nor times tell its blocks"
    if np.any(block != np.round(block)) or np.any(np.diff(block) < 0):
        return "its blocks are not numbered in order"
    if np.any(np.diff(run.covariates.get("time_s", block)) < 0):
        return "its times go back"
    sizes = [np.unique(block[rows], return_counts=True)[1] for _, rows in run.rows_by_pose()]
    if any(len(counts) < _FEWEST or counts.min() < _FEWEST for counts in sizes):
        return f"it has fewer than {_FEWEST} blocks of {_FEWEST} visits"
    return None


STEADY = math.log(10.0)
"""Time constants after which a tenth of the drift is left, and a tenth of its first rate."""
CLAUSE = "7.6"
DRIFT_CODES = ("dAP", "dRP", "steady_after")
"""Characteristics that a drift test gives, and no other."""
_FEWEST_BLOCKS = 6
_TRIED = np.geomspace(1 / 300, 10, 1500)  # time constants, of the whole test
_LEVEL = 0.95


def label_of(pose: PoseResult) -> str | None:
    """Return the name of a pose."""
    return pose.label


def visits_of_each(visits: Sequence[IntArray]) -> tuple[Annotated[int, ("minimum", 2)], ...]:
    """Return how many visits each block has."""
    return tuple(map(len, visits))


@dataclass(frozen=True, eq=False, slots=True)
class DriftCourse:
    """One pose of a drift test; ``visits`` are the places of each block's rows in the pose's."""

    pose: PoseResult = field(metadata=published(by=label_of))
    """Its readings; by name."""
    visits: Sequence[IntArray] = field(metadata=published(by=visits_of_each))
    """Of each block."""
    hours: FloatArray | None = field(metadata=published("time_h"))
    """Mean time of each block since the first visit, h, shape (blocks,); None without times."""
    means: Mapping[str, FloatArray] = field(metadata=published("mean"))
    """Of each block, by axis, shape (blocks,)."""
    fit: DriftFit | None
    """None where the blocks do not move by more than chance, are few, or have no times."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class DriftFit:
    """Block means of all lengths as limit + (start - limit) exp(-t / time constant)."""

    axes: tuple[str, ...] = field(metadata=INTERNAL)
    """Those that are lengths."""
    time_constant_h: Annotated[float, ("unit", "h"), ("exclusiveMinimum", 0)]
    """Of all axes together."""
    interval_h: tuple[float, float | None] = field(metadata=published("time_constant_interval_h"))
    """95 %; an end is None where the test bounds none."""
    hours: FloatArray = field(metadata=INTERNAL)
    """Shape (blocks,)."""
    steady: bool = field(init=False)
    """A tenth of the drift is left before the test ends."""
    fitted: Mapping[str, FloatArray]
    """Mean of each block by the fit, by axis, shape (blocks,)."""

    def __post_init__(self) -> None:
        bounded = self.interval_h[1] is not None
        steady = bounded and self.steady_after_h <= float(self.hours[-1])
        fill(self, steady=steady)

    @property
    def steady_after_h(self) -> float:
        """When a tenth of the drift is left."""
        return STEADY * self.time_constant_h

    @property
    def steady_interval_h(self) -> Interval | None:
        """95 %; None where the test is too short to bound it."""
        low, high = self.interval_h
        return None if high is None else (STEADY * low, STEADY * high)


def drift_courses(run: Run, poses: Sequence[PoseResult], block: IntArray) -> list[DriftCourse]:
    """Return the course of each pose; ``block`` as `block_of_rows` gives it."""
    return [_course(run, pose, _visits_of_blocks(block, pose.rows)) for pose in poses]


def _course(run: Run, pose: PoseResult, visits: Sequence[IntArray]) -> DriftCourse:
    means = {
        name: np.array([axis.readings[rows].mean() for rows in visits])
        for name, axis in pose.axes.items()
    }
    time = run.covariates.get("time_s")
    if time is None:
        return DriftCourse(pose, visits, None, means, None)
    since = (time - time[0])[pose.rows] / 3600
    hours = np.array([since[rows].mean() for rows in visits])
    axes = [axis for axis in run.axes.values() if axis.dimension is Dimension.LENGTH]
    readings = [
        np.stack([pose.axes[a.name].readings[rows] for a in axes]) for rows in visits if axes
    ]
    return DriftCourse(pose, visits, hours, means, fit_drift(readings, hours, axes))


def fit_drift(
    groups: Sequence[FloatArray], hours: FloatArray, axes: Sequence[Axis]
) -> DriftFit | None:
    """Return the fit of blocks of readings, of shape (axes, visits) each, at ``hours``.

    None where they are fewer than six, or do not move by more than chance.
    """
    from scipy.special import fdtri  # noqa: PLC0415 - heavy

    if len(groups) < _FEWEST_BLOCKS:
        return None
    pairs = [(0, k) for k in range(1, len(groups))]
    moved = largest_distance(groups, pairs, axes=axes, clause=CLAUSE)
    if moved.interval is None or moved.interval[0] == 0:
        return None
    names = [axis.name for axis in axes]
    means = np.stack([group.mean(axis=1) for group in groups], axis=1)
    tried, likelihood = _profile(hours, means)
    best = int(np.argmin(likelihood))
    n, freedom = len(hours), means.size - 2 * len(names) - 1
    # How far the profile may rise inside the 95 % interval: F of 1 and the residuals.
    rise = n / (n - 2) * float(fdtri(1, freedom, _LEVEL))
    inside = np.flatnonzero(likelihood <= likelihood[best] + rise)
    # Below the shortest that is tried the drift is over within the first block, whatever it is.
    low = 0.0 if inside[0] == 0 else float(tried[inside[0]])
    high = None if inside[-1] == len(tried) - 1 else float(tried[inside[-1]])
    decay = np.exp(-(hours - hours[0]) / tried[best])
    design = np.stack([np.ones_like(hours), decay], axis=1)
    fitted = (design @ np.linalg.lstsq(design, means.T, rcond=None)[0]).T
    return DriftFit(
        axes=tuple(names),
        time_constant_h=float(tried[best]),
        interval_h=(low, high),
        hours=hours,
        fitted=dict(zip(names, fitted, strict=True)),
    )


def _profile(hours: FloatArray, means: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the time constants tried and twice the negative log-likelihood of each.

    ``means`` of shape (axes, blocks); limit, start and scatter of each axis are its own.
    """
    tried = _TRIED * (hours[-1] - hours[0])
    decay = np.exp(-(hours - hours[0]) / tried[:, np.newaxis])
    decay -= decay.mean(axis=1, keepdims=True)
    centred = means - means.mean(axis=1, keepdims=True)
    explained = (decay @ centred.T) ** 2 / (decay**2).sum(axis=1, keepdims=True)
    total = (centred**2).sum(axis=1)
    left = np.maximum(total - explained, np.finfo(np.float64).tiny + 1e-12 * total)
    return tried, np.asarray(len(hours) * np.log(left).sum(axis=1))
