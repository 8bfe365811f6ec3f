"""Evidence: log Bayes factors of hypotheses against scatter alone, over all axes.

For covariance C = I + U diag(s) U' beside scatter of unknown width, and a flat prior on what is
fitted: BF = |C|^(-1/2) (1 - sum w (u'y)^2 / y'y)^(-nu/2), w = s / (1 + s), nu = n - f. A scatter
that was known beforehand adds its own cycles to nu and their squares to y'y (`KNOWN_FROM`). With
s = g for every column it is the g-prior's Bayes factor (Zellner 1986; Liang et al. 2008, eq. 6).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.hypotheses import HypothesisSet, extended
from scara_iso.diagnosis.tuning import GAIN, KNOWN_FROM
from scara_iso.run import FloatArray, IntArray

LARGEST_LOG = 600.0
"""Logarithms of Bayes factors are cut here, so that sums and products stay finite."""
_SMALLEST_SHARE = 1e-12
_TINY = 1e-150
_DUST = 1e-14
"""What the arithmetic alone leaves of readings, over the size of the largest."""

np.empty(2**21)
"""Once so much is freed, glibc keeps as much for the next arrays, which it otherwise gives back to
the system and fetches anew for every block of permutations: half of the time."""


@dataclass(frozen=True, eq=False, slots=True)
class ManyPoses:
    """Which pose each axis belongs to, by number (axes,), and the share of each named direction.

    Together the ``shares`` are 1.
    """

    of: IntArray
    shares: FloatArray

    @property
    def of_views(self) -> IntArray:
        """The poses of the axes, and -1 for each direction."""
        return np.append(self.of, np.full(len(self.shares) if len(self.of) > 1 else 0, -1))


@dataclass(frozen=True, eq=False, slots=True)
class Views:
    """The axes' residuals and combinations of them: ``columns`` (n, v), each of unit length.

    The first ``axes`` columns are the axes themselves; then come the directions that physics names,
    freed of what the axes have in common. ``known`` (v,) are the squares of cycles on which nothing
    acted, 0 for a column whose scatter is not known.
    """

    columns: FloatArray
    axes: int
    known: FloatArray
    poses: ManyPoses | None = None


def views_of(
    values: FloatArray,
    basis: FloatArray,
    directions: Mapping[str, FloatArray] | None = None,
    sigma: FloatArray | float = 0.0,
    poses: ManyPoses | None = None,
) -> Views:
    """Return the views of residuals (n, axes) with ``basis`` (n, f) projected out.

    ``directions`` maps a name to how far each axis moves, shape (axes,); ``sigma`` (axes,) is the
    known scatter, 0 where it is not. The covariance that directions are freed of is that over the
    cycles, which no permutation of them changes.
    """
    free = values - basis @ (basis.T @ values)
    length = np.maximum(np.linalg.norm(free, axis=0), _TINY)
    dust = max(_TINY, _DUST * float(np.linalg.norm(values, axis=0).max()))
    size = np.where(length > dust, length, np.inf)  # an axis at rest says nothing
    scaled = free / size
    axes = values.shape[1]
    known = (KNOWN_FROM - 1) * (sigma / length) ** 2
    if axes == 1 or not directions:
        return Views(scaled, axes, known, poses)
    correlation = scaled.T @ scaled
    if poses is not None:
        correlation = shrunk(correlation, poses.of, len(values) - basis.shape[1])
    relative = np.stack([movement / size for movement in directions.values()], axis=1)
    along = scaled @ np.linalg.lstsq(correlation, relative, rcond=1e-9)[0]
    columns = np.concatenate([scaled, along], axis=1)
    return Views(columns, axes, np.append(known, np.zeros(len(directions))), poses)


def shrunk(covariance: FloatArray, poses: IntArray, nu: int) -> FloatArray:
    """Return a covariance of axes (axes, axes) from ``nu`` cycles, shrunk between ``poses``.

    There are more pairs of axes than cycles could tell of: what the cycles of different poses share
    counts for as much as it exceeds what chance gives it (Schaefer and Strimmer 2005, one factor
    for all pairs). An axis at rest shares nothing.
    """
    apart = poses[:, np.newaxis] != poses
    if not apart.any():
        return covariance
    size = np.sqrt(np.diag(covariance))
    sizes = np.outer(size, size)
    correlation = np.divide(covariance, sizes, out=np.zeros_like(sizes), where=sizes > 0)
    squares = float((correlation[apart] ** 2).mean())
    kept = max(0.0, 1 - 1 / (nu * squares)) if squares else 0.0
    return np.where(apart, kept * covariance, covariance)


def log_bayes(
    hypotheses: HypothesisSet,
    columns: FloatArray,
    known: FloatArray | float = 0.0,
    factor: float = 1.0,
    misfit: float = 0.0,
) -> FloatArray:
    """Return log Bayes factors (members, m) for residuals (n, m) orthogonal to the set's basis.

    ``known`` (m,) as in `Views`; every variance beside the scatter is ``factor`` times as large. No
    course follows the readings nearer than to ``misfit`` of their own size.
    """
    kind = columns.dtype
    nu = len(columns) - hypotheses.basis.shape[1] + (KNOWN_FROM - 1) * np.greater(known, 0)
    power = np.maximum((columns**2).sum(axis=0), np.finfo(kind).tiny) + known
    unit = columns / np.sqrt(power)
    left, penalty = [np.empty((0, columns.shape[1]))], [np.empty(0)]
    for group in hypotheses.groups:
        squared = group.vectors.astype(kind).T @ unit
        squared *= squared
        left.append(1 - group.explained(squared, factor))
        penalty.append(np.log1p(factor * group.variances).sum(axis=1))
    if hypotheses.spreads:
        by_spread, log_size = _left_by_spreads(hypotheses.scales, unit, known / power)
        left.append(by_spread)
        penalty.append(log_size)
    found = np.concatenate(left, dtype=kind)
    found += misfit**2 * (1 - found)
    np.log(np.maximum(found, _SMALLEST_SHARE, out=found), out=found)
    found *= (-nu / 2).astype(kind)
    found -= (np.concatenate(penalty) / 2).astype(kind)[:, np.newaxis]
    return np.asarray(found)


def log_bayes_of_course(course: FloatArray, basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Return log Bayes factors (m,) of one course (n, k) under the g-prior, beside ``basis``."""
    beside = extended(basis, course)[:, basis.shape[1] :]
    free = columns - basis @ (basis.T @ columns)
    explained = ((beside.T @ free) ** 2).sum(axis=0) / np.maximum((free**2).sum(axis=0), _TINY)
    nu, k = len(columns) - basis.shape[1], beside.shape[1]
    left = np.maximum(1 - explained * GAIN / (1 + GAIN), _SMALLEST_SHARE)
    return np.asarray(-nu / 2 * np.log(left) - k / 2 * np.log1p(GAIN))


def _left_by_spreads(
    scales: FloatArray, unit: FloatArray, known: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what is left of the squares where scatter is ``scales`` r (m, n) times as wide.

    Shares of columns ``unit`` (n, columns), whose squares and the ``known`` ones add up to 1, and
    the log determinants (m,). The mean is integrated out under either width:
    S = sum y^2 / r^2 - (sum y / r^2)^2 / sum 1/r^2.
    """
    weight = 1 / scales**2
    total = weight.sum(axis=1, keepdims=True)
    left = weight @ unit**2 - (weight @ unit) ** 2 / total + known
    return left, 2 * np.log(scales).sum(axis=1) + np.log(total[:, 0] / scales.shape[1])


def joint_evidence(log_bf: FloatArray, views: Views) -> FloatArray:
    """Return Bayes factors over all axes, shape (members, ...), from single ones (members, v, ...).

    Each axis takes part or not, with even odds; of several poses those of one alone do as likely.
    Named directions count as much as that.
    """
    q = views.axes
    bf = np.exp(np.minimum(log_bf.astype(np.float64), LARGEST_LOG / q))
    if q == 1:
        return np.asarray(bf[:, 0])
    takes_part = bf[:, :q] / 2 + 0.5
    found = np.prod(takes_part, axis=1)
    if views.poses is not None:
        of = views.poses.of
        alone = [np.prod(takes_part[:, of == p], axis=1) for p in np.unique(of).tolist()]
        found = (found + np.mean(alone, axis=0)) / 2
    count = bf.shape[1] - q
    if not count:
        return np.asarray(found)
    shares = np.full(count, 1 / count) if views.poses is None else views.poses.shares
    return np.asarray((found + np.einsum("v,iv...->i...", shares, bf[:, q:])) / 2)
