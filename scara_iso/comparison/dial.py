"""What a dial's rounding can make of a figure: the part of a difference that is not the robot's.

With scatter below about one division, RP and mean depend on where the pose stands between two
divisions. The sources are silent on it; Gaussian scatter of the same size is put through the same
dial at the same place here, and the figure is taken as read and corrected for that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from statistics import NormalDist

import numpy as np

from scara_iso.comparison.spreads import spread
from scara_iso.iso9283 import GAUSSIAN_RP, hidden, standard_deviation, two_divisions
from scara_iso.quantities import rounding_uncertainty
from scara_iso.run import FloatArray

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
        return DialSpread(read, max(float(_hidden(width, positions)), read), error, open=True)
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


def _hidden(width: float, positions: FloatArray) -> FloatArray:
    return hidden(np.array(width), GAUSSIAN_RP[len(positions)], positions.shape[-1])


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
