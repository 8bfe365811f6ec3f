"""Evidence that knows the dial: likelihoods of rounded readings, with light and heavy tails.

A reading y on a dial of division d is right for every value within d / 2 of it, so its likelihood
about a mean m is F((y + d/2 - m) / s) - F((y - d/2 - m) / s), F the distribution of the scatter:
Gaussian, or Student's t with 4 degrees of freedom, under which one odd reading is nothing much. The
coefficients of a course have the Gaussian prior of `hypotheses`, the pose a flat one; both are
integrated out by Laplace's method: about the mode that Newton's steps reach, the logarithm of
likelihood times prior is taken for a parabola (Tierney and Kadane 1986). The scatter s is
integrated over a grid under the prior 1 / s, which ends at LEAST_ON_DIAL divisions and at MISFIT of
the readings' own: a course that meets every reading would else be as likely as one likes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scara_iso.iso9283 import median
from scara_iso.run import FloatArray

_ERFC = np.frompyfunc(math.erfc, 1, 1)
"""scipy's normal distribution function takes as long to import as a diagnosis to compute."""

LEAST_ON_DIAL = 0.15
"""Scatter below which no prior reaches, in divisions: what a finer one rounds to says no more
(real readings)."""

HEAVY_SHARE = 0.2
"""Prior share of scatter with heavy tails (t4) beside Gaussian scatter (table *naming*)."""

KNOWN_FROM = 30
"""A scatter that the user states counts as seen in so many cycles on which nothing acted."""

MISFIT = 0.05
"""Share of an effect's size by which its course may differ from the catalogue's equation: no
machine follows one to the last digit (real readings)."""


def normal_cdf(x: FloatArray) -> FloatArray:
    """Return the standard normal distribution function at finite x of any shape, element-wise."""
    return np.asarray(_ERFC(-math.sqrt(0.5) * np.asarray(x)) / 2, dtype=np.float64)


class DialCourse(NamedTuple):
    """A course beside what is fitted: columns (n, k), prior variances (k,), scale of scatter (n,).

    The variances are over that of the scatter.
    """

    columns: FloatArray
    variances: FloatArray
    scale: FloatArray


def scatter_alone(n: int) -> DialCourse:
    """Return the course that moves nothing."""
    return DialCourse(np.empty((n, 0)), np.empty(0), np.ones(n))


WIDTH_OF_SHAPES = 2
"""Columns of a shape; a random course has more."""
_SIZES = (WIDTH_OF_SHAPES, 8)
"""Columns of a shape, of a smooth random course; a rough one has one in nearly every cycle."""
_NEGLIGIBLE = 0.05 - 1e-9
"""Columns of less prior variance, over the scatter's, are left out; a walk has one of 0.05."""
_NO_DIAL = 1e-4
"""Division, over the standard deviation, of readings that are not rounded."""
_SCATTERS, _NEWTON = 6, 5
_TRIED, _LEVELS = 60, 31
_DIGITS = 12
"""Those of a division by which two readings are one."""
_SETTLED = 1e-7
"""Step, in scatters, from which the readings' likelihood is taken for that at the mode."""
_TINY = 1e-300


def log_likelihoods(
    y: FloatArray,
    half: FloatArray,
    basis: FloatArray,
    courses: Sequence[DialCourse],
    known: float = 0.0,
) -> FloatArray:
    """Return log marginal likelihoods (courses, families) of residuals y (n,).

    They are beside ``basis`` (n, f). ``half`` (n,) is half a division in each cycle, 0 where there
    is no dial; ``known`` the scatter where it was stated (`KNOWN_FROM`), else 0. The families are
    the Gaussian and Student's t.
    """
    unit = float(2 * half.max()) or _NO_DIAL * float(y.std())
    if not unit:  # nothing is left that a course could follow
        return np.zeros((len(courses), len(FAMILIES)))
    half = np.where(half > 0, half, unit / 2) / unit
    found = np.empty((len(courses), len(FAMILIES)))
    kept = [course.variances > _NEGLIGIBLE for course in courses]
    sizes = np.searchsorted(_SIZES, [int(own.sum()) for own in kept])
    for size in np.unique(sizes):
        places = np.flatnonzero(sizes == size).tolist()
        some = [(courses[i], kept[i]) for i in places]
        group = _of_like_width(some, y / unit, half, basis)
        for family, (distribution, weight) in enumerate(FAMILIES):
            s = group.scatters(heavy=family > 0)
            evidence = group.at(s, distribution, weight)
            m = KNOWN_FROM - 1 if known else 0
            evidence -= m * (np.log(s) + (known / unit / s) ** 2 / 2)
            apart = np.log(s[:, 1] / s[:, 0])
            found[places, family] = np.log(apart) + np.logaddexp.reduce(evidence, axis=1)
    return found


def mixed(by_family: FloatArray) -> FloatArray:
    """Return log marginal likelihoods (courses,) over both families (courses, families)."""
    share = np.log([1 - HEAVY_SHARE, HEAVY_SHARE])
    return np.asarray(np.logaddexp.reduce(by_family + share, axis=1))


def _of_like_width(
    courses: Sequence[tuple[DialCourse, npt.NDArray[np.bool_]]],
    y: FloatArray,
    half: FloatArray,
    basis: FloatArray,
) -> _Courses:
    width = max(int(kept.sum()) for _, kept in courses)
    columns = np.zeros((len(courses), len(y), width))
    variances = np.ones((len(courses), width))
    for i, (course, kept) in enumerate(courses):  # columns of zeros add nothing
        k = int(kept.sum())
        columns[i, :, :k], variances[i, :k] = course.columns[:, kept], course.variances[kept]
    shared = np.broadcast_to(basis, (len(courses), *basis.shape))
    design = np.concatenate([shared, columns], axis=2)
    scale = np.stack([course.scale for course, _ in courses])
    return _Courses(y, half, design, basis.shape[1], variances, scale)


def log_density(
    y: FloatArray, level: FloatArray, scatter: FloatArray, division: float
) -> FloatArray:
    """Return that of readings about a level: of the division that each rounds to, over its width.

    Far from the level, where that vanishes, it is the density itself.
    """
    exact = -0.5 * ((y - level) / scatter) ** 2 - np.log(scatter * np.sqrt(2 * np.pi))
    if not division:
        return np.asarray(exact)
    apart = -np.abs(y - level)
    p = normal_cdf((apart + division / 2) / scatter) - normal_cdf((apart - division / 2) / scatter)
    return np.where(p > _TINY, np.log(np.maximum(p, _TINY) / division), exact)


def scatters_on_dial(y: FloatArray, power: float) -> tuple[FloatArray, FloatArray]:
    """Return scatters in divisions and their posterior given residuals y (n,) on the dial."""
    size = max(float(y.std(ddof=1)), 0.3)
    s = np.geomspace(LEAST_ON_DIAL, 3 * size, _TRIED)[:, np.newaxis, np.newaxis]
    level = y.mean() + np.linspace(-1, 1, _LEVELS)[:, np.newaxis] * max(0.6, size)
    shown, times = np.unique(y.round(_DIGITS), return_counts=True)
    log = power * log_density(shown, level, s, 1.0) @ times
    weight = np.exp(log - log.max()).sum(axis=1)
    return s[:, 0, 0], weight / weight.sum()


Distribution = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
"""Of x: tail beyond |x|, density, and the density's slope."""
Weight = Callable[[FloatArray], FloatArray]
"""Of a residual in scatters: how much it counts in the first, safe steps."""


class _Courses(NamedTuple):
    """Courses of like width: design (c, n, p), prior variance of the last k columns (c, k)."""

    y: FloatArray
    half: FloatArray
    design: FloatArray
    fixed: int
    variances: FloatArray
    scale: FloatArray

    def start(self) -> FloatArray:
        """Return coefficients (c, p) for light tails and no dial."""
        at = self.y @ self.design
        at[:, self.fixed :] *= self.variances / (1 + self.variances)
        return np.asarray(at)

    def scatters(self, *, heavy: bool) -> FloatArray:
        """Return scatters to try, (courses, SCATTERS), about that of the Gaussian fit."""
        left = (self.y - (self.design @ self.start()[..., np.newaxis])[..., 0]) / self.scale
        squares = (left**2).sum(axis=1) / (len(self.y) - self.fixed)
        size = median(np.abs(left), axis=1) * 1.3 if heavy else np.sqrt(squares)
        least = max(LEAST_ON_DIAL, MISFIT * float(self.y.std()))
        low = np.maximum(0.45 * size, least)
        high = np.maximum(2.2 * size, 4 * least)
        part = np.linspace(0, 1, _SCATTERS)
        return np.asarray(low[:, np.newaxis] * (high / low)[:, np.newaxis] ** part)

    def at(self, s: FloatArray, distribution: Distribution, weight: Weight) -> FloatArray:
        """Return the log evidence (c, S) for scatters s (c, S)."""
        wide = s[:, :, np.newaxis] * self.scale[:, np.newaxis]
        prior = np.zeros((*s.shape, self.design.shape[2]))
        prior[..., self.fixed :] = 1 / (self.variances[:, np.newaxis] * s[..., np.newaxis] ** 2)
        at = np.repeat(self.start()[:, np.newaxis], s.shape[1], axis=1)
        turned = np.swapaxes(self.design, 1, 2)
        least = np.zeros_like(wide)
        for steps in range(_NEWTON + 1):
            left = self.y - at @ turned
            log_p, slope, curvature = _reading(left, self.half, wide, distribution)
            if steps == _NEWTON:
                break
            least = 0.3 * weight(left / wide) / wide**2
            information = self._information(np.maximum(curvature, least), prior)
            uphill = slope @ self.design - prior * at
            step = np.linalg.solve(information, uphill[..., np.newaxis])[..., 0]
            at += step
            if (np.abs(step) < _SETTLED * s[..., np.newaxis]).all():
                break
        information = self._information(np.maximum(curvature, self._floor(least, wide)), prior)
        evidence = log_p.sum(axis=2) - (prior * at**2).sum(axis=2) / 2
        evidence += np.log(prior[..., self.fixed :]).sum(axis=2) / 2
        return np.asarray(evidence - np.linalg.slogdet(information)[1] / 2)

    def _floor(self, least: FloatArray, wide: FloatArray) -> FloatArray:
        """Return the curvature of a reading that is taken at least, ``least`` the one on the way.

        A random course moves each reading by itself, and within its division d it is as likely
        anywhere: a box of the width and height that a Gaussian of variance d^2 / (2 pi) has too.
        """
        if self.variances.shape[1] <= WIDTH_OF_SHAPES:
            return 0.03 * least
        return least / 0.3 / (1 + (2 * self.half / wide) ** 2 / (2 * np.pi))

    def _information(self, curvature: FloatArray, prior: FloatArray) -> FloatArray:
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


FAMILIES: tuple[tuple[Distribution, Weight], ...] = (
    (_gaussian, np.ones_like),
    (_student, lambda x: np.asarray(1.25 / (1 + x**2 / 4))),
)
