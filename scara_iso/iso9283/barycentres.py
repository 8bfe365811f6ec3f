"""The largest distance between barycentres: of directions, of blocks in time, of robots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.dial import step_of
from scara_iso.iso9283.estimates import FEWEST_FOR_INTERVAL
from scara_iso.quantities import (
    Dimension,
    Estimate,
    rounding_uncertainty,
    within_half_a_turn,
)
from scara_iso.run import Axis, FloatArray, Run

_LEVEL = 0.05


def components(run: Run) -> Iterator[tuple[str, list[str]]]:
    """Yield the figures of a run by name with their axes: each axis, then XY and XYZ."""
    yield from ((name, [name]) for name in run.axes)
    for names in ("XY", "XYZ"):
        axes = [run.axes[name] for name in names if name in run.axes]
        if len(axes) == len(names) and all(a.dimension is Dimension.LENGTH for a in axes):
            yield names, list(names)


def largest_distance(
    groups: Sequence[FloatArray],
    pairs: Sequence[tuple[int, int]],
    *,
    axes: Sequence[Axis],
    clause: str,
) -> Estimate:
    """Return the largest distance between the barycentres of any of ``pairs`` of ``groups``.

    Each group has shape (components, n), a row for each of ``axes``. The sources give no interval.
    Here its upper end is the largest of the pairs' own (Student's t along the line between both
    barycentres, Welch 1947), which holds whatever pair truly lies farthest apart; its lower end
    allows for the choice of the largest among the pairs (Bonferroni) and for scatter alone being a
    distance (the error vector's length by Box 1954). Both readings carry what the dial adds.
    """
    found = [_pair(groups[a], groups[b], axes[0], len(pairs)) for a, b in pairs]
    largest = max(found, key=lambda one: one.distance)
    reading = math.sqrt(2) * max(map(_reading, axes))
    parts = {"sampling": largest.error} | ({"reading": reading} if reading else {})
    n, unit = min(group.shape[1] for group in groups), axes[0].unit
    if n < FEWEST_FOR_INTERVAL:
        return Estimate(largest.distance, unit, None, parts, None, n, clause)
    lower = max(one.distance - math.hypot(one.below, 2 * reading) for one in found)
    upper = max(one.distance + math.hypot(one.above, 2 * reading) for one in found)
    ends = (max(lower, 0.0), upper)
    u = math.hypot(*parts.values())
    return Estimate(largest.distance, unit, u, parts, ends, n, clause)


@dataclass(frozen=True, slots=True)
class _Pair:
    """A distance, its standard error, and how far the truth may lie below and above it."""

    distance: float
    error: float
    below: float
    above: float


def _pair(one: FloatArray, other: FloatArray, axis: Axis, pairs: int) -> _Pair:
    from scipy.special import fdtri, stdtrit  # noqa: PLC0415 - heavy

    apart = other.mean(axis=1) - one.mean(axis=1)
    if axis.dimension is Dimension.ANGLE:
        apart = np.array([within_half_a_turn(float(apart[0]))])
    spreads = [_of_mean(one), _of_mean(other)]
    both = spreads[0] + spreads[1]
    distance, trace = float(np.linalg.norm(apart)), float(np.trace(both))
    if trace == 0:
        return _Pair(distance, 0.0, 0.0, 0.0)
    along = apart / distance if distance > 0 else np.linalg.eigh(both)[1][:, -1]
    error = math.sqrt(float(along @ both @ along))
    sizes = [float(np.trace(spread)) for spread in spreads]
    counts = [one.shape[1] - 1, other.shape[1] - 1]
    freedom = trace**2 / sum(size**2 / n for size, n in zip(sizes, counts, strict=True))
    directions = trace**2 / float(np.trace(both @ both))
    below = math.sqrt(trace * float(fdtri(directions, freedom, 1 - _LEVEL / pairs)))
    return _Pair(distance, error, below, error * float(stdtrit(freedom, 1 - _LEVEL / 2)))


def _of_mean(positions: FloatArray) -> FloatArray:
    """Return the covariance of the barycentre, shape (components, components)."""
    return np.asarray(np.atleast_2d(np.cov(positions, ddof=1)) / positions.shape[1])


def _reading(axis: Axis) -> float:
    """Return what the dial leaves uncertain of every mean; its own step stands for none stated."""
    return math.hypot(rounding_uncertainty(step_of(axis)), axis.uncertainty or 0.0)
