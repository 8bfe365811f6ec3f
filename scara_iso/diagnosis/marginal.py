"""Marginal tests: what no permutation sees, two levels in any order and isolated readings.

The null is simulated on the dial's grid. Which scatter it has is not known, so several families
stand for it, and a finding must be rare under each: Gaussian, Student t with 5 and 3 degrees of
freedom, and a gamma distribution rather more skewed than the readings are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from scara_iso.diagnosis.tuning import (
    CLEAR,
    FEWEST_ON_A_LEVEL,
    FIRST_SIMULATIONS,
    GAIN,
    MOST_SKEWED,
    NEIGHBOURS,
    SIMULATIONS,
)
from scara_iso.run import FloatArray


@dataclass(frozen=True, slots=True)
class MarginalTests:
    """Smallest p-values over the axes (Bonferroni), and the axis and row they belong to.

    ``gaussian_outlier`` compares with Gaussian scatter only: enough to look at the sheet, not
    enough for a verdict, since heavier tails are common.
    """

    two_levels: float
    two_levels_axis: int
    outlier: float
    gaussian_outlier: float
    outlier_axis: int
    outlier_row: int
    floor: float
    """Smallest p-value that the simulations can give."""


def marginal_tests(
    values: FloatArray, division: FloatArray, rng: np.random.Generator
) -> MarginalTests:
    """Return the tests of residuals (n, axes) read with ``division`` (axes,), 0 where not known."""
    n, axes = values.shape
    symmetric = _symmetric(n, rng)
    offset = rng.uniform(-0.5, 0.5, size=SIMULATIONS)
    levels, outliers, gaussian = np.ones(axes), np.ones(axes), np.ones(axes)
    for a in range(axes):
        if not np.ptp(values[:, a]):
            continue
        families = symmetric, _skewed(values[:, a], rng)
        drawn = partial(_read, families, _scatter(values[:, a], division[a]), offset)
        y = values[:, a] / (division[a] or 1.0)
        levels[a] = _p_values(level_statistic, y, drawn).max()
        p = _p_values(outlier_statistic, y, drawn)
        outliers[a], gaussian[a] = p.max(), p[0]
        if _adjacent(y, division[a]):
            levels[a] = 1.0
    worst = int(np.argmin(gaussian))
    return MarginalTests(
        two_levels=min(1.0, axes * float(levels.min())),
        two_levels_axis=int(np.argmin(levels)),
        outlier=min(1.0, axes * float(outliers.min())),
        gaussian_outlier=min(1.0, axes * float(gaussian.min())),
        outlier_axis=worst,
        outlier_row=int(np.argmax(np.abs(values[:, worst] - np.median(values[:, worst])))),
        floor=axes / (1 + SIMULATIONS),
    )


def level_statistic(y: FloatArray) -> FloatArray:
    """Return the log mean evidence for a step in the *sorted* readings; y has shape (n, ...)."""
    n, k = len(y), FEWEST_ON_A_LEVEL
    ranked = np.sort(y - y.mean(axis=0), axis=0)
    below = np.arange(k, n - k + 1).reshape(-1, *[1] * (y.ndim - 1))
    between = np.cumsum(ranked, axis=0)[k - 1 : n - k] ** 2 * n / (below * (n - below))
    share = between / np.maximum((ranked**2).sum(axis=0), 1e-300)
    log_bf = -(n - 1) / 2 * np.log(1 - share * GAIN / (1 + GAIN))
    return np.asarray(np.log(np.exp(log_bf).mean(axis=0)))


def outlier_statistic(y: FloatArray) -> FloatArray:
    """Return how far the reading farthest from the median is from the mean of the others.

    In standard deviations of the others; y has shape (n, ...).
    """
    n = len(y)
    centred = y - np.median(y, axis=0)
    far = np.abs(centred).argmax(axis=0)
    apart = np.take_along_axis(centred, far[np.newaxis], axis=0)[0]
    mean = (centred.sum(axis=0) - apart) / (n - 1)
    squares = (centred**2).sum(axis=0) - apart**2 - (n - 1) * mean**2
    scatter = np.sqrt(np.maximum(squares, 0) / (n - 2))
    return np.asarray(np.abs(apart - mean) / (scatter + 1e-9))


def _symmetric(n: int, rng: np.random.Generator) -> FloatArray:
    """Return scatter of unit variance, shape (n, families, simulations); the Gaussian first."""
    shape = (n, SIMULATIONS)
    t5, t3 = rng.standard_t(5, size=shape), rng.standard_t(3, size=shape)
    return np.stack([rng.normal(size=shape), t5 / np.sqrt(5 / 3), t3 / np.sqrt(3)], axis=1)


def _skewed(y: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return gamma scatter of unit variance, skewed rather more than the readings y (n,) are.

    Of few readings the skewness comes out too small, and uncertain by about sqrt(6 / n).
    """
    centred = y - y.mean()
    observed = abs(float((centred**3).mean())) / float((centred**2).mean()) ** 1.5
    skewness = min(MOST_SKEWED, 1.5 * observed + 0.6)
    k = 4 / skewness**2
    return np.asarray((rng.gamma(k, size=(len(y), 1, SIMULATIONS)) - k) / np.sqrt(k))


def _scatter(y: FloatArray, division: float) -> float:
    """Return the scatter beside rounding in divisions (Sheppard's correction), 0 for no dial."""
    if not division:
        return 0.0
    variance = float(y.var(ddof=1)) / division**2
    return float(np.sqrt(max(variance - 1 / 12, 0.2**2)))


def _read(
    families: Sequence[FloatArray], scatter: float, offset: FloatArray, count: int
) -> FloatArray:
    """Return ``count`` simulations of readings, in whole divisions where there is a dial."""
    drawn = np.concatenate([family[..., :count] for family in families], axis=1)
    return np.round(drawn * scatter + offset[:count]) if scatter else drawn


def _p_values(
    statistic: Callable[[FloatArray], FloatArray],
    y: FloatArray,
    drawn: Callable[[int], FloatArray],
) -> FloatArray:
    """Return the share of simulations at least as extreme, for each family, shape (families,).

    A first look at some of them is enough where every share is far above the levels in use. Up to
    the level CLEAR that changes no verdict's chance: no p-value stopped there is so small.
    """
    observed = statistic(y)
    first = _share(observed, statistic(drawn(FIRST_SIMULATIONS)))
    return first if first.min() > CLEAR else _share(observed, statistic(drawn(SIMULATIONS)))


def _share(observed: FloatArray, simulated: FloatArray) -> FloatArray:
    beaten = (simulated >= observed - 1e-9).sum(axis=-1)
    return np.asarray((1 + beaten) / (1 + simulated.shape[-1]))


def _adjacent(y: FloatArray, division: float) -> bool:
    """Whether the readings are at most three neighbouring divisions: never proof of two levels."""
    return bool(division) and float(np.ptp(y)) < NEIGHBOURS
