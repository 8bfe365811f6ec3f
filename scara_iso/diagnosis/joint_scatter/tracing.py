"""Scatter at several poses to joints and dial, and from them to RP where nobody measured.

What is left of X and Y at a pose scatters as sigma_1^2 j_1 j_1' + sigma_2^2 j_2 j_2' + sigma^2 I +
d^2 / 12: j_1 and j_2 are the columns of its Jacobian, sigma is the dial's own, d its division. The
joints may scatter together, with a covariance of their own.
Where the poses scatter about this more than Gaussian sampling lets them, all intervals are widened
by the root of that ratio (Birge 1932).

RP that Gaussian scatter in the plane has in a test of n cycles is 7.2.2 by the law of distances. A
position in the plane is rho (cos phi, sin phi) stretched by the two standard deviations a and b:
rho is Rayleigh distributed, phi uniform, and the moments of the distance are those of rho times
those of sqrt(a2 cos2 phi + b2 sin2 phi).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.diagnosis.joint_scatter.covariances import (
    PoseCovariances,
    deviance,
    fit_variances,
    information,
    misfit,
    variance_intervals,
)
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

_ANGLES = 24
_RAYLEIGH = (math.sqrt(math.pi / 2), 2.0, 3 * math.sqrt(math.pi / 2), 8.0)
"""Moments of rho: 1st to 4th."""
_TINY = 1e-60


def gaussian_rp(covariance: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Return expected RP (...) and its relative standard error in one test of n cycles.

    ``covariance`` (..., 2, 2) is that of X and Y, in mm2; RP is in mm. The expectation is right to
    1 % from eight cycles on, the error, of the influence function, as n grows.
    """
    about_barycentre = (1 - 1 / n) * covariance
    mean, second, third, fourth = _moments(about_barycentre)
    variance = second - mean**2
    sd = np.sqrt(variance)
    skewness = (third - 3 * mean * second + 2 * mean**3) / sd**3
    kurtosis = (fourth - 4 * mean * third + 6 * mean**2 * second - 3 * mean**4) / sd**4
    S_l = sd * (1 - (kurtosis - 1 + 2 / (n - 1)) / (8 * n))  # second order of E sqrt(S_l^2)
    RP = mean + 3 * S_l
    influence = 1 + 3 * skewness + 2.25 * (kurtosis - 1)
    return RP, sd * np.sqrt(influence / (n - 1)) / RP


def _moments(covariance: FloatArray) -> tuple[FloatArray, ...]:
    """Return the 1st to the 4th moment (...) of the distance from the mean."""
    node, weight = np.polynomial.legendre.leggauss(_ANGLES)
    phi = (node + 1) * math.pi / 4
    b, a = np.moveaxis(np.linalg.eigvalsh(covariance), -1, 0)[..., np.newaxis]
    stretch = np.sqrt(np.maximum(a * np.cos(phi) ** 2 + b * np.sin(phi) ** 2, _TINY))
    return tuple(rho * stretch**power @ weight / 2 for power, rho in enumerate(_RAYLEIGH, start=1))


SOURCES = ("joint 1", "joint 2", "dial")
UNITS = ("rad", "rad", "mm")
_TOGETHER = len(SOURCES)
"""Place of the joints' covariance behind the variances of the sources."""
FEWEST_POSES = 2
CYCLES = 30
_CHI_SQUARE = 3.841
"""95 % of chi-square with one degree of freedom."""
_NORMAL = 1.96
_TAIL, _LEVEL = 0.025, 0.05
_STEP, _LEAST = 1e-3, 1e-9
_UNKNOWN = 0.5
"""Relative error of a prediction from which it says nothing: the interval is then 1 to 10."""
_ALIKE = 0.99
"""Squared correlation of the joints' information from which they are not told apart."""


@dataclass(frozen=True, eq=False, slots=True)
class Traced:
    """Covariances of poses with the variances (..., 4) that fit them best.

    They are those of the `SOURCES` and the covariance of the joints, which is 0, and ``held`` there
    (nan elsewhere), unless chance would hardly make it. Leading dimensions (...) are tests side by
    side; ``p_together`` (...) is the chance of such a covariance in joints that scatter apart.
    """

    given: PoseCovariances
    variances: FloatArray
    held: FloatArray
    chi_square: FloatArray
    freedom: FloatArray
    p_together: FloatArray

    @property
    def ratio(self) -> FloatArray:
        """Scatter of the covariances about the fit over that of sampling (...)."""
        return np.asarray(self.chi_square / self.freedom)

    @property
    def birge(self) -> FloatArray:
        """The ratio by which squared errors are widened (...), 1 or more."""
        return np.maximum(self.ratio, 1.0)

    @property
    def p_value(self) -> FloatArray:
        """Chance of as large a misfit where these sources are all (...)."""
        return _chance(self.freedom, self.chi_square)


def patterns_of(arm: Arm, joints_deg: npt.ArrayLike) -> FloatArray:
    """Return how the `SOURCES`, and a covariance of the joints, show at poses (P, 2).

    Covariances (P, 4, 2, 2) in mm2 for each rad2, of the dial 1.
    """
    columns = np.swapaxes(arm.jacobian(joints_deg), -1, -2)
    products = (
        columns[..., :, np.newaxis, :, np.newaxis] * columns[..., np.newaxis, :, np.newaxis, :]
    )
    dial = np.broadcast_to(np.eye(2), (*products.shape[:-4], 2, 2))
    together = products[..., 0, 1, :, :] + products[..., 1, 0, :, :]
    each = [products[..., 0, 0, :, :], products[..., 1, 1, :, :], dial, together]
    return np.stack(each, axis=-3)


def rounding_of(division: FloatArray) -> FloatArray:
    """Return the covariance (2, 2) that rounding to divisions (2,) adds [mm2]."""
    return np.diag([rounding_uncertainty(step) ** 2 for step in division])


def trace(given: PoseCovariances) -> Traced:
    """Return the fit of the sources to the covariances of two poses or more.

    The joints scatter together where the likelihood ratio says so at 5 %, over the misfit that is
    left (benchmarks/joint_scatter.py: at 1 % correlations of 0.5 are missed too often).
    """
    apart = np.full((*given.observed.shape[:-3], _TOGETHER + 1), np.nan)
    apart[..., _TOGETHER] = 0.0
    alone = fit_variances(given, apart)
    free = fit_variances(given)
    left = np.maximum(misfit(given, free) / _freedom(given, free), 1.0)
    ratio = np.maximum(deviance(given, alone) - deviance(given, free), 0.0) / left
    p_together = _chance(np.ones_like(ratio), ratio)
    chosen = (p_together < _LEVEL)[..., np.newaxis]
    variances = np.where(chosen, free, alone)
    return Traced(
        given,
        variances,
        np.where(chosen, np.nan, apart),
        misfit(given, variances),
        _freedom(given, variances),
        p_together,
    )


def _freedom(given: PoseCovariances, variances: FloatArray) -> FloatArray:
    entries = 3 * np.count_nonzero(given.freedom, axis=-1)
    return np.asarray(np.maximum(entries - np.count_nonzero(variances, axis=-1), 1))


def _chance(freedom: FloatArray, chi_square: FloatArray) -> FloatArray:
    from scipy.special import chdtrc  # noqa: PLC0415 - heavy

    return np.asarray(chdtrc(freedom, chi_square))


def correlation(traced: Traced) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value, low and high (...) of the correlation of the joints, 0 where they are apart.

    The interval is that of Fisher's z with the standard error that the information gives it.
    """
    first, second, _, together = np.moveaxis(traced.variances, -1, 0)
    size = np.sqrt(np.maximum(first * second, np.finfo(float).tiny))
    value = together / size
    slopes = np.stack(
        [
            -value / (2 * np.maximum(first, _LEAST * size)),
            -value / (2 * np.maximum(second, _LEAST * size)),
            np.zeros_like(value),
            1 / size,
        ],
        axis=-1,
    )
    variance = np.einsum("...k,...kl,...l->...", slopes, _errors(traced), slopes) * traced.birge
    reach = _NORMAL * np.sqrt(variance) / (1 - value**2)
    low, high = (np.tanh(np.arctanh(value) + sign * reach) for sign in (-1, 1))
    apart = ~np.isnan(traced.held[..., _TOGETHER])
    return value, np.where(apart, 0.0, low), np.where(apart, 0.0, high)


def alike(traced: Traced) -> bool:
    """Return whether the poses of one test do not tell joint 1 from joint 2."""
    known = information(traced.given, traced.variances)[:2, :2]
    return bool(known[0, 1] ** 2 > _ALIKE * known[0, 0] * known[1, 1])


def _errors(traced: Traced) -> FloatArray:
    """Return the covariance (..., 4, 4) of the variances fitted, 0 of those held."""
    unit = np.linalg.norm(traced.given.patterns, axis=(-2, -1)).mean(axis=0)
    units = unit * unit[:, np.newaxis]
    free = np.isnan(traced.held)
    both = free[..., np.newaxis] & free[..., np.newaxis, :]
    known = np.where(both, information(traced.given, traced.variances) / units, 0.0)
    size = np.maximum(np.trace(known, axis1=-2, axis2=-1), np.finfo(float).tiny)
    ridge = np.where(free, _LEAST, 1.0) * size[..., np.newaxis]
    found = np.linalg.inv(known + ridge[..., np.newaxis] * np.eye(len(unit)))
    return np.asarray(np.where(both, found, 0.0) / units)


def source_intervals(traced: Traced) -> tuple[FloatArray, FloatArray]:
    """Return the ends (3, ...) of the 95 % intervals of the `SOURCES`' deviations [rad, mm]."""
    largest = _CHI_SQUARE * traced.birge
    low, high = variance_intervals(traced.given, traced.variances, traced.held, largest)
    return np.sqrt(low), np.sqrt(high)


def neither(traced: Traced) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value, low and high (...) of the scatter in one direction at single poses [mm].

    A covariance u^2 v v' beside the fitted one raises the chi-square by nu / 2 (u / sigma)^4, sigma
    the scatter there: a non-central chi-square gives the interval.
    """
    from scipy.special import chdtr, chndtrinc  # noqa: PLC0415 - heavy

    half = traced.given.freedom.sum(axis=-1) / 2
    sigma = np.sqrt(_size(traced.given.expected(traced.variances)).mean(axis=-1))
    ends = []
    for chance in (1 - _TAIL, _TAIL):
        possible = chdtr(traced.freedom, traced.chi_square) > chance
        more = chndtrinc(traced.chi_square, traced.freedom, chance)
        ends.append(sigma * (np.where(possible, more, 0.0) / half) ** 0.25)
    excess = np.maximum(traced.chi_square - traced.freedom, 0.0)
    return sigma * (excess / half) ** 0.25, ends[0], ends[1]


def rp_at(
    traced: Traced, patterns: FloatArray, known: FloatArray, cycles: int = CYCLES
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return expected RP (..., m) in XY at m other poses, and its prediction interval [mm].

    ``patterns`` (m, 3, 2, 2) and ``known`` (2, 2) as of the fit. The square of a new test's RP over
    that of the expected one is taken as a ratio of two chi-squares over their degrees of freedom,
    which are those of the relative errors of test and fit.
    """
    from scipy.special import fdtri  # noqa: PLC0415 - heavy

    variances = traced.variances
    value, of_test = _expected_rp(variances, patterns, known, cycles)
    unit = np.linalg.norm(patterns, axis=(-2, -1)).mean(axis=0)
    step = _STEP * np.abs(variances * unit).sum(axis=-1, keepdims=True) + np.finfo(float).tiny
    slopes = [
        np.log(_expected_rp(variances + step * along / unit, patterns, known, cycles)[0] / value)
        for along in np.eye(len(unit))
    ]
    slope = np.stack(slopes, axis=-1) * unit / step[..., np.newaxis]
    of_fit = np.einsum("...mk,...kl,...ml->...m", slope, _errors(traced), slope)
    birge = traced.birge[..., np.newaxis]
    new, fitted = (
        1 / (2 * np.clip(birge * error, _LEAST, _UNKNOWN**2)) for error in (of_test**2, of_fit)
    )
    low, high = (value * np.sqrt(fdtri(new, fitted, tail)) for tail in (_TAIL, 1 - _TAIL))
    return value, low, high


def _expected_rp(
    variances: FloatArray, patterns: FloatArray, known: FloatArray, cycles: int
) -> tuple[FloatArray, FloatArray]:
    made = np.einsum("...k,mkij->...mij", variances, patterns)
    return gaussian_rp(known + made, cycles)


def _size(covariances: FloatArray) -> FloatArray:
    """Return the mean variance of the two axes."""
    return np.asarray(np.trace(covariances, axis1=-2, axis2=-1) / 2)
