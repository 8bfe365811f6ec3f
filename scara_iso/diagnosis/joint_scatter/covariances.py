"""Covariances of several poses as sums of known patterns, each at a variance of its own.

The covariance S of a pose's readings has the expectation R + sum of theta_k B_k: R is known, each
pattern B_k says how a source shows at that pose, and the variances theta are the same at all poses.
They are fitted by iterated weighted least squares: the weights are those of Gaussian scatter with
the covariances of the fit before, so that the end is its maximum likelihood. Leading dimensions
are tests, which are fitted side by side.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from scara_iso.run import FloatArray

_MOST_STEPS, _SETTLED = 60, 1e-7
_HALVINGS = 20
_NOTHING = 1e-20
"""No dial shows 1e-10 mm."""
_CLOSEST = 0.98
"""Largest correlation of two sources."""
_NONE = 1e-9
"""Share of the scatter that is taken for none, so that a dial without steps has a covariance."""


@dataclass(frozen=True, eq=False, slots=True)
class PoseCovariances:
    """Covariances of P poses, and what they are made of; variances in one unit, mm2 as a rule.

    ``observed`` (..., P, 2, 2) have ``freedom`` (..., P) degrees of freedom each, 0 for a pose that
    is left out; ``patterns`` (P, K, 2, 2) belong to the sources, the last to a covariance of the
    first two; ``known`` is (..., P, 2, 2).
    """

    observed: FloatArray
    freedom: FloatArray
    patterns: FloatArray
    known: FloatArray

    def expected(self, variances: FloatArray) -> FloatArray:
        """Return the covariances (..., P, 2, 2) that ``variances`` (..., K) make."""
        size = np.trace(self.observed, axis1=-2, axis2=-1).mean(axis=-1) + _NOTHING
        floor = _NONE * size[..., np.newaxis, np.newaxis, np.newaxis] * np.eye(2)
        made = np.einsum("...k,pkij->...pij", variances, self.patterns)
        return np.asarray(self.known + floor + made, dtype=np.float64)


def fit_variances(given: PoseCovariances, held: FloatArray | None = None) -> FloatArray:
    """Return the variances (..., K), each 0 or more, at which the patterns fit best.

    Where ``held`` (..., K) is a number, that variance is not fitted. The last pattern's may be
    negative: it is the covariance of the first two sources, which it leaves possible.
    """
    size = np.linalg.norm(given.patterns, axis=(-2, -1)).mean(axis=0)
    each = np.linalg.norm(given.observed, axis=(-2, -1)).mean(axis=-1)[..., np.newaxis] / len(size)
    held = np.full((*each.shape[:-1], len(size)), np.nan) if held is None else held
    free = np.isnan(held)
    fixed = np.where(free, 0.0, held)
    start = np.where(np.arange(len(size)) < len(size) - 1, each / size, 0.0)
    variances = np.where(free, start, fixed)
    for _ in range(_MOST_STEPS):
        matrix, target = _normal_equations(given, variances)
        beside = target - np.einsum("...kl,...l->...k", matrix, fixed)
        before = variances
        variances = _possible(np.where(free, _not_negative(matrix, beside, free), fixed), free)
        if np.all(np.abs(variances - before) * size <= _SETTLED * each):
            break
    return variances


def information(given: PoseCovariances, variances: FloatArray) -> FloatArray:
    """Return Fisher's information (..., K, K) on the variances under Gaussian scatter."""
    return _normal_equations(given, variances)[0]


def deviance(given: PoseCovariances, variances: FloatArray) -> FloatArray:
    """Return -2 log likelihood (...) of Gaussian scatter, but for a constant."""
    expected = given.expected(variances)
    inverse, determinant = _inverse(expected)
    explained = np.einsum("...ij,...ji->...", inverse, given.observed)
    return np.asarray((given.freedom * (np.log(determinant) + explained)).sum(axis=-1))


def misfit(given: PoseCovariances, variances: FloatArray) -> FloatArray:
    """Return how far the covariances are from the fit (...): chi-square where the sources are all.

    Its degrees of freedom are three for each pose less one for each variance above 0.
    """
    expected = given.expected(variances)
    left = _inverse(expected)[0] @ (given.observed - expected)
    squares = np.einsum("...ij,...ji->...", left, left)
    return np.asarray((given.freedom / 2 * squares).sum(axis=-1))


def variance_intervals(
    given: PoseCovariances, variances: FloatArray, held: FloatArray, largest: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the ends (K - 1, ...) of the interval of each source's variance, by its profile.

    Inside it the `deviance`, at its least over the other variances but those ``held``, is at most
    ``largest`` (...) above that of the fit. A lower end is 0 where nothing speaks against it.
    """
    level = deviance(given, variances) + largest
    sources = held.shape[-1] - 1
    found = np.sqrt(np.moveaxis(variances, -1, 0)[:-1])
    inside = np.stack([found, found])
    outside = np.stack([np.zeros_like(found), _beyond(given, found)])
    one = np.eye(sources, held.shape[-1], dtype=bool)
    one = one.reshape(sources, *[1] * (held.ndim - 1), held.shape[-1])

    def within(deviation: FloatArray) -> npt.NDArray[np.bool_]:
        at = np.where(one, deviation[..., np.newaxis] ** 2, held)
        return np.asarray(deviance(given, fit_variances(given, at)) <= level)

    nothing = within(outside)[0]
    for _ in range(_HALVINGS):
        middle = (inside + outside) / 2
        good = within(middle)
        inside, outside = np.where(good, middle, inside), np.where(good, outside, middle)
    return np.where(nothing, 0.0, inside[0] ** 2), inside[1] ** 2


def _beyond(given: PoseCovariances, found: FloatArray) -> FloatArray:
    """Return standard deviations so large that any covariance observed speaks against them."""
    size = np.trace(given.observed + given.known, axis1=-2, axis2=-1).max(axis=-1)
    smallest = np.trace(given.patterns, axis1=-2, axis2=-1).min(axis=0)[:-1]
    unit = smallest.reshape(-1, *[1] * (found.ndim - 1))
    return np.asarray(found + 10 * np.sqrt(size / unit))


def _possible(variances: FloatArray, free: FloatArray) -> FloatArray:
    """Return variances with the covariance, the last, no larger than the first two let it be."""
    most = _CLOSEST * np.sqrt(np.prod(variances[..., :2], axis=-1))
    kept = np.where(free[..., -1], np.clip(variances[..., -1], -most, most), variances[..., -1])
    return np.concatenate([variances[..., :-1], kept[..., np.newaxis]], axis=-1)


def _normal_equations(
    given: PoseCovariances, variances: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return matrix (..., K, K) and right side (..., K) of the weighted least squares."""
    weight = _inverse(given.expected(variances))[0]
    weighted = weight[..., np.newaxis, :, :] @ given.patterns
    half = given.freedom / 2
    flat = weighted.reshape(*weighted.shape[:-2], 4)
    turned = np.swapaxes(weighted, -1, -2).reshape(*weighted.shape[:-2], 4)
    observed = (weight @ (given.observed - given.known)).reshape(*weight.shape[:-2], 4)
    matrix = np.einsum("...p,...pka,...pla->...kl", half, flat, turned)
    return matrix, np.einsum("...p,...pka,...pa->...k", half, turned, observed)


def _not_negative(matrix: FloatArray, target: FloatArray, free: FloatArray) -> FloatArray:
    """Return x (..., K) at which x matrix x / 2 - target x is least: of all sets the best.

    All but the last are 0 or more, and 0 where not ``free`` (..., K).
    """
    sources = target.shape[-1]
    scale = 1 / np.sqrt(np.maximum(np.einsum("...kk->...k", matrix), np.finfo(float).tiny))
    unit, right = matrix * scale[..., np.newaxis] * scale[..., np.newaxis, :], target * scale
    sets = np.array(list(product((False, True), repeat=sources)))
    taken = sets.reshape(-1, *[1] * (target.ndim - 1), sources) & free
    both = taken[..., :, np.newaxis] & taken[..., np.newaxis, :]
    ridge = np.where(taken, _NONE, 1.0)[..., np.newaxis] * np.eye(sources)
    solved = np.linalg.solve(
        np.where(both, unit, 0.0) + ridge, np.where(taken, right, 0.0)[..., np.newaxis]
    )
    x = solved[..., 0]
    value = np.einsum("...k,...kl,...l->...", x, unit, x) / 2 - (right * x).sum(axis=-1)
    value = np.where((x[..., :-1] >= 0).all(axis=-1), value, np.inf)
    best = value.argmin(axis=0)[np.newaxis, ..., np.newaxis]
    return np.asarray(np.take_along_axis(x, best, axis=0)[0] * scale)


def _inverse(matrices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return inverses (..., 2, 2) of symmetric matrices, and their determinants (...)."""
    a, b, d = matrices[..., 0, 0], matrices[..., 0, 1], matrices[..., 1, 1]
    determinant = a * d - b * b
    turned = np.stack([np.stack([d, -b], axis=-1), np.stack([-b, a], axis=-1)], axis=-2)
    return turned / determinant[..., np.newaxis, np.newaxis], determinant
