"""Evidence: log Bayes factors of every hypothesis against scatter alone.

For covariance C = I + U diag(s) U' beside scatter of unknown width, and a flat prior on what is
fitted: BF = |C|^(-1/2) (1 - sum w (u'y)^2 / y'y)^(-nu/2), w = s / (1 + s), nu = n - f. A scatter
that was known beforehand adds its own cycles to nu and their squares to y'y (`KNOWN_FROM`). With
s = g for every column it is the g-prior's Bayes factor (Zellner 1986; Liang et al. 2008, eq. 6).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, extended
from scara_iso.diagnosis.tuning import AMPLITUDES, GAIN, KNOWN_FROM
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

    def in_single_precision(self) -> Views:
        """Return the views in numbers of half the length."""
        return replace(self, columns=self.columns.astype(np.float32))


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


def bayes_factors(hypotheses: HypothesisSet, columns: FloatArray) -> FloatArray:
    """Return the Bayes factors of `log_bayes` themselves, (members, m); too large ones are inf.

    A power is some products, in less time than a logarithm.
    """
    (left,), (penalty,), nu = _left([hypotheses], columns, None)
    base = 1 / np.maximum(left, _SMALLEST_SHARE, out=left)
    base *= np.exp(-penalty / nu)
    found = np.sqrt(base) if nu % 2 else np.ones_like(base)
    with np.errstate(over="ignore"):
        for power in range(1, int(nu).bit_length()):
            if nu >> power & 1:
                found *= base
            base *= base
    return np.asarray(found)


def _log_bayes(
    amplified: Sequence[HypothesisSet], columns: FloatArray, known: FloatArray | None
) -> FloatArray:
    """Return `log_bayes` of sets that differ in their variances only, (sets, members, m)."""
    found, penalty, nu = _left(amplified, columns, known)
    np.log(np.maximum(found, _SMALLEST_SHARE, out=found), out=found)
    found *= -nu / 2
    found -= penalty / 2
    return found


def _left(
    amplified: Sequence[HypothesisSet], columns: FloatArray, known: FloatArray | None
) -> tuple[FloatArray, FloatArray, npt.NDArray[np.int64]]:
    """Return the share of the squares that members leave (sets, members, m).

    With their log determinants (sets, members, 1), and the degrees of freedom.
    """
    first, kind = amplified[0], columns.dtype
    beside = np.zeros(columns.shape[1], kind) if known is None else known
    nu = np.asarray(len(columns) - first.basis.shape[1])
    if known is not None:
        nu = nu + np.where(known > 0, KNOWN_FROM - 1, 0)
    power = np.maximum((columns**2).sum(axis=0), np.finfo(kind).tiny) + beside
    unit = columns / np.sqrt(power)
    squared = first.vectors.T @ unit
    squared *= squared
    found = np.empty((len(amplified), len(first.members), columns.shape[1]), kind)
    courses, spreads = np.split(found, [len(first.first)], axis=1)
    for hypotheses, own in zip(amplified, courses, strict=True):
        hypotheses.explained(squared, out=own)
    np.subtract(1, courses, out=courses)
    spreads[:], penalty = _left_by_spreads(first.scales, unit, beside / power)
    penalties = np.stack([np.append(one.penalty, penalty) for one in amplified])
    return found, penalties[..., np.newaxis], nu


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
    mean = weight @ unit
    mean *= mean
    mean /= total
    left = weight @ unit**2
    left -= mean
    left += known
    return left, 2 * np.log(scales).sum(axis=1) + np.log(total[:, 0] / scales.shape[1])


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
    return _joint(_bayes_factors(log_bf, views), views)


def _joint(bf: FloatArray, views: Views) -> FloatArray:
    q = views.axes
    if q == 1:
        return np.asarray(bf[:, 0])
    together = _taking_part(bf[:, :q], views)
    together += np.einsum("v,ivm->im", _shares(views), bf[:, q:])
    return together


def largest_evidence(bf: FloatArray, views: Views) -> FloatArray:
    """Return the largest (m,) of the `joint_evidence` of members, of single ones (members, v, m).

    0 where there are none.
    """
    capped = np.minimum(bf, math.exp(LARGEST_LOG / views.axes))
    return np.asarray(_joint(capped, views).max(axis=0, initial=0.0))


def mean_evidence(weights: FloatArray, bf: FloatArray, views: Views) -> FloatArray:
    """Return the mean (m,) of the `joint_evidence` of members with ``weights`` (members,).

    Of single Bayes factors (members, v, m), which are used up.
    """
    members, v, m = bf.shape
    q, bf = views.axes, np.minimum(bf, math.exp(LARGEST_LOG / views.axes), out=bf)
    if q == 1:
        return np.asarray(weights @ bf[:, 0])
    single = weights @ bf.reshape(members, -1)[:, q * m :]
    together = weights @ _taking_part(bf[:, :q], views)
    return np.asarray(together + _shares(views) @ single.reshape(v - q, m))


def _bayes_factors(log_bf: FloatArray, views: Views) -> FloatArray:
    return np.exp(np.minimum(log_bf, LARGEST_LOG / views.axes))


def _shares(views: Views) -> FloatArray:
    """Return the share of each column beside the axes; what physics names weighs half."""
    q, named = views.axes, len(views.named)
    if views.poses is not None:
        return views.poses.shares / 2
    each, half = np.full(2 * q, 1 / (3 * q)), np.full(named, 1 / (2 * max(named, 1)))
    return np.concatenate([each / 2 if named else each, half])


def _taking_part(bf: FloatArray, views: Views) -> FloatArray:
    """Return the mixture over which of the axes (members, q, m) take part, times its share."""
    takes_part = bf / 2
    takes_part += 0.5
    every = np.prod(takes_part, axis=1)
    if views.poses is None:
        return np.asarray(every / (6 if views.named else 3))
    of = views.poses.of
    alone = [np.prod(takes_part[:, of == p], axis=1) for p in sorted(set(of.tolist()))]
    return np.asarray((every + np.mean(alone, axis=0)) / 4)
