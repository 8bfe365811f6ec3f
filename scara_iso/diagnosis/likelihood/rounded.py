"""Evidence that knows the dial: likelihoods of rounded readings, with light and heavy tails.

A reading y on a dial of division d is right for every value within d / 2 of it, so its likelihood
about a mean m is F((y + d/2 - m) / s) - F((y - d/2 - m) / s), F the distribution of the scatter:
Gaussian, or Student's t with 4 degrees of freedom, under which one odd reading is nothing much. The
coefficients of a course have the Gaussian prior of `hypothesis_set`, the pose a flat one; both are
integrated out by Laplace's method: about the mode that Newton's steps reach, the logarithm of
likelihood times prior is taken for a parabola (Tierney and Kadane 1986). The scatter s is
integrated over a grid under the prior 1 / s, which ends at LEAST_ON_DIAL divisions and at MISFIT of
the readings' own: a course that meets every reading would else be as likely as one likes.

The normal distribution function is one polynomial. With K = 3.75 and t = (z - K) / (z + K), z >= 0,
the function (1 + 2z) exp(z^2) erfc(z) is smooth in t from -1 to 1 (M. M. Shepherd and J. G.
Laframboise, "Chebyshev approximation of (1 + 2x) exp(x^2) erfc x in 0 <= x < infinity", Math. Comp.
36 (1981) 249-253); the polynomial of degree 18 meets it where the Chebyshev polynomial T_18 is 1 or
-1. scipy has the same function, and takes longer to import than a diagnosis to compute.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, extended
from scara_iso.diagnosis.tuning import (
    AMPLITUDES,
    GAIN,
    HEAVY_SHARE,
    KNOWN_FROM,
    LEAST_ON_DIAL,
    MISFIT,
)
from scara_iso.effects import Chain, Shape
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_K, _ZERO = 3.75, 40.0
_POWERS = (
    -1.2654303393592009e-07,
    1.4882679398818525e-08,
    1.5105818731866598e-06,
    -1.0984355621455880e-06,
    -1.1184673802156865e-05,
    2.2514577829156398e-05,
    5.1477137114096358e-05,
    -2.9023876981947765e-04,
    2.9378402724250107e-04,
    1.7556600424267650e-03,
    -9.7465967373663778e-03,
    2.8362269150951046e-02,
    -5.8693396286013763e-02,
    9.2304322261030469e-02,
    -1.0880393028418231e-01,
    8.2276738422530235e-02,
    3.5854154880977651e-03,
    -1.4024059858430921e-01,
    1.2375126308378273e00,
)
"""The highest power first."""


def normal_cdf(x: FloatArray) -> FloatArray:
    """Return the standard normal distribution function at finite x of any shape, element-wise.

    The relative error is below 1e-12 down to the smallest numbers there are.
    """
    x = np.asarray(x, dtype=np.float64)
    z = np.minimum(np.abs(x) / np.sqrt(2), _ZERO)
    t = (z - _K) / (z + _K)
    tail = np.full_like(t, _POWERS[0])
    for power in _POWERS[1:]:
        tail *= t
        tail += power
    tail *= 0.5 * np.exp(-(z**2)) / (1 + 2 * z)
    return np.asarray(np.where(x > 0, 1 - tail, tail))


WIDTH_OF_SHAPES = 2
"""Columns of a shape; a random course has more."""
_SCATTERS = 6
_NEWTON = 5
_SETTLED = 1e-7
"""Step, in scatters, from which the readings' likelihood is taken for that at the mode."""
_TINY = 1e-300

Distribution = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
"""Of x: tail beyond |x|, density, and the density's slope."""


@dataclass(frozen=True, eq=False, slots=True)
class CoursesOfLikeWidth:
    """Courses of like width: design (c, n, p), prior variance of the last k columns (c, k).

    ``products`` (c, n, p p) are those of any two columns, none where these are many.
    """

    y: FloatArray
    half: FloatArray
    design: FloatArray
    products: FloatArray
    fixed: int
    variances: FloatArray
    scale: FloatArray

    def scatters(self, start: FloatArray, least: float, *, heavy: bool) -> FloatArray:
        """Return scatters to try, (courses, SCATTERS), about that of the Gaussian fit."""
        left = (self.y - (self.design @ start[..., np.newaxis])[..., 0]) / self.scale
        squares = (left**2).sum(axis=1) / (len(self.y) - self.fixed)
        size = median(np.abs(left), axis=1) * 1.3 if heavy else np.sqrt(squares)
        least = max(least, MISFIT * float(self.y.std()))
        low = np.maximum(0.45 * size, least)
        high = np.maximum(2.2 * size, 4 * least)
        part = np.linspace(0, 1, _SCATTERS)
        return np.asarray(low[:, np.newaxis] * (high / low)[:, np.newaxis] ** part)

    def start(self) -> FloatArray:
        """Return coefficients (c, p) for light tails and no dial."""
        at = self.y @ self.design
        at[:, self.fixed :] *= self.variances / (1 + self.variances)
        return np.asarray(at)

    def at(
        self,
        start: FloatArray,
        s: FloatArray,
        distribution: Distribution,
        weight: Callable[[FloatArray], FloatArray],
    ) -> tuple[FloatArray, FloatArray]:
        """Return log evidence and log likelihood (c, S) for scatters s (c, S).

        Newton's steps begin at ``start`` (c, p); a course that has settled takes none further.
        """
        wide = s[:, :, np.newaxis] * self.scale[:, np.newaxis]
        prior = np.zeros((*s.shape, self.design.shape[2]))
        prior[..., self.fixed :] = 1 / (self.variances[:, np.newaxis] * s[..., np.newaxis] ** 2)
        at = np.repeat(start[:, np.newaxis], s.shape[1], axis=1)
        log_p, curvature, least = np.empty((3, *wide.shape))
        moving: slice | IntArray = slice(None)
        for steps in range(_NEWTON + 1):
            own, scatter = self._of(moving), wide[moving]
            left = self.y - at[moving] @ np.swapaxes(own.design, 1, 2)
            log_p[moving], slope, curvature[moving] = _reading(
                left, self.half, scatter, distribution
            )
            if steps == _NEWTON:
                break
            least[moving] = 0.3 * weight(left / scatter) / scatter**2
            weighed = np.maximum(curvature[moving], least[moving])
            step = own._step(at[moving], slope, weighed, prior[moving])
            at[moving] += step
            settled = np.abs(step) < _SETTLED * s[moving, :, np.newaxis]
            still = ~settled.all(axis=(1, 2))
            if not still.any():
                break
            if not still.all():
                moving = np.arange(len(s))[moving][still]
        information = self._information(np.maximum(curvature, self._floor(least, wide)), prior)
        likelihood = log_p.sum(axis=2)
        evidence = likelihood - (prior * at**2).sum(axis=2) / 2
        evidence += np.log(prior[..., self.fixed :]).sum(axis=2) / 2
        evidence -= np.linalg.slogdet(information)[1] / 2
        return evidence, likelihood

    def _of(self, courses: slice | IntArray) -> CoursesOfLikeWidth:
        """Return the group of some of its courses, by number."""
        return replace(
            self,
            design=self.design[courses],
            products=self.products[courses],
            variances=self.variances[courses],
            scale=self.scale[courses],
        )

    def _step(
        self, at: FloatArray, slope: FloatArray, curvature: FloatArray, prior: FloatArray
    ) -> FloatArray:
        """Return Newton's step (c, S, p) by the readings' slope and curvature (c, S, n)."""
        information = self._information(curvature, prior)
        uphill = slope @ self.design - prior * at
        return np.asarray(np.linalg.solve(information, uphill[..., np.newaxis])[..., 0])

    def _floor(self, least: FloatArray, wide: FloatArray) -> FloatArray:
        """Return the curvature of a reading that is taken at least, ``least`` the one on the way.

        A random course moves each reading by itself, and within its division d it is as likely
        anywhere: a box of the width and height that a Gaussian of variance d^2 / (2 pi) has too.
        """
        if self.variances.shape[1] <= WIDTH_OF_SHAPES:
            return 0.03 * least
        return least / 0.3 / (1 + (2 * self.half / wide) ** 2 / (2 * np.pi))

    def _information(self, curvature: FloatArray, prior: FloatArray) -> FloatArray:
        if self.products.size:
            information = (curvature @ self.products).reshape(*prior.shape, -1)
        else:
            turned = np.swapaxes(self.design, 1, 2)[:, np.newaxis]
            information = (turned * curvature[:, :, np.newaxis]) @ self.design[:, np.newaxis]
        return np.asarray(information + prior[..., np.newaxis] * np.eye(prior.shape[-1]))


def _reading(
    left: FloatArray, half: FloatArray, wide: FloatArray, distribution: Distribution
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return log likelihood of each reading, its slope in the mean, and minus its curvature.

    ``left`` is how far it is from the mean, ``wide`` its scatter.
    """
    a, b = (left - half) / wide, (left + half) / wide
    tail_a, fa, slope_a = distribution(a)
    tail_b, fb, slope_b = distribution(b)
    across = (a < 0) & (b > 0)
    p = np.maximum(np.where(across, 1 - tail_a - tail_b, np.abs(tail_a - tail_b)), _TINY)
    scale = p * wide
    slope = (fa - fb) / scale
    return np.log(p), slope, slope**2 - (slope_b - slope_a) / (scale * wide)


def _gaussian(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    density = np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi)
    return normal_cdf(-np.abs(x)), density, -x * density


def _student(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return Student's t with 4 degrees of freedom in closed form."""
    u = 1 / (1 + x**2 / 4)
    root = np.sqrt(u)
    at = np.abs(x) * root
    density = 0.375 * u**2 * root
    return 0.5 - 0.375 * at * (1 - at**2 / 12), density, -1.25 * x * u * density


def _even(x: FloatArray) -> FloatArray:
    return np.ones_like(x)


def _heavy(x: FloatArray) -> FloatArray:
    return np.asarray(1.25 / (1 + x**2 / 4))


FAMILIES: tuple[tuple[Distribution, Callable[[FloatArray], FloatArray]], ...] = (
    (_gaussian, _even),
    (_student, _heavy),
)


_LARGEST = GAIN * AMPLITUDES[-1][0]
_SAME = 1e-9
_SOME = 8
"""Columns of a smooth course; a rough one has one in nearly every cycle. Each is compared apart."""
_NO_DIAL = 1e-4
"""Division, over the standard deviation, of readings that are not rounded."""
_NEGLIGIBLE = 0.05 - 1e-9
"""Columns of less prior variance, over the scatter's, are left out; a walk has one of 0.05."""


@dataclass(frozen=True, eq=False, slots=True)
class DialCourse:
    """A member of a set beside what is fitted: columns (n, k), prior variances (k,), scale (n,).

    ``parameters`` is how many numbers choose it among the forms of its effect (those of hidden
    states as many as their chance is worth), ``coefficients`` how many each axis estimates: those
    of a shape, none of a random course. ``hidden`` states are a shape that chance has drawn.
    """

    columns: FloatArray
    variances: FloatArray
    scale: FloatArray
    parameters: float = 0
    coefficients: int = 0
    hidden: bool = False

    @property
    def numbers(self) -> float:
        """How many numbers are fitted in each axis, those that choose the course included."""
        return self.parameters + self.coefficients

    @property
    def moved(self) -> npt.NDArray[np.bool_]:
        """Which readings it takes from where most of them are, shape (n,)."""
        away = np.abs(self.columns - median(self.columns)) > _SAME
        return np.asarray(away.any(axis=1))

    @property
    def as_large_as_may_be(self) -> DialCourse:
        """It, its coefficients hardly held by a prior."""
        return replace(self, variances=np.full(len(self.variances), _LARGEST))

    @property
    def random(self) -> bool:
        """Whether chance draws it."""
        return not self.coefficients and bool(self.variances.size)


@dataclass(frozen=True, eq=False, slots=True)
class DialLikelihoods:
    """Logs of the marginal and of the largest likelihood, shape (courses, families).

    The families are the Gaussian and Student's t. ``at_best`` is the marginal one at the likeliest
    scatter: the likelihood of a random course, up to what the pose takes from every course.
    """

    marginal: FloatArray
    largest: FloatArray
    at_best: FloatArray

    @property
    def mixed(self) -> FloatArray:
        """Log marginal likelihood (courses,) over both families."""
        share = np.log([1 - HEAVY_SHARE, HEAVY_SHARE])
        return np.asarray(np.logaddexp.reduce(self.marginal + share, axis=1))


def course_of(hypotheses: HypothesisSet, i: int) -> DialCourse:
    """Return member ``i`` of a set (as amplified) as a course."""
    n, shaped = len(hypotheses.basis), len(hypotheses.first)
    form = hypotheses.members[i].form
    searched = (
        0
        if isinstance(form, Chain)
        else sum(not isinstance(value, str) for value in form.parameters.values())
    )
    if i >= shaped:
        return DialCourse(np.empty((n, 0)), np.empty(0), hypotheses.scales[i - shaped], searched)
    shrink, vectors = hypotheses.of_member(i)
    variances = shrink / (1 - shrink)
    if isinstance(form, Shape):
        return DialCourse(vectors, variances, np.ones(n), searched, len(variances))
    kept = variances > _NEGLIGIBLE
    return DialCourse(vectors[:, kept], variances[kept], np.ones(n), searched + 1)


def course_beside(basis: FloatArray, columns: FloatArray, parameters: float) -> DialCourse:
    """Return the course of ``columns`` (n, k) beside ``basis``, as large as it may be."""
    own = extended(basis, columns)[:, basis.shape[1] :]
    k = own.shape[1]
    return DialCourse(own, np.full(k, _LARGEST), np.ones(len(own)), parameters, k)


def scatter_alone(n: int) -> DialCourse:
    """Return the course that moves nothing."""
    return DialCourse(np.empty((n, 0)), np.empty(0), np.ones(n))


def fitted_courses(
    y: FloatArray,
    half: FloatArray,
    basis: FloatArray,
    courses: Sequence[DialCourse],
    known: float = 0.0,
    least: float = LEAST_ON_DIAL,
) -> DialLikelihoods:
    """Return likelihoods of residuals y (n,) about courses beside ``basis`` (n, f).

    ``half`` (n,) is half a division in each cycle, 0 where there is no dial; ``known`` the scatter
    where it was stated (`KNOWN_FROM`), else 0; ``least`` the least scatter in divisions.
    """
    unit = float(2 * half.max()) or _NO_DIAL * float(y.std())
    half = np.where(half > 0, half, unit / 2) / unit
    found = DialLikelihoods(*np.empty((3, len(courses), 2)))
    sizes = np.searchsorted((WIDTH_OF_SHAPES, _SOME), [len(course.variances) for course in courses])
    for size in np.unique(sizes):
        own = np.flatnonzero(sizes == size).tolist()
        group = _of_like_width([courses[i] for i in own], y / unit, half, basis)
        start = group.start()
        for family, (distribution, weight) in enumerate(FAMILIES):
            s = group.scatters(start, least, heavy=family > 0)
            evidence, likelihood = group.at(start, s, distribution, weight)
            m = KNOWN_FROM - 1 if known else 0
            stated = -m * (np.log(s) + (known / unit / s) ** 2 / 2)
            apart = np.log(s[:, 1] / s[:, 0])
            integrated = np.logaddexp.reduce(evidence + stated, axis=1)
            found.marginal[own, family] = np.log(apart) + integrated
            found.largest[own, family] = likelihood.max(axis=1)
            found.at_best[own, family] = evidence.max(axis=1)
    return found


def _of_like_width(
    courses: Sequence[DialCourse], y: FloatArray, half: FloatArray, basis: FloatArray
) -> CoursesOfLikeWidth:
    width = max(len(course.variances) for course in courses)
    columns = np.zeros((len(courses), len(y), width))
    variances = np.ones((len(courses), width))
    for i, course in enumerate(courses):  # columns of zeros add nothing
        columns[i, :, : len(course.variances)] = course.columns
        variances[i, : len(course.variances)] = course.variances
    shared = np.broadcast_to(basis, (len(courses), *basis.shape))
    design = np.concatenate([shared, columns], axis=2)
    few = design if width <= _SOME else design[:, :, :0]
    products = (few[..., np.newaxis] * few[:, :, np.newaxis]).reshape(*columns.shape[:2], -1)
    scale = np.stack([course.scale for course in courses])
    return CoursesOfLikeWidth(y, half, design, products, basis.shape[1], variances, scale)
