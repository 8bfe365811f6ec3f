"""What scatters: covariances at several poses as joints and dial make them, and RP from them.

X and Y at a pose have the expected covariance sigma_1^2 j_1 j_1' + sigma_2^2 j_2 j_2'
+ c (j_1 j_2' + j_2 j_1') + sigma^2 I + d^2 / 12: j_1 and j_2 are the columns of its Jacobian, c the
covariance of the joints, sigma the dial's own scatter, d its division. The variances are fitted by
iterated weighted least squares, whose end is the maximum likelihood of Gaussian scatter. Where the
poses scatter about the fit more than sampling lets them, all intervals are widened by the root of
that ratio (Birge 1932).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

SOURCES = ("joint 1", "joint 2", "dial")
UNITS = ("rad", "rad", "mm")
CYCLES = 30
_TOGETHER = len(SOURCES)
"""Place of the joints' covariance behind the variances of the sources."""
_APART: Mapping[int, float] = {_TOGETHER: 0.0}
_MOST_STEPS, _MOST_TURNS, _SETTLED = 60, 1000, 1e-7
_NOTHING = 1e-20
"""No dial shows 1e-10 mm."""
_CLOSEST = 0.98
"""Largest correlation of the joints."""
_NONE = 1e-9
"""Share of the scatter that is taken for none, so that a dial without steps has a covariance."""
_CHI_SQUARE, _NORMAL = 3.841, 1.96
"""95 % of chi-square with one degree of freedom, and of a normal distribution."""
_TAIL, _LEVEL = 0.025, 0.05
_STEP, _LEAST = 1e-3, 1e-9
_UNKNOWN = 0.5
"""Relative error of a prediction from which it says nothing: the interval is then 1 to 10."""
_ALIKE = 0.99
"""Squared correlation of the joints' information from which they are not told apart."""


@dataclass(frozen=True, eq=False, slots=True)
class PoseCovariances:
    """Covariances of X and Y at P poses, and what they are made of [mm2].

    ``observed`` (P, 2, 2) have ``freedom`` (P,) degrees of freedom each, 0 for a pose that is left
    out; ``patterns`` (P, 4, 2, 2) are those of `patterns_of`, ``known`` (2, 2) that of rounding.
    """

    observed: FloatArray
    freedom: FloatArray
    patterns: FloatArray
    known: FloatArray

    def expected(self, variances: FloatArray) -> FloatArray:
        """Return the covariances (P, 2, 2) that ``variances`` (4,) make."""
        made = self.known + np.einsum("k,pkij->pij", variances, self.patterns)
        size = np.trace(self.observed, axis1=-2, axis2=-1).mean()
        floor = _NONE * (size + np.trace(made, axis1=-2, axis2=-1)) + _NOTHING
        return np.asarray(made + floor[:, np.newaxis, np.newaxis] * np.eye(2))

    def columns(self, variances: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the weighted least squares at ``variances``: columns (4 P, 4), target (4 P,).

        The columns' products are Fisher's information on the variances.
        """
        inverse = np.linalg.inv(np.linalg.cholesky(self.expected(variances)))
        whole = np.concatenate([self.patterns, (self.observed - self.known)[:, np.newaxis]], axis=1)
        seen = inverse[:, np.newaxis] @ whole @ np.swapaxes(inverse, 1, 2)[:, np.newaxis]
        weighted = np.sqrt(self.freedom / 2)[:, np.newaxis, np.newaxis, np.newaxis] * seen
        flat = np.moveaxis(weighted, 1, -1).reshape(-1, whole.shape[1])
        return flat[:, :-1], flat[:, -1]


def patterns_of(arm: Arm, joints_deg: npt.ArrayLike) -> FloatArray:
    """Return how the `SOURCES`, and a covariance of the joints, show at poses (P, 2).

    Covariances (P, 4, 2, 2) in mm2 for each rad2, of the dial 1.
    """
    one, other = np.moveaxis(arm.jacobian(joints_deg), -1, 0)
    cross = one[:, :, np.newaxis] * other[:, np.newaxis]
    own = [j[:, :, np.newaxis] * j[:, np.newaxis] for j in (one, other)]
    dial = np.broadcast_to(np.eye(2), cross.shape)
    return np.stack([*own, dial, cross + np.swapaxes(cross, -1, -2)], axis=1)


def rounding_of(division: npt.ArrayLike) -> FloatArray:
    """Return the covariance (2, 2) that rounding to divisions (2,) adds [mm2]."""
    return np.diag([rounding_uncertainty(step) ** 2 for step in np.asarray(division).tolist()])


def fit_variances(given: PoseCovariances, fixed: Mapping[int, float] | None = None) -> FloatArray:
    """Return the variances (4,), those of the sources 0 or more, at which the patterns fit best.

    Those ``fixed`` are not fitted. The last is the joints' covariance, which theirs leave possible.
    """
    from scipy.optimize import nnls  # noqa: PLC0415 - heavy

    fixed = fixed or {}
    size = np.linalg.norm(given.patterns, axis=(-2, -1)).mean(axis=0)
    each = np.linalg.norm(given.observed, axis=(-2, -1)).mean() / len(size)
    variances = np.append(each / size[:_TOGETHER], 0.0)
    variances[[*fixed]] = [*fixed.values()]
    free = [k for k in range(len(size)) if k not in fixed]
    for _ in range(_MOST_STEPS):
        before, (columns, target) = variances.copy(), given.columns(variances)
        of_free = target - columns[:, [*fixed]] @ variances[[*fixed]]
        unit = np.maximum(np.linalg.norm(columns[:, free], axis=0), np.finfo(float).tiny)
        signed = columns[:, free] / unit
        signed = np.concatenate([signed, -signed[:, [k == _TOGETHER for k in free]]], axis=1)
        found = nnls(signed, of_free, maxiter=_MOST_TURNS)[0]
        found[len(free) - 1] -= found[len(free) :].sum()  # a covariance may be negative
        variances[free] = found[: len(free)] / unit
        if _TOGETHER in free:
            most = _CLOSEST * math.sqrt(variances[0] * variances[1])
            variances[_TOGETHER] = np.clip(variances[_TOGETHER], -most, most)
        if np.all(np.abs(variances - before) * size <= _SETTLED * each):
            break
    return variances


def deviance(given: PoseCovariances, variances: FloatArray) -> float:
    """Return -2 log likelihood of Gaussian scatter, but for a constant."""
    expected = given.expected(variances)
    explained = np.trace(np.linalg.solve(expected, given.observed), axis1=-2, axis2=-1)
    return float(given.freedom @ (np.log(np.linalg.det(expected)) + explained))


@dataclass(frozen=True, eq=False, slots=True)
class Traced:
    """Covariances of poses with the variances (4,) of the sources that fit them best.

    The last is the covariance of the joints: 0 and ``fixed`` there unless chance, ``p_together``,
    would hardly make as much in joints that scatter apart. ``chi_square`` is how far the
    covariances are from the fit, of ``freedom`` where the sources are all.
    """

    given: PoseCovariances
    variances: FloatArray
    fixed: Mapping[int, float]
    chi_square: float
    freedom: int
    p_together: float = 1.0

    @property
    def ratio(self) -> float:
        """Scatter of the covariances about the fit over that of sampling."""
        return self.chi_square / self.freedom

    @property
    def birge(self) -> float:
        """The ratio by which squared errors are widened, 1 or more."""
        return max(self.ratio, 1.0)

    @property
    def p_value(self) -> float:
        """Chance of as large a misfit where these sources are all."""
        return _chance(self.freedom, self.chi_square)


def trace(given: PoseCovariances) -> Traced:
    """Return the fit of the sources to the covariances of two poses or more.

    The joints scatter together where the likelihood ratio says so at 5 %, over the misfit that is
    left (benchmarks/joint_scatter.py: at 1 % correlations of 0.5 are missed too often).
    """
    alone, free = (_fitted(given, fixed) for fixed in (_APART, {}))
    gain = max(deviance(given, alone.variances) - deviance(given, free.variances), 0.0)
    p_together = _chance(1, gain / free.birge)
    chosen = free if p_together < _LEVEL else alone
    return Traced(
        given, chosen.variances, chosen.fixed, chosen.chi_square, chosen.freedom, p_together
    )


def _fitted(given: PoseCovariances, fixed: Mapping[int, float]) -> Traced:
    variances = fit_variances(given, fixed)
    columns, target = given.columns(variances)
    left = target - columns @ variances
    freedom = 3 * np.count_nonzero(given.freedom) - np.count_nonzero(variances)
    return Traced(given, variances, fixed, float(left @ left), max(int(freedom), 1))


def _chance(freedom: float, chi_square: float) -> float:
    from scipy.special import chdtrc  # noqa: PLC0415 - heavy

    return float(chdtrc(freedom, chi_square))


def source_intervals(traced: Traced) -> Iterator[tuple[float, float]]:
    """Yield the 95 % interval of the deviation of each of the `SOURCES` [rad, mm].

    Inside it the `deviance`, at its least over the other variances, is at most 3.84 above that of
    the fit. A lower end is 0 where nothing speaks against it.
    """
    given, size = traced.given, traced.given.observed + traced.given.known
    most = np.trace(size, axis1=-2, axis2=-1).max() + _NOTHING
    smallest = np.trace(given.patterns, axis1=-2, axis2=-1).min(axis=0)
    level = deviance(given, traced.variances) + _CHI_SQUARE * traced.birge
    for k in range(len(SOURCES)):

        def above(deviation: float, k: int = k) -> float:
            at = {**traced.fixed, k: deviation**2}
            return deviance(given, fit_variances(given, at)) - level

        found = math.sqrt(traced.variances[k])
        outside = found + 10 * math.sqrt(most / smallest[k])
        yield _crossing(above, found, 0.0), _crossing(above, found, outside)


def _crossing(above: Callable[[float], float], inside: float, outside: float) -> float:
    """Return where a function passes 0 between two places, or the one that it does not leave."""
    from scipy.optimize import brentq  # noqa: PLC0415 - heavy

    if above(outside) <= 0:
        return outside
    if above(inside) >= 0:
        return inside
    return float(brentq(above, inside, outside, xtol=1e-6 * abs(outside - inside)))


def neither(traced: Traced) -> tuple[float, float, float]:
    """Return value, low and high of the scatter in one direction at single poses [mm].

    A covariance u^2 v v' beside the fitted one raises the chi-square by nu / 2 (u / sigma)^4, sigma
    the scatter there: a non-central chi-square gives the interval.
    """
    from scipy.special import chdtr, chndtrinc  # noqa: PLC0415 - heavy

    expected = traced.given.expected(traced.variances)
    sigma = math.sqrt(np.trace(expected, axis1=-2, axis2=-1).mean() / 2)
    half = traced.given.freedom.sum() / 2
    more = [max(traced.chi_square - traced.freedom, 0.0)]
    for chance in (1 - _TAIL, _TAIL):
        possible = chdtr(traced.freedom, traced.chi_square) > chance
        end = chndtrinc(traced.chi_square, traced.freedom, chance) if possible else 0.0
        more.append(float(end) if np.isfinite(end) else more[0])  # so large that chance is nothing
    value, low, high = (sigma * (one / half) ** 0.25 for one in more)
    return value, low, high


def correlation(traced: Traced) -> tuple[float, float, float] | None:
    """Return value, low and high of the joints' correlation; None where they scatter apart.

    The interval is that of Fisher's z with the standard error that the information gives it.
    """
    first, second, _, together = traced.variances.tolist()
    if not together:
        return None
    size = math.sqrt(first * second)
    value = together / size
    slopes = np.array([-value / (2 * first), -value / (2 * second), 0.0, 1 / size])
    variance = float(slopes @ _errors(traced) @ slopes) * traced.birge
    reach = _NORMAL * math.sqrt(variance) / (1 - value**2)
    return value, math.tanh(math.atanh(value) - reach), math.tanh(math.atanh(value) + reach)


def alike(traced: Traced) -> bool:
    """Return whether the poses do not tell joint 1 from joint 2."""
    one, other = traced.given.columns(traced.variances)[0][:, :2].T
    return float(one @ other) ** 2 > _ALIKE * float(one @ one) * float(other @ other)


def _errors(traced: Traced) -> FloatArray:
    """Return the covariance (4, 4) of the variances fitted, 0 of those held."""
    unit = np.linalg.norm(traced.given.patterns, axis=(-2, -1)).mean(axis=0)
    free = np.isin(np.arange(len(unit)), [*traced.fixed], invert=True)
    columns = traced.given.columns(traced.variances)[0][:, free] / unit[free]
    known = columns.T @ columns
    ridge = _LEAST * max(float(np.trace(known)), np.finfo(float).tiny)
    found = np.zeros((len(unit), len(unit)))
    found[np.ix_(free, free)] = np.linalg.inv(known + ridge * np.eye(len(known)))
    return found / np.outer(unit, unit)


def rp_at(
    traced: Traced, patterns: FloatArray, cycles: int = CYCLES
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return expected RP (m,) in XY at other poses of ``patterns`` (m, 4, 2, 2), and its interval.

    In mm. The interval holds what a new test measures: the square of its RP over that of the
    expected one is taken as a ratio of two chi-squares over their degrees of freedom, which are
    those of the relative errors of test and fit.
    """
    from scipy.special import fdtri  # noqa: PLC0415 - heavy

    def expected(variances: FloatArray) -> tuple[FloatArray, FloatArray]:
        made = np.einsum("k,mkij->mij", variances, patterns)
        return gaussian_rp(traced.given.known + made, cycles)

    value, of_test = expected(traced.variances)
    unit = np.linalg.norm(patterns, axis=(-2, -1)).mean(axis=0)
    step = _STEP * np.abs(traced.variances * unit).sum() + np.finfo(float).tiny
    moved = traced.variances + np.diag(step / unit)
    slope = np.stack([np.log(expected(one)[0] / value) for one in moved], axis=1) * unit / step
    of_fit = np.einsum("mk,kl,ml->m", slope, _errors(traced), slope)
    errors = np.stack([of_test**2, of_fit])
    new, fitted = 1 / (2 * np.clip(traced.birge * errors, _LEAST, _UNKNOWN**2))
    low, high = (value * np.sqrt(fdtri(new, fitted, tail)) for tail in (_TAIL, 1 - _TAIL))
    return value, low, high


_ANGLES = 24
_RAYLEIGH = (math.sqrt(math.pi / 2), 2.0, 3 * math.sqrt(math.pi / 2), 8.0)
"""Moments of rho: 1st to 4th."""
_TINY = 1e-60


def gaussian_rp(covariance: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Return expected RP (...) and its relative standard error in one test of n cycles.

    ``covariance`` (..., 2, 2) is that of X and Y, in mm2; RP (7.2.2) is in mm. The expectation is
    right to 1 % from eight cycles on, the error, of the influence function, as n grows. A position
    is rho (cos phi, sin phi) stretched by the two standard deviations: rho is Rayleigh distributed,
    phi uniform, and the distance's moments are those of rho times those of the stretch.
    """
    node, weight = np.polynomial.legendre.leggauss(_ANGLES)
    phi = (node + 1) * math.pi / 4
    variances = np.linalg.eigvalsh((1 - 1 / n) * covariance)  # about the barycentre
    b, a = np.moveaxis(variances, -1, 0)[..., np.newaxis]
    stretch = np.sqrt(np.maximum(a * np.cos(phi) ** 2 + b * np.sin(phi) ** 2, _TINY))
    mean, second, third, fourth = (
        rho * stretch**power @ weight / 2 for power, rho in enumerate(_RAYLEIGH, start=1)
    )
    sd = np.sqrt(second - mean**2)
    skewness = (third - 3 * mean * second + 2 * mean**3) / sd**3
    kurtosis = (fourth - 4 * mean * third + 6 * mean**2 * second - 3 * mean**4) / sd**4
    S_l = sd * (1 - (kurtosis - 1 + 2 / (n - 1)) / (8 * n))  # second order of E sqrt(S_l^2)
    RP = mean + 3 * S_l
    influence = 1 + 3 * skewness + 2.25 * (kurtosis - 1)
    return RP, sd * np.sqrt(influence / (n - 1)) / RP
