"""What the studentised differences are by chance: cycles given to the two runs at random.

The means of two runs may differ (an indicator has no absolute zero), so readings are centred
before they are permuted: about their mean for the test of means, about their median for that of
spreads, whose level is then best (docs/appendix/compare-tables.md). One permutation serves all axes
and poses: what they have in common stays. Studentised statistics keep their level where the shapes
of the two scatters differ (Janssen 1997 for means, Pauly 2011 for spreads).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.comparison.spreads import spread
from scara_iso.run import FloatArray, IntArray

_BLOCK = 2_000_000  # readings permuted at a time


@dataclass(frozen=True, slots=True)
class FigureColumns:
    """Which columns of the readings make a figure, and whether it is that of an angle."""

    columns: tuple[int, ...]
    angle: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Permuted:
    """Absolute studentised differences, shape (columns or figures, permutations)."""

    means: FloatArray
    spreads: FloatArray


def permute(
    before: FloatArray,
    after: FloatArray,
    figures: Sequence[FigureColumns],
    rng: np.random.Generator,
    *,
    shuffles: int,
) -> Permuted:
    """Return what chance makes of two runs' readings, shapes (columns, n) and (columns, m)."""
    n, total = before.shape[1], before.shape[1] + after.shape[1]
    about_mean = _pooled(before, after, np.mean)
    about_median = _pooled(before, after, np.median)
    means, spreads = [], []
    block = max(_BLOCK // about_mean.size, 1)
    for first in range(0, shuffles, block):
        shape = (min(block, shuffles - first), 1)
        orders = rng.permuted(np.tile(np.arange(total), shape), axis=1)
        means.append(_means(about_mean, orders, n))
        spreads.append(_spreads(about_median, orders, n, figures))
    return Permuted(np.concatenate(means, axis=1), np.concatenate(spreads, axis=1))


def mean_error(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return Welch's standard error of the difference of means, over the last axis."""
    squares = [x.var(axis=-1, ddof=1) / x.shape[-1] for x in (before, after)]
    return np.asarray(np.sqrt(squares[0] + squares[1]))


def _pooled(before: FloatArray, after: FloatArray, centre: object) -> FloatArray:
    assert callable(centre)  # noqa: S101
    return np.concatenate([x - centre(x, axis=1, keepdims=True) for x in (before, after)], axis=1)


def _means(pooled: FloatArray, orders: IntArray, n: int) -> FloatArray:
    permuted = pooled[:, orders]
    first, second = permuted[..., :n], permuted[..., n:]
    difference = np.abs(second.mean(axis=-1) - first.mean(axis=-1))
    return _studentised(difference, mean_error(first, second))


def _spreads(
    pooled: FloatArray, orders: IntArray, n: int, figures: Sequence[FigureColumns]
) -> FloatArray:
    found = []
    for figure in figures:
        permuted = np.moveaxis(pooled[list(figure.columns)][:, orders], 0, 1)
        first, first_error = spread(permuted[..., :n], angle=figure.angle)
        second, second_error = spread(permuted[..., n:], angle=figure.angle)
        tiny = np.finfo(np.float64).tiny  # equal readings count as a large difference
        logs = np.log(np.maximum(second, tiny)) - np.log(np.maximum(first, tiny))
        found.append(_studentised(np.abs(logs), np.hypot(first_error, second_error)))
    return np.stack(found)


def _studentised(difference: FloatArray, error: FloatArray) -> FloatArray:
    """Return difference over error; 0 where both runs of a permutation are one value."""
    safe = np.where(error > 0, error, 1.0)
    return np.asarray(np.where(error > 0, difference / safe, np.where(difference > 0, np.inf, 0)))
