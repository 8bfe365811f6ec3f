"""RP and +/- 3 s of many samples at once, each with the standard error of its logarithm.

What the studentised differences are by chance: cycles given to the two runs at random.

The means of two runs may differ (an indicator has no absolute zero), so readings are centred
before they are permuted: about their mean for the test of means, about their median for that of
spreads, whose level is then best (docs/evidence/comparing.md). One permutation serves all axes
and poses: what they have in common stays. Studentised statistics keep their level where the shapes
of the two scatters differ (Janssen 1997 for means, Pauly 2011 for spreads).

What a dial's rounding can make of a figure: the part of a difference that is not the robot's.

With scatter below about one division, RP and mean depend on where the pose stands between two
divisions. The sources are silent on it; Gaussian scatter of the same size is put through the same
dial at the same place here, and the figure is taken as read and corrected for that.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from statistics import NormalDist

import numpy as np

from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.iso9283 import (
    GAUSSIAN_ERROR,
    GAUSSIAN_RP,
    hidden,
    repeatability,
    standard_deviation,
    two_divisions,
)
from scara_iso.run import FloatArray, IntArray

_TINY = np.finfo(np.float64).tiny


def spread(positions: FloatArray, *, angle: bool) -> tuple[FloatArray, FloatArray]:
    """Return the figure and the standard error of its logarithm; shapes as the samples in front.

    ``positions`` of shape (..., components, n). The figure is RP = l_bar + 3 S_l (paper eq. 2-6,
    ISO 9283 7.2.2), of an ``angle`` +/- 3 s (7.2.2). The sources give no standard error; this is
    the infinitesimal jackknife's, and never smaller than that of Gaussian scatter.
    """
    if angle:
        figure = 3 * standard_deviation(positions[..., 0, :])
        influence = _influence_of_deviation(positions)
        gaussian = math.sqrt(0.5)
    else:
        figure = repeatability(positions).RP
        influence = _influence_of_repeatability(positions)
        gaussian = GAUSSIAN_ERROR[positions.shape[-2]]
    return figure, _relative_error(influence, figure, gaussian)


def spread_of_axes(positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return likewise the root of the sum of squares of the axes' RP, paper eq. 23."""
    each = positions[..., np.newaxis, :]
    parts = repeatability(each).RP
    figure = np.sqrt((parts**2).sum(axis=-1))
    pulls = parts[..., np.newaxis] * _influence_of_repeatability(each)
    influence = pulls.sum(axis=-2) / np.maximum(figure, _TINY)[..., np.newaxis]
    gaussian = GAUSSIAN_ERROR[1] / math.sqrt(positions.shape[-2])
    return figure, _relative_error(influence, figure, gaussian)


def _relative_error(influence: FloatArray, figure: FloatArray, gaussian: float) -> FloatArray:
    n = influence.shape[-1]
    error = np.sqrt((influence**2).sum(axis=-1) / (n * (n - 1)))
    return np.asarray(np.maximum(error / np.maximum(figure, _TINY), gaussian / math.sqrt(n)))


def _influence_of_deviation(positions: FloatArray) -> FloatArray:
    squares = _centred(positions)[..., 0, :] ** 2
    variance = squares.mean(axis=-1, keepdims=True)
    return np.asarray(3 * (squares - variance) / (2 * np.sqrt(np.maximum(variance, _TINY))))


def _influence_of_repeatability(positions: FloatArray) -> FloatArray:
    """Return what each cycle adds to RP: through l_bar, through S_l, and through the barycentre."""
    offset = _centred(positions)
    distance = np.sqrt((offset**2).sum(axis=-2))
    from_mean = distance - distance.mean(axis=-1, keepdims=True)
    variance = (from_mean**2).mean(axis=-1, keepdims=True)
    S_l = np.sqrt(np.maximum(variance, _TINY))
    direction = (offset / np.maximum(distance, _TINY)[..., np.newaxis, :]).mean(axis=-1)
    along = (direction[..., np.newaxis] * offset).sum(axis=-2)
    l_bar = distance.mean(axis=-1, keepdims=True)
    # d RP / d barycentre = (3 l_bar / S_l - 1) times the mean unit vector
    pull = np.where(variance > 0, 3 * l_bar / S_l - 1, 0.0) * along
    return np.asarray(from_mean + 3 * (from_mean**2 - variance) / (2 * S_l) + pull)


def _centred(positions: FloatArray) -> FloatArray:
    shifted = positions - positions[..., :1]
    return np.asarray(shifted - shifted.mean(axis=-1, keepdims=True))


_BLOCK = 2_000_000  # readings permuted at a time


@dataclass(frozen=True, slots=True)
class FigureColumns:
    """Which columns of the readings make a figure, and whether it is that of an angle."""

    name: str
    columns: tuple[int, ...]
    angle: bool = False


def permute(
    before: FloatArray,
    after: FloatArray,
    figures: Sequence[FigureColumns],
    rng: np.random.Generator,
    *,
    shuffles: int,
) -> FloatArray:
    """Return what chance makes of two runs' readings, shapes (columns, n) and (columns, m).

    Absolute studentised differences of means and of spreads, (columns + figures, permutations).
    """
    n, total = before.shape[1], before.shape[1] + after.shape[1]
    about_mean = _pooled(before, after, np.mean)
    about_median = _pooled(before, after, np.median)
    found, block = [], max(_BLOCK // about_mean.size, 1)
    for first in range(0, shuffles, block):
        shape = (min(block, shuffles - first), 1)
        orders = rng.permuted(np.tile(np.arange(total), shape), axis=1)
        means, spreads = _means(about_mean, orders, n), _spreads(about_median, orders, n, figures)
        found.append(np.concatenate([means, spreads]))
    return np.concatenate(found, axis=1)


def mean_error(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return Welch's standard error of the difference of means, over the last axis."""
    squares = [x.var(axis=-1, ddof=1) / x.shape[-1] for x in (before, after)]
    return np.asarray(np.sqrt(squares[0] + squares[1]))


def _pooled(before: FloatArray, after: FloatArray, centre: Callable[..., FloatArray]) -> FloatArray:
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
        # equal readings count as a large difference
        logs = np.log(np.maximum(second, _TINY)) - np.log(np.maximum(first, _TINY))
        found.append(_studentised(np.abs(logs), np.hypot(first_error, second_error)))
    return np.stack(found)


def _studentised(difference: FloatArray, error: FloatArray) -> FloatArray:
    """Return difference over error; 0 where both runs of a permutation are one value."""
    safe = np.where(error > 0, error, 1.0)
    return np.asarray(np.where(error > 0, difference / safe, np.where(difference > 0, np.inf, 0)))


_FINE = 2.0  # divisions of scatter above which rounding moves RP by less than 3 %
_LEAST = 0.3  # divisions of scatter below which more than two divisions are hardly ever read
_DRAWN = 2048


@dataclass(frozen=True, slots=True)
class DialSpread:
    """A figure through its dial: as read, and corrected for what Gaussian scatter gains there.

    Where two divisions hold all readings the figure is anywhere from 0 to ``freed``.
    """

    read: float
    freed: float
    error: float
    """Standard error of the figure's logarithm."""
    open: bool = False

    @property
    def lower(self) -> float:
        """Least figure that the robot may have, chance aside."""
        return 0.0 if self.open else min(self.read, self.freed)

    @property
    def upper(self) -> float:
        """Largest figure that the robot may have, chance aside."""
        return max(self.read, self.freed)


def through_dial(
    positions: FloatArray, resolutions: Sequence[float | None], *, angle: bool
) -> DialSpread:
    """Return the figure of positions of shape (components, n) through dials of ``resolutions``.

    A dial whose resolution is not known is taken as fine, but not where all readings are equal.
    """
    figure, relative_error = spread(positions, angle=angle)
    read, error = float(figure), float(relative_error)
    known = [resolution for resolution in resolutions if resolution is not None]
    if len(known) < len(resolutions):
        return DialSpread(read, read or math.inf, error, open=read == 0)
    width = float(two_divisions(positions, known))
    if width > 0:
        freed = float(hidden(np.array(width), GAUSSIAN_RP[len(positions)], positions.shape[-1]))
        return DialSpread(read, max(freed, read), error, open=True)
    return DialSpread(read, read / _gain(positions, np.array(known), angle=angle), error)


def ratio_range(before: DialSpread, after: DialSpread) -> tuple[float, float]:
    """Return the ratios after over before that the dials leave open, chance aside."""
    if before.open or after.open:
        return _over(after.lower, before.upper), _over(after.upper, before.lower)
    found = after.read / before.read, after.freed / before.freed
    return min(found), max(found)


def largest_bias(readings: FloatArray, resolution: float | None) -> float:
    """Return how far rounding can move the mean of readings of shape (n,), in their unit.

    Gaussian scatter: q / pi exp(-2 pi^2 sigma^2 / q^2), the first term of the Fourier series of
    the rounding error (Widrow and Kollar 2008); half a division where two hold all readings.
    """
    if resolution is None:
        return 0.0
    if two_divisions(readings[np.newaxis], [resolution]) > 0:
        return resolution / 2
    sigma = float(_scatter(readings[np.newaxis], np.array([resolution]))[0]) / resolution
    return resolution / math.pi * math.exp(-2 * (math.pi * sigma) ** 2)


def _over(above: float, below: float) -> float:
    return above / below if below > 0 else math.inf


def _gain(positions: FloatArray, resolutions: FloatArray, *, angle: bool) -> float:
    """Return the figure that these dials show of Gaussian scatter, over the figure it has."""
    sigma = _scatter(positions, resolutions)
    if np.all(sigma > _FINE * resolutions):
        return 1.0
    place = positions.mean(axis=-1, keepdims=True)
    scatter = _gaussian(len(positions)) * sigma[:, np.newaxis]
    step = resolutions[:, np.newaxis]
    shown = np.rint((place + scatter) / step) * step
    return float(spread(shown, angle=angle)[0] / spread(scatter, angle=angle)[0])


def _scatter(positions: FloatArray, resolutions: FloatArray) -> FloatArray:
    """Return the deviation of each component beside the rounding: Sheppard's correction."""
    rounding = np.array([rounding_uncertainty(resolution) for resolution in resolutions])
    variance = standard_deviation(positions) ** 2 - rounding**2
    return np.asarray(np.sqrt(np.maximum(variance, (_LEAST * resolutions) ** 2)))


@cache
def _gaussian(components: int) -> FloatArray:
    """Return evenly drawn Gaussian positions, the same in every call."""
    even = (np.arange(_DRAWN) + 0.5) / _DRAWN
    quantiles = np.array([NormalDist().inv_cdf(p) for p in even.tolist()])
    rng = np.random.default_rng(components)
    return np.stack([rng.permutation(quantiles) for _ in range(components)])
