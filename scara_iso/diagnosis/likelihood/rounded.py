"""Evidence that knows the dial: likelihoods of rounded readings, with light and heavy tails.

A reading y on a dial of division d is right for every value within d / 2 of it, so its likelihood
about a mean m is F((y + d/2 - m) / s) - F((y - d/2 - m) / s), F the distribution of the scatter:
Gaussian, or Student's t with 4 degrees of freedom, under which one odd reading is nothing much. The
coefficients of a course have the Gaussian prior of `hypothesis_set`, the pose a flat one; both are
integrated out by Laplace's method about the mode that Newton's steps reach. The scatter s is
integrated over a grid under the prior 1 / s, which ends at LEAST_ON_DIAL divisions and at MISFIT of
the readings' own: a course that meets every reading would else be as likely as one likes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, extended
from scara_iso.diagnosis.likelihood.laplace import FAMILIES, WIDTH_OF_SHAPES, CoursesOfLikeWidth
from scara_iso.diagnosis.tuning import (
    AMPLITUDES,
    GAIN,
    HEAVY_SHARE,
    KNOWN_FROM,
    LEAST_ON_DIAL,
)
from scara_iso.effects import Chain, Shape
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray

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
