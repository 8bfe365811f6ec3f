"""What scatters: covariances at several poses as joints and dial make them, and RP from them.

X and Y at a pose have the expected covariance sigma_1^2 j_1 j_1' + sigma_2^2 j_2 j_2'
+ c (j_1 j_2' + j_2 j_1') + sigma^2 I + d^2 / 12: j_1 and j_2 are the columns of its Jacobian, c the
covariance of the joints, sigma the dial's own scatter, d its division. The variances are fitted by
iterated weighted least squares, whose end is the maximum likelihood of Gaussian scatter; Fisher's
information gives their errors. Where the poses scatter about the fit more than sampling lets them,
all intervals are widened by the root of that ratio (Birge 1932).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.iso9283 import repeatability
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

SOURCES = ("joint 1", "joint 2", "dial")
UNITS = ("rad", "rad", "mm")
CYCLES = 30
_TOGETHER = len(SOURCES)
"""Place of the joints' covariance behind the variances of the sources."""
_MOST_STEPS, _MOST_TURNS, _SETTLED = 60, 1000, 1e-7
_NOTHING = 1e-20
"""No dial shows 1e-10 mm."""
_CLOSEST = 0.98
"""Largest correlation of the joints."""
_NONE = 1e-9
"""Share of the scatter that is taken for none, so that a dial without steps has a covariance."""
_NORMAL, _TAIL, _LEVEL = 1.96, 0.025, 0.05
_STEP, _LEAST = 1e-3, 1e-9
_TINY = 1e-60
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

    @classmethod
    def of(
        cls,
        left: FloatArray,
        freedom: FloatArray | float,
        arm: Arm,
        joints_deg: npt.ArrayLike,
        division: npt.ArrayLike,
    ) -> PoseCovariances:
        """Return those of what is left (P, n, 2) of ``freedom``, read on dials of divisions (2,).

        In mm; ``joints_deg`` (P, 2) are those of an ``arm``.
        """
        degrees = np.broadcast_to(np.asarray(freedom, dtype=np.float64), len(left))
        observed = np.swapaxes(left, 1, 2) @ left / degrees[:, np.newaxis, np.newaxis]
        return cls(observed, degrees, patterns_of(arm, joints_deg), rounding_of(division))

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
    jacobian = arm.jacobian(joints_deg)
    products = np.einsum("pik,pjl->pklij", jacobian, jacobian)
    dial = np.broadcast_to(np.eye(2), products[:, 0, 0].shape)
    cross = products[:, 0, 1] + products[:, 1, 0]
    return np.stack([products[:, 0, 0], products[:, 1, 1], dial, cross], axis=1)


def rounding_of(division: npt.ArrayLike) -> FloatArray:
    """Return the covariance (2, 2) that rounding to divisions (2,) adds [mm2]."""
    return np.diag([rounding_uncertainty(step) ** 2 for step in np.asarray(division).tolist()])


def fit_variances(given: PoseCovariances, *, together: bool) -> FloatArray:
    """Return the variances (4,), those of the sources 0 or more, at which the patterns fit best.

    The last is the joints' covariance, 0 unless they may scatter ``together``; what it leaves of
    theirs stays possible.
    """
    from scipy.optimize import nnls  # noqa: PLC0415 - heavy

    size = np.linalg.norm(given.patterns, axis=(-2, -1)).mean(axis=0)
    each = np.linalg.norm(given.observed, axis=(-2, -1)).mean() / len(size)
    variances: FloatArray = each / size * [1, 1, 1, 0]
    for _ in range(_MOST_STEPS):
        before, (columns, target) = variances, given.columns(variances)
        unit = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
        columns = columns / unit * [1, 1, 1, together]
        signed = np.column_stack([columns, -columns[:, _TOGETHER]])
        *found, less = nnls(signed, target, maxiter=_MOST_TURNS)[0].tolist()
        found[_TOGETHER] -= less  # a covariance may be negative
        variances = np.array(found) / unit
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

    The last is the covariance of the joints: 0 unless chance, ``p_together``, would hardly make as
    much in joints that scatter apart. ``chi_square`` is how far the covariances are from the fit,
    of ``freedom`` where the sources are all.
    """

    given: PoseCovariances
    variances: FloatArray
    together: bool
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

    @property
    def alike(self) -> bool:
        """Whether the poses do not tell joint 1 from joint 2."""
        one, other = self.given.columns(self.variances)[0][:, :2].T
        return float(one @ other) ** 2 > _ALIKE * float(one @ one) * float(other @ other)

    def errors(self, variances: FloatArray) -> FloatArray:
        """Return the covariance (4, 4) of the variances fitted, were they ``variances``."""
        unit = np.linalg.norm(self.given.patterns, axis=(-2, -1)).mean(axis=0)
        columns = self.given.columns(variances)[0] / unit * [1, 1, 1, self.together]
        known = columns.T @ columns
        ridge = _LEAST * max(float(np.trace(known)), np.finfo(float).tiny)
        found = np.linalg.inv(known + ridge * np.eye(len(known)))
        found[_TOGETHER] *= self.together
        found[:, _TOGETHER] *= self.together
        return np.asarray(self.birge * found / np.outer(unit, unit))


def trace(given: PoseCovariances) -> Traced:
    """Return the fit of the sources to the covariances of two poses or more.

    The joints scatter together where the likelihood ratio says so at 5 %, over the misfit that is
    left (benchmarks/joint_scatter.py: at 1 % correlations of 0.5 are missed too often).
    """
    alone, free = (_fitted(given, together=together) for together in (False, True))
    gain = max(deviance(given, alone.variances) - deviance(given, free.variances), 0.0)
    p_together = _chance(1, gain / free.birge)
    return replace(free if p_together < _LEVEL else alone, p_together=p_together)


def _fitted(given: PoseCovariances, *, together: bool) -> Traced:
    variances = fit_variances(given, together=together)
    columns, target = given.columns(variances)
    left = target - columns @ variances
    freedom = 3 * np.count_nonzero(given.freedom) - np.count_nonzero(variances)
    return Traced(given, variances, together, float(left @ left), max(int(freedom), 1))


def _chance(freedom: float, chi_square: float) -> float:
    from scipy.special import chdtrc  # noqa: PLC0415 - heavy

    return float(chdtrc(freedom, chi_square))


def source_intervals(traced: Traced) -> Iterator[tuple[float, float]]:
    """Yield the 95 % interval of the deviation of each of the `SOURCES` [rad, mm].

    An end is where the fitted variance lies 1.96 standard errors away, were that end the true one
    (a score interval, Wilson 1927). A lower end is 0 where nothing speaks against it.
    """
    for k, value in enumerate(traced.variances[: len(SOURCES)].tolist()):
        low, high = (_end(traced, k, value, sign) for sign in (-1.0, 1.0))
        yield math.sqrt(low), math.sqrt(high)


def _end(traced: Traced, k: int, value: float, sign: float) -> float:
    """Return an end of the interval of a variance; the joints' correlation stays."""
    end, variances = value, traced.variances.copy()
    size = math.sqrt(variances[0] * variances[1])
    correlated = variances[_TOGETHER] / size if size else 0.0
    for _ in range(_MOST_STEPS):
        variances[k] = before = end
        variances[_TOGETHER] = correlated * math.sqrt(variances[0] * variances[1])
        end = max(0.0, value + sign * _NORMAL * math.sqrt(traced.errors(variances)[k, k]))
        if abs(end - before) <= _STEP**2 * end:
            break
    return end


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
    error = math.sqrt(float(slopes @ traced.errors(traced.variances) @ slopes))
    reach = _NORMAL * error / (1 - value**2)
    return value, math.tanh(math.atanh(value) - reach), math.tanh(math.atanh(value) + reach)


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
    of_fit = np.einsum("mk,kl,ml->m", slope, traced.errors(traced.variances), slope)
    errors = np.stack([traced.birge * of_test**2, of_fit])
    new, fitted = 1 / (2 * np.clip(errors, _LEAST, _UNKNOWN**2))
    low, high = (value * np.sqrt(fdtri(new, fitted, tail)) for tail in (_TAIL, 1 - _TAIL))
    return value, low, high


_RATIOS = np.linspace(0.0, 1.0, 11)
_TESTS = 2000


def gaussian_rp(covariance: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Return expected RP (...) and its relative standard error in one test of n cycles.

    ``covariance`` (..., 2, 2) is that of X and Y, in mm2; RP (7.2.2) is in mm. Both follow from the
    two standard deviations, by simulated tests.
    """
    b, a = np.moveaxis(np.sqrt(np.maximum(np.linalg.eigvalsh(covariance), _TINY)), -1, 0)
    value, error = (np.interp(b / a, _RATIOS, of) for of in _rp_of_shapes(n))
    return a * value, error


@lru_cache(maxsize=4)
def _rp_of_shapes(n: int) -> tuple[FloatArray, FloatArray]:
    """Return expected RP and relative error of n cycles of deviations 1 and each of `_RATIOS`."""
    along, across = np.random.default_rng(n).normal(size=(2, _TESTS, n))
    tests = [repeatability(np.stack([along, ratio * across], axis=1)).RP for ratio in _RATIOS]
    RP = np.array(tests)
    return RP.mean(axis=1), RP.std(axis=1) / RP.mean(axis=1)
