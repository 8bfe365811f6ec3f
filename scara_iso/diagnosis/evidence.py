"""Evidence: log Bayes factors of every hypothesis against scatter alone.

For covariance C = I + U diag(s) U' beside scatter of unknown width, and a flat prior on what is
fitted: BF = |C|^(-1/2) (1 - sum w (u'y)^2 / y'y)^(-nu/2), w = s / (1 + s), nu = n - f. A scatter
that was known beforehand adds its own cycles to nu and their squares to y'y (`KNOWN_FROM`). With
s = g for every column it is the g-prior's Bayes factor (Zellner 1986; Liang et al. 2008, eq. 6).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from scara_iso.diagnosis.hypothesis_set import HypothesisSet, extended
from scara_iso.diagnosis.tuning import AMPLITUDES, GAIN, KNOWN_FROM
from scara_iso.frozen import dataclass
from scara_iso.run import FloatArray, IntArray

LARGEST_LOG = 600.0
"""Logarithms of Bayes factors are cut here, so that sums and products stay finite."""
_SMALLEST_SHARE = 1e-12
_TINY = 1e-300

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


@dataclass(frozen=True, eq=False, slots=True)
class Views:
    """The axes' residuals seen in several ways: ``columns`` (n, v), each of unit variance.

    The first ``axes`` columns are the axes themselves. With two axes or more follow their
    principal directions, the axes freed of their correlation, and the directions that physics
    names (one column for each of ``named``). ``known`` (v,) are the squares of cycles on which
    nothing acted, 0 for a column whose scatter is not known. The axes of several ``poses`` are seen
    as they are and along the named directions only: they are too many for others.
    """

    columns: FloatArray
    axes: int
    named: tuple[str, ...] = ()
    known: FloatArray | None = None
    poses: ManyPoses | None = None


def views_of(
    values: FloatArray,
    basis: FloatArray,
    directions: Mapping[str, FloatArray] | None = None,
    sigma: FloatArray | None = None,
    poses: ManyPoses | None = None,
) -> Views:
    """Return the views of residuals (n, axes) with ``basis`` (n, f) projected out.

    ``directions`` maps a name to how far each axis moves, shape (axes,); ``sigma`` (axes,) is the
    known scatter, 0 where it is not; ``poses`` as in `Views`. Whitening uses the covariance over
    the cycles, which no permutation of them changes.
    """
    free = values - basis @ (basis.T @ values)
    scaled = free / np.maximum(np.linalg.norm(free, axis=0), _TINY)
    axes = values.shape[1]
    if axes == 1:
        return Views(scaled, 1, known=_known_squares(free, sigma, 1))
    if poses is None:
        correlation = scaled.T @ scaled
        variance, rotation = np.linalg.eigh(correlation)
        principal = scaled @ (rotation / np.sqrt(np.maximum(variance, 1e-9)))
        columns = [scaled, principal, principal @ rotation.T]
    else:
        correlation = shrunk(scaled.T @ scaled, poses.of, len(values) - basis.shape[1])
        columns = [scaled]
    for movement in (directions or {}).values():
        relative = movement / np.maximum(np.linalg.norm(free, axis=0), _TINY)
        weight = np.linalg.lstsq(correlation, relative, rcond=1e-9)[0]
        columns.append((scaled @ weight)[:, np.newaxis])
    seen = np.concatenate(columns, axis=1)
    known = _known_squares(free, sigma, seen.shape[1])
    return Views(seen, axes, tuple(directions or {}), known, poses)


def shrunk(covariance: FloatArray, poses: IntArray, nu: int) -> FloatArray:
    """Return a covariance of axes (axes, axes) from ``nu`` cycles, shrunk between ``poses``.

    There are more pairs of axes than cycles could tell of: what the cycles of different poses share
    counts for as much as it exceeds what chance gives it (Schaefer and Strimmer 2005, one factor
    for all pairs).
    """
    apart = poses[:, np.newaxis] != poses
    if not apart.any():
        return covariance
    size = np.maximum(np.sqrt(np.diag(covariance)), _TINY)
    squares = float(((covariance / np.outer(size, size))[apart] ** 2).mean())
    kept = max(0.0, 1 - 1 / (nu * squares)) if squares else 0.0
    return np.where(apart, kept * covariance, covariance)


def _known_squares(free: FloatArray, sigma: FloatArray | None, views: int) -> FloatArray | None:
    if sigma is None or not sigma.any():
        return None
    known = np.zeros(views)
    known[: len(sigma)] = (KNOWN_FROM - 1) * sigma**2
    known[: len(sigma)] /= np.maximum((free**2).sum(axis=0), _TINY)
    return known


def log_bayes(
    hypotheses: HypothesisSet, columns: FloatArray, known: FloatArray | None = None
) -> FloatArray:
    """Return log Bayes factors (members, m) for residuals (n, m) orthogonal to the set's basis.

    ``known`` (m,) as in `Views`.
    """
    return np.asarray(_log_bayes([hypotheses], columns, known)[0])


def log_bayes_amplified(
    hypotheses: HypothesisSet, columns: FloatArray, known: FloatArray | None = None
) -> FloatArray:
    """Return `log_bayes` (amplitudes, members, m) of a set amplified by each of AMPLITUDES."""
    amplified = [hypotheses.amplified(factor) for factor, _ in AMPLITUDES]
    return _log_bayes(amplified, columns, known)


def _log_bayes(
    amplified: Sequence[HypothesisSet], columns: FloatArray, known: FloatArray | None
) -> FloatArray:
    """Return `log_bayes` of sets that differ in their variances only, (sets, members, m)."""
    first = amplified[0]
    beside = np.zeros(columns.shape[1]) if known is None else known
    nu = len(columns) - first.basis.shape[1] + np.where(beside > 0, KNOWN_FROM - 1, 0)
    power = np.maximum((columns**2).sum(axis=0), _TINY) + beside
    squared = first.vectors.T @ columns
    squared *= squared
    squared /= -power
    found = np.empty((len(amplified), len(first.members), columns.shape[1]))
    courses = found[:, : len(first.first)]
    for hypotheses, shaped in zip(amplified, courses, strict=True):
        hypotheses.explained(squared, out=shaped)
    courses += 1
    np.log(np.maximum(courses, _SMALLEST_SHARE, out=courses), out=courses)
    courses *= -nu / 2
    courses -= np.stack([one.penalty for one in amplified])[:, :, np.newaxis] / 2
    found[:, len(first.first) :] = _log_bayes_of_spreads(first.scales, columns, nu, beside)
    return found


def log_bayes_of_course(course: FloatArray, basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Return log Bayes factors (m,) of one course (n, k) under the g-prior, beside ``basis``."""
    beside = extended(basis, course)[:, basis.shape[1] :]
    free = columns - basis @ (basis.T @ columns)
    explained = ((beside.T @ free) ** 2).sum(axis=0) / np.maximum((free**2).sum(axis=0), _TINY)
    nu, k = len(columns) - basis.shape[1], beside.shape[1]
    left = np.maximum(1 - explained * GAIN / (1 + GAIN), _SMALLEST_SHARE)
    return np.asarray(-nu / 2 * np.log(left) - k / 2 * np.log1p(GAIN))


def _log_bayes_of_spreads(
    scales: FloatArray, columns: FloatArray, nu: IntArray, known: FloatArray
) -> FloatArray:
    """Return log Bayes factors (m, columns) of scatter that is ``scales`` r (m, n) times as wide.

    The mean is integrated out under either width: S = sum y^2 / r^2 - (sum y / r^2)^2 / sum 1/r^2.
    """
    n, weight = len(columns), 1 / scales**2
    squared = columns**2
    total = weight.sum(axis=1, keepdims=True)
    S = weight @ squared - (weight @ columns) ** 2 / total + known
    alone = np.maximum(squared.sum(axis=0) - columns.sum(axis=0) ** 2 / n + known, _TINY)
    share = np.maximum(S / alone, _SMALLEST_SHARE)
    determinant = np.log(scales).sum(axis=1, keepdims=True)
    return np.asarray(-determinant - 0.5 * np.log(total / n) - nu / 2 * np.log(share))


def evidence_of_runs(hypotheses: HypothesisSet, runs: Sequence[FloatArray]) -> FloatArray:
    """Return Bayes factors over all axes, shape (members, runs), of each of ``runs`` (n, axes)."""
    seen = [views_of(values, hypotheses.basis).columns for values in runs]
    columns = np.stack(seen, axis=2)
    n, v, count = columns.shape
    log_bf = log_bayes(hypotheses, columns.reshape(n, -1)).reshape(-1, v, count)
    return joint_evidence(log_bf, Views(columns[:, :, 0], runs[0].shape[1]))


def joint_evidence(log_bf: FloatArray, views: Views) -> FloatArray:
    """Return Bayes factors over all axes, shape (members, m), from single ones (members, v, m).

    A mixture, in equal parts: each axis takes part or not (probability 1/2); one principal
    direction does; one axis freed of the others does. Of several poses: each axis takes part or
    not; the axes of one pose do or not. Named directions count as much as these.
    """
    q = views.axes
    bf = np.exp(np.minimum(log_bf, LARGEST_LOG / q))
    if q == 1:
        return np.asarray(bf[:, 0])
    if views.poses is not None:
        return _of_poses(bf, q, views.poses)
    parts = [
        np.prod((1 + bf[:, :q]) / 2, axis=1),
        bf[:, q : 2 * q].mean(axis=1),
        bf[:, 2 * q : 3 * q].mean(axis=1),
    ]
    if views.named:  # what physics expects weighs as much as all that it does not
        parts += [bf[:, 3 * q :].mean(axis=1)] * len(parts)
    return np.asarray(sum(parts) / len(parts))


def _of_poses(bf: FloatArray, q: int, poses: ManyPoses) -> FloatArray:
    takes_part = (1 + bf[:, :q]) / 2
    every = np.prod(takes_part, axis=1)
    alone = [np.prod(takes_part[:, poses.of == p], axis=1) for p in np.unique(poses.of)]
    named = np.tensordot(bf[:, q:], poses.shares, axes=(1, 0))
    return np.asarray((every + np.mean(alone, axis=0) + 2 * named) / 4)
