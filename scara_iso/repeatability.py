"""Repeatability of attained positions: the paper's eq. 2-6 and 23, ISO 9283 7.2.1 and 7.2.2.

One axis and a plane or space differ only in the number of components of a position, so one
function serves all: with one component the distance to the barycentre is eq. 3's |x_j - mean|.
Arrays end in the cycles of one pose; dimensions in front are poses and are kept.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from scara_iso.quantities import rounding_uncertainty
from scara_iso.run import FloatArray

# Relative standard error of RP times sqrt(n) for Gaussian scatter, equal in 1, 2 or 3 directions:
# standard deviation of the influence function of E[l] + 3 sd[l] over its value, l half-normal,
# Rayleigh or Maxwell distributed.
GAUSSIAN_ERROR = {1: 0.74737, 2: 0.57371, 3: 0.49973}
# E[l] + 3 sd[l] for the same three and unit scatter.
GAUSSIAN_RP = {1: 2.60632, 2: 3.21872, 3: 3.61609}

_JACKKNIFE_GROUPS = 128
_CONFIDENCE = 0.95
_WIDEST = math.log(1e6)


@dataclass(frozen=True, eq=False, slots=True)
class Repeatability:
    """RP and its intermediate values; each field has the shape of the poses in front.

    All in the unit of the readings; ``n`` is the number of cycles.
    """

    n: int
    mean: FloatArray
    """Barycentre, shape (..., components); eq. 2."""
    l_bar: FloatArray
    """Mean distance to the barycentre; eq. 4."""
    S_l: FloatArray
    """Standard deviation of that distance, with n - 1; eq. 5."""
    RP: FloatArray
    """l_bar + 3 S_l; eq. 6 for one axis, ISO 9283 7.2.2 for several."""


def repeatability(positions: FloatArray) -> Repeatability:
    """Return RP = l_bar + 3 S_l of positions of shape (..., components, n), n at least 2.

    Paper eq. 2-6 (one component) and ISO 9283 7.2.2 (several): l_j is the distance of attained
    position j to the barycentre, S_l has n - 1.
    """
    shifted = positions - positions[..., :1]  # keeps the digits of readings far from zero
    centre = shifted.mean(axis=-1, keepdims=True)
    distance = _length(shifted - centre)
    l_bar = distance.mean(axis=-1)
    S_l = distance.std(axis=-1, ddof=1)
    return Repeatability(
        n=positions.shape[-1],
        mean=(positions[..., :1] + centre)[..., 0],
        l_bar=l_bar,
        S_l=S_l,
        RP=l_bar + 3 * S_l,
    )


def standard_deviation(readings: FloatArray) -> FloatArray:
    """Return the sample standard deviation over the last axis, with n - 1; ISO 9283's S_a."""
    shifted = readings - readings[..., :1]
    return np.asarray(shifted.std(axis=-1, ddof=1))


def rp_interval(
    positions: FloatArray, *, resolutions: Sequence[float] | None
) -> tuple[FloatArray, FloatArray]:
    """Return lower and upper limits of a 95 % interval for RP; shapes as the poses in front.

    ``positions`` as in `repeatability`, n at least 5; ``resolutions`` one for each component, None
    where not known. The sources give no interval; this one is log-normal with the jackknife's
    standard error, but never one smaller than Gaussian scatter has; the upper limit is also
    stretched for skewness by Efron's acceleration (ABC interval). With known resolutions the lower
    limit is that of RP, or of Gaussian scatter's where that is less, without the rounding
    (Sheppard's correction). Where one division or two neighbouring ones hold all readings, the
    lower limit is 0 and the upper one at least what they can hide. Coverage is in
    docs/repeatability.md.
    """
    components, n = positions.shape[-2:]
    RP = repeatability(positions).RP
    error, skewness = _jackknife(positions)
    t = _student_quantile(n - 1)
    gaussian = GAUSSIAN_ERROR[components] / math.sqrt(n)
    spread = np.minimum(t * np.maximum(error, gaussian), _WIDEST)
    stretched = np.minimum(error * _accelerated(t, skewness), _WIDEST)
    upper = RP * np.exp(np.maximum(spread, stretched))
    if resolutions is None:
        return RP * np.exp(-spread), upper
    width = two_divisions(positions, resolutions)
    lower = _beside_rounding(positions, RP, resolutions) * np.exp(-spread)
    return np.where(width > 0, 0.0, lower), np.maximum(upper, hidden(width, components, n))


def _jackknife(positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return standard error and skewness (Efron's a) of ln RP by leaving cycles out."""
    n = positions.shape[-1]
    groups = min(n, _JACKKNIFE_GROUPS)
    left_out = np.arange(n) % groups
    without = np.stack(
        [repeatability(positions[..., left_out != g]).RP for g in range(groups)], axis=-1
    )
    tiny = np.finfo(np.float64).tiny
    logs = np.log(np.maximum(without, tiny))  # a single reading may hold all of RP
    deviation = logs.mean(axis=-1, keepdims=True) - logs
    squares = (deviation**2).sum(axis=-1)
    error = np.sqrt((groups - 1) / groups * squares)
    cubes = (deviation**3).sum(axis=-1)
    return np.asarray(error), cubes / (6 * np.maximum(squares**1.5, tiny))


def _accelerated(t: float, skewness: FloatArray) -> FloatArray:
    """Return Efron's (1987) accelerated quantile, with at most a hundredfold stretch."""
    shifted = skewness + t
    room = 1 - skewness * shifted
    return np.asarray(shifted / np.maximum(room, 0.1) ** 2)


def _beside_rounding(
    positions: FloatArray, RP: FloatArray, resolutions: Sequence[float]
) -> FloatArray:
    """Return RP without what rounding may have added: Sheppard's (1898) correction."""
    components = positions.shape[-2]
    variance = (standard_deviation(positions) ** 2).sum(axis=-1)
    rounding = sum(rounding_uncertainty(resolution) ** 2 for resolution in resolutions)
    share = 1 - rounding / np.maximum(variance, max(rounding, np.finfo(np.float64).tiny))
    # Gaussian scatter on three divisions looks long-tailed: its RP is read too large.
    gaussian = GAUSSIAN_RP[components] * np.sqrt(variance / components)
    return np.asarray(np.minimum(RP, gaussian) * np.sqrt(share))


def two_divisions(positions: FloatArray, resolutions: Sequence[float]) -> FloatArray:
    """Return the width of the one or two divisions that hold all readings, 0 if there are more.

    A robot without scatter can read so: it stands still on the border of two divisions.
    """
    widths = np.ptp(positions, axis=-1) + np.asarray(resolutions)
    held = np.all(widths < 2.5 * np.asarray(resolutions), axis=-1)
    return np.where(held, widths.max(axis=-1), 0.0)


def hidden(width: FloatArray, components: int, n: int) -> FloatArray:
    """Return the RP of the scatter that stays inside ``width`` n times one time in twenty."""
    all_inside = (1 - _CONFIDENCE) ** (1 / n)
    sigma = width / (2 * NormalDist().inv_cdf((1 + all_inside) / 2))
    return GAUSSIAN_RP[components] * sigma


def _student_quantile(nu: int) -> float:
    """Return Student's t for a 95 % interval: Abramowitz and Stegun 26.7.5, four terms."""
    z = NormalDist().inv_cdf((1 + _CONFIDENCE) / 2)
    terms: tuple[float, ...] = (
        (z**3 + z) / 4,
        (5 * z**5 + 16 * z**3 + 3 * z) / 96,
        (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384,
        (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / 92160,
    )
    return z + math.fsum(term / nu ** (k + 1) for k, term in enumerate(terms))


def _length(vectors: FloatArray) -> FloatArray:
    """Return Euclidean lengths of vectors of shape (..., components, n)."""
    if vectors.shape[-2] == 1:
        return np.abs(vectors[..., 0, :])
    return np.asarray(np.sqrt((vectors**2).sum(axis=-2)))
