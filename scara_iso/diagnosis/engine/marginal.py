"""Marginal tests: what no permutation sees, two levels in any order and isolated readings.

The null is simulated on the dial's grid. Which scatter it has is not known, so several families
stand for it, and a finding must be rare under each: Gaussian, Student t with 5 degrees of
freedom, Laplace, a gamma distribution rather more skewed than the readings are, and two that end
at limits, where no tail tells them from two levels: uniform, and arcsine, a sampled vibration.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from scara_iso.diagnosis.engine.hypotheses import GAIN
from scara_iso.diagnosis.engine.residual import NEIGHBOURS, TWO_DIVISIONS
from scara_iso.diagnosis.engine.two_levels import FEWEST_ON_A_LEVEL, split
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

Statistic = Callable[[FloatArray], FloatArray]
"""Of readings (n, ...)."""
Reader = Callable[[int, int], FloatArray]
"""Draws readings (n, count) of a family."""

_TINY = 1e-300
_TRIMMED = 1.27
"""Standard deviation of Gaussian readings over that of the inner nine tenths of them."""
_MOST_ODD = 3
_MOST_LEVELS, _MANY = 5, 120
"""Levels that are sought, three of more readings than so many."""

SIMULATIONS = 4999
"""Simulations of the marginal tests' null: a second gross reading needs a chance of 0.001."""

FIRST_SIMULATIONS, CLEAR = 199, 0.1
"""Where so many simulations give every p-value above CLEAR the rest are not made."""

GROSS_SHARE = 0.1
"""Share of the readings, the farthest, that have no part in the scale of an outlier."""

MOST_SKEWED = 2.2
"""Skewness of the most skewed scatter that the null of the marginal tests allows for."""

WIDEST_SHARE = 0.2  # benchmarks/blind_spots.py
"""Share of the widest direction of several axes in the tests of two levels and of odd readings."""

THREE_SHARE = 0.2  # benchmarks/blind_spots.py
"""Share of three levels and more in the test of levels."""


@dataclass(frozen=True, eq=False, slots=True)
class MarginalTests:
    """Smallest p-values over the axes (Bonferroni); that of outliers ``of_axes`` too.

    ``rows`` are those of the outliers, where no axis shows them alone.

    ``gaussian_outlier`` compares with Gaussian scatter only: enough to look at the sheet, not
    enough for a verdict, since heavier tails are common. ``heavy_tailed`` is the share of scatter
    of Student's t with 3 degrees of freedom in which one is as far. ``floor`` is the smallest
    p-value that the simulations can give.
    """

    two_levels: float
    outlier: float
    gaussian_outlier: float
    outlier_axis: int
    outlier_row: int
    floor: float
    of_axes: FloatArray
    heavy_tailed: float = 1.0
    levels_axis: int = -1
    """Which axis, the widest direction last, shows more levels than two; else -1."""
    levels: int = 0
    """How many these are."""
    rows: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


def marginal_tests(
    values: FloatArray,
    division: FloatArray,
    rng: np.random.Generator,
    *,
    levels_below: float = 1.0,
    widest: FloatArray | None = None,
) -> MarginalTests:
    """Return the tests of residuals (n, axes) read with ``division`` (axes,), 0 where not known.

    Two levels are of interest with a p-value ``levels_below`` that only; any other is 1. They may
    also be those along the ``widest`` direction (n,) of several axes, on which no dial shows.
    """
    axes, seed = values.shape[1], int(rng.integers(2**63))
    columns = [(values[:, a] / (d or 1.0), bool(d)) for a, d in enumerate(division.tolist())]
    times = np.full(axes, float(axes))
    if widest is not None:
        columns.append((widest, False))
        times = np.append(times / (1 - WIDEST_SHARE), 1 / WIDEST_SHARE)
    levels, three, odd, gaussian = np.ones((4, len(columns)))
    for k, (y, on_dial) in enumerate(columns):
        if not np.ptp(y):
            continue
        if times[k] / (1 + SIMULATIONS) < levels_below:
            levels[k], three[k] = _levels(y, on_dial, seed, levels_below / times[k])
        odd[k], gaussian[k] = _outlier(y, on_dial, seed)
    odd = np.minimum(1.0, times * odd)
    k, heavy_tailed = int(odd.argmin()), 1.0
    if odd[k] < 1:
        statistic, read = _of_outliers(*columns[k], seed)
        heavy_tailed *= times[k] * _share(statistic, _T3, columns[k][0], read, SIMULATIONS)
    levels, three = times * levels / (1 - THREE_SHARE), times * three / THREE_SHARE
    shown = int(three.argmin()) if three.min() < min(1.0, levels.min()) else -1
    worst = int(np.argmin(gaussian[:axes]))
    row = int(np.argmax(np.abs(values[:, worst] - median(values[:, worst]))))
    return MarginalTests(
        two_levels=min(1.0, float(levels.min()), float(three.min())),
        outlier=float(odd[k]),
        gaussian_outlier=min(1.0, axes * float(gaussian[worst])),
        outlier_axis=worst,
        outlier_row=row,
        floor=float(times.min()) / (1 - THREE_SHARE) / (1 + SIMULATIONS),
        of_axes=odd[:axes],
        heavy_tailed=min(1.0, heavy_tailed),
        levels_axis=shown,
        levels=_count(columns[shown][0]) if shown >= 0 else 0,
        rows=odd_rows(columns[k][0]) if k == axes else np.array([row]),
    )


def odd_rows(y: FloatArray) -> IntArray:
    """Return the rows of the one to three readings of y (n,) that lie apart, the farthest first.

    Those beyond the widest gap between the four farthest from the median.
    """
    distance = np.abs(y - median(y))
    order = np.argsort(-distance, kind="stable")[:_MOST_ODD]
    ranked = np.sort(distance)[::-1][: _MOST_ODD + 1]
    return np.asarray(order[: int(np.argmax(ranked[:-1] - ranked[1:])) + 1])


def _levels(y: FloatArray, on_dial: bool, seed: int, below: float) -> tuple[float, float]:
    """Return the p-values of two and of more levels, 1 if not ``below``.

    Neighbouring divisions prove none.
    """
    if on_dial and np.ptp(y) < NEIGHBOURS:
        return 1.0, 1.0
    scatter = _scatter(y) if on_dial else 0.0
    read = partial(_read, n=len(y), scatter=scatter, seed=seed, skewed_as=y)
    two: list[tuple[Statistic, int]] = [(level_statistic, family) for family in _TAILS]
    two += [(_split_ratio, _UNIFORM), (partial(_beside_arcsine, on_dial=on_dial), _ARCSINE)]
    three = [(_levels_ratio, family) for family in (*_TAILS, _UNIFORM, _ARCSINE)]
    of_two = _p_value(two, y, read, below * (1 - THREE_SHARE))
    enough = len(y) >= 3 * FEWEST_ON_A_LEVEL
    return of_two, _p_value(three, y, read, below * THREE_SHARE) if enough else 1.0


def _outlier(y: FloatArray, on_dial: bool, seed: int) -> tuple[float, float]:
    """Return the p-values of an outlier, and of one in Gaussian scatter.

    Neighbouring divisions prove none.
    """
    inner = _inner_of(y)
    farthest = y[np.argmax(np.abs(y - median(y)))]
    if on_dial and np.abs(inner - farthest).min() < TWO_DIVISIONS:
        return 1.0, 1.0
    statistic, read = _of_outliers(y, on_dial, seed)
    gaussian = _share(statistic, _GAUSSIAN, y, read, FIRST_SIMULATIONS)
    if gaussian > CLEAR:
        return 1.0, gaussian
    cases = [(statistic, family) for family in _TAILS]
    return _p_value(cases, y, read), _share(statistic, _GAUSSIAN, y, read, SIMULATIONS)


def _of_outliers(y: FloatArray, on_dial: bool, seed: int) -> tuple[Statistic, Reader]:
    """Return the statistic of outliers, and how readings like y (n,) are drawn."""
    inner = _inner_of(y)
    scatter = _TRIMMED * _scatter(inner) if on_dial else 0.0
    statistic = partial(outlier_statistic, least=float(on_dial))
    return statistic, partial(_read, n=len(y), scatter=scatter, seed=seed, skewed_as=inner)


def _inner(n: int) -> int:
    """Return how many of n readings are the inner ones: all but the farthest tenth."""
    return n - max(2, round(GROSS_SHARE * n))


def _inner_of(y: FloatArray) -> FloatArray:
    return np.asarray(y[np.argsort(np.abs(y - median(y)))[: _inner(len(y))]])


def level_statistic(y: FloatArray) -> FloatArray:
    """Return the log mean evidence for a step in the *sorted* readings; y has shape (n, ...)."""
    n = len(y)
    _, between, ranked = split(y - y.mean(axis=0))
    share = between / np.maximum((ranked**2).sum(axis=0), _TINY)
    share *= -GAIN / (1 + GAIN)
    share += 1
    log_bf = np.log(share, out=share)
    log_bf *= -(n - 1) / 2
    return np.asarray(np.log(np.exp(log_bf, out=log_bf).mean(axis=0)))


def _split_ratio(y: FloatArray) -> FloatArray:
    """Return the log of range over scatter within the best two levels; y has shape (n, ...).

    Over n it is the log likelihood ratio of two levels to uniform scatter.
    """
    _, between, ranked = split(y - y.mean(axis=0))
    total = (ranked**2).sum(axis=0)
    within = np.maximum(total - between.max(axis=0), 1e-9 * total) / (len(y) - 2)
    return np.asarray(np.log(np.maximum(ranked[-1] - ranked[0], _TINY) / np.sqrt(within + _TINY)))


def _count(y: FloatArray) -> int:
    """Return how many levels y (n,) lies on: between two is half the second widest gap at least."""
    gaps = np.sort(np.diff(np.sort(y)))
    return int(np.clip(1 + np.sum(gaps >= gaps[-2] / 2), 3, _MOST_LEVELS))


def _levels_ratio(y: FloatArray) -> FloatArray:
    """Return the log of range over scatter within the best levels, three or more, and their number.

    The most of any number of levels: uniform scatter gives all about the same. y has shape
    (n, ...). Exact by dynamic programming over the sorted readings (Fisher 1958).
    """
    n, least = len(y), FEWEST_ON_A_LEVEL
    ranked = np.sort(y - y.mean(axis=0), axis=0)
    sums = np.concatenate([np.zeros((1, *ranked.shape[1:])), np.cumsum(ranked, axis=0)])
    span = np.maximum(ranked[-1] - ranked[0], _TINY)
    total = (ranked**2).sum(axis=0)
    count = np.arange(n + 1.0).reshape(-1, *[1] * (ranked.ndim - 1))
    between = np.full_like(sums, -np.inf)
    between[least:] = sums[least:] ** 2 / count[least:]
    found = np.full(ranked.shape[1:], -np.inf)
    for levels in range(2, min(n // least, _MOST_LEVELS if n <= _MANY else 3) + 1):
        fewer, between = between, np.full_like(between, -np.inf)
        for high in range(levels * least, n + 1):
            low = slice((levels - 1) * least, high - least + 1)
            own = (sums[high] - sums[low]) ** 2 / (high - count[low])
            between[high] = (fewer[low] + own).max(axis=0)
        if levels > 2:
            within = np.maximum(total - between[n], 1e-9 * total) / (n - levels)
            found = np.maximum(found, np.log(span / np.sqrt(within + _TINY) / levels))
    return np.asarray(found)


def _beside_arcsine(y: FloatArray, *, on_dial: bool = False) -> FloatArray:
    """Return the log likelihood ratio, over n, of two levels to arcsine scatter.

    Its density has no bound at the limits: on a dial, y in divisions, it is the mean over each
    reading's division.
    """
    n, low, high = len(y), y.min(axis=0), y.max(axis=0)
    half = np.maximum(high - low, float(on_dial) or _TINY) / 2 * (n + 1) / n
    place = (y - (low + high) / 2) / half
    if on_dial:
        end, begin = np.minimum(place + 0.5 / half, 1), np.maximum(place - 0.5 / half, -1)
        density = np.log((np.arcsin(end) - np.arcsin(begin)) * half)
    else:
        density = -0.5 * np.log(1 - place**2)
    return np.asarray(_split_ratio(y) - density.mean(axis=0))


def outlier_statistic(y: FloatArray, least: float = 0.0) -> FloatArray:
    """Return how far the reading farthest from the median is from it, and a third of the next's.

    In standard deviations of the inner readings, or ``least`` where that is larger; inner are all
    but the farthest tenth. So no gross reading hides another, and two of them are more than one.
    y has shape (n, ...).
    """
    n = len(y)
    centred = y - median(y, axis=0)
    inner = _inner(n)
    order = np.argpartition(np.abs(centred), (inner, n - 2, n - 1), axis=0)
    kept = np.take_along_axis(centred, order[:inner], axis=0)
    second, first = np.abs(np.take_along_axis(centred, order[-2:], axis=0))
    scatter = np.maximum(kept.std(axis=0, ddof=1), least)
    return np.asarray((first + second / 3) / (scatter + 1e-9))


_GAUSSIAN, _T5, _T3, _LAPLACE, _SKEWED, _UNIFORM, _ARCSINE = range(7)
_TAILS = (_GAUSSIAN, _T5, _LAPLACE, _SKEWED)
_FAMILIES: Mapping[int, Callable[[np.random.Generator, tuple[int, int]], FloatArray]] = {
    _GAUSSIAN: lambda rng, shape: rng.normal(size=shape),
    _T5: lambda rng, shape: rng.standard_t(5, size=shape) / np.sqrt(5 / 3),
    _T3: lambda rng, shape: rng.standard_t(3, size=shape) / np.sqrt(3),
    _LAPLACE: lambda rng, shape: rng.laplace(size=shape) / np.sqrt(2),
    _UNIFORM: lambda rng, shape: rng.uniform(-1, 1, size=shape) * np.sqrt(3),
    _ARCSINE: lambda rng, shape: np.sin(rng.uniform(0, 2 * np.pi, size=shape)) * np.sqrt(2),
}
"""Scatter of unit variance."""


def _skewed(y: FloatArray, seed: int, shape: tuple[int, int]) -> FloatArray:
    """Return gamma scatter of a shape, skewed rather more than the readings y (n,) are.

    Of few readings the skewness comes out too small, and uncertain by about sqrt(6 / n).
    """
    centred = y - y.mean()
    spread = float((centred**2).mean()) ** 1.5
    observed = abs(float((centred**3).mean())) / spread if spread else 0.0
    k = 4 / min(MOST_SKEWED, 1.5 * observed + 0.6) ** 2
    rng = np.random.default_rng([seed, shape[1], _SKEWED])
    return np.asarray((rng.gamma(k, size=shape) - k) / np.sqrt(k))


def _scatter(y: FloatArray) -> float:
    """Return the scatter of y (n,) in divisions beside rounding (Sheppard's correction)."""
    return float(np.sqrt(max(float(y.var(ddof=1)) - 1 / 12, 0.2**2)))


def _read(
    family: int, count: int, *, n: int, scatter: float, seed: int, skewed_as: FloatArray
) -> FloatArray:
    """Return readings (n, count), in whole divisions where there is a dial."""
    if family == _SKEWED:
        drawn = _skewed(skewed_as, seed, (n, count))
    else:
        rng = np.random.default_rng([seed, count, family])
        drawn = _FAMILIES[family](rng, (n, count))
    if not scatter:
        return drawn
    offset = np.random.default_rng([seed, count]).uniform(-0.5, 0.5, size=count)
    readings = drawn * scatter
    readings += offset
    return np.rint(readings, out=readings)


def _p_value(
    cases: Sequence[tuple[Statistic, int]], y: FloatArray, read: Reader, below: float = 1.0
) -> float:
    """Return the largest share of simulations at least as extreme, of all families.

    1 as soon as one family's share is above CLEAR, after a first look at some simulations: up to
    that level it changes no verdict's chance; and as soon as it is above ``below``, from which it
    is of no interest.
    """
    shares = [1.0]
    for count, most in ((FIRST_SIMULATIONS, CLEAR), (SIMULATIONS, min(CLEAR, below))):
        shares = []
        for statistic, family in cases:
            shares.append(_share(statistic, family, y, read, count))
            if shares[-1] > most:
                return 1.0
    return max(shares)


def _share(statistic: Statistic, family: int, y: FloatArray, read: Reader, count: int) -> float:
    beaten = statistic(read(family, count)) >= statistic(y) - 1e-9
    return (1 + int(beaten.sum())) / (1 + count)
