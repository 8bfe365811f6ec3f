"""Evidence: log Bayes factors of hypotheses against scatter alone, over all axes.

A shape under a g-prior and a random course are one thing here: a covariance C = I + U diag(s) U' of
the readings beside scatter of unknown width, U orthonormal and free of what is fitted (at least the
pose), which has a flat prior: BF = |C|^(-1/2) (1 - sum w (u'y)^2 / y'y)^(-nu/2), w = s / (1 + s),
nu = n - f. A scatter that was known beforehand adds its own cycles to nu and their squares to y'y
(`KNOWN_FROM`). With s = g for every column it is the g-prior's Bayes factor (Zellner 1986; Liang et
al. 2008, eq. 6).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import compress
from typing import NamedTuple

import numpy as np

from scara_iso.diagnosis.engine.hypotheses import GAIN, Hypothesis
from scara_iso.diagnosis.engine.rounded import KNOWN_FROM, DialCourse, scatter_alone
from scara_iso.effects import Form, Process, Shape, Spread
from scara_iso.run import FloatArray, IntArray

LARGEST_LOG = 600.0
"""Logarithms of Bayes factors are cut here, so that sums and products stay finite."""
_SMALLEST_SHARE = 1e-12
_SHORTEST, _LEAST_EIGENVALUE = 1e-9, 1e-4
_TINY = 1e-150
_DUST = 1e-14
"""What the arithmetic alone leaves of readings, over the size of the largest."""

np.empty(2**21)
"""Once so much is freed, glibc keeps as much for the next arrays, which it otherwise gives back to
the system and fetches anew for every block of permutations: half of the time."""
AMPLITUDES, SHARES = (1.0, 13.0, 200.0), np.array([0.8, 0.15, 0.05])
"""Factors on the variances beside the scatter, and their prior: most effects are near it, some
dwarf it. One fixed variance alone could not tell such courses apart (Liang et al. 2008, 2.2)."""


class Group(NamedTuple):
    """Members of one kind: orthonormal ``vectors`` (n, c), and their ``variances`` (m, k).

    Random courses that differ in their variance alone share all vectors (c = k); shapes have theirs
    side by side (c = m k).
    """

    members: tuple[Hypothesis, ...]
    vectors: FloatArray
    variances: FloatArray
    shared: bool
    of: IntArray | None = None
    """Of shapes whose views (v,) follow one column each: which one."""

    def explained(self, squared: FloatArray, factor: float) -> FloatArray:
        """Return the shares (m, v) of squares (c, v) along the vectors that members explain.

        Every variance is ``factor`` times as large.
        """
        if self.of is not None:
            m, views = len(self.members), len(self.of)
            each = squared.reshape(m, -1, views, squared.shape[1] // views)
            squared = each[:, self.of, np.arange(views)].reshape(m, -1)
        s = (factor * self.variances).astype(squared.dtype)
        shrink = s / (1 + s)
        if self.shared:
            with np.errstate(invalid="ignore"):  # BLAS may say so of finite ones: numpy #24067
                return np.asarray(shrink @ squared)
        return np.asarray(np.einsum("mk,mkv->mv", shrink, squared.reshape(*s.shape, -1)))


@dataclass(frozen=True, eq=False)
class HypothesisSet:
    """Hypotheses over n cycles beside an orthonormal ``basis`` (n, f) of what is fitted.

    ``groups`` hold the courses; changes of scatter come last, with ``scales`` (spreads, n).
    """

    basis: FloatArray
    groups: tuple[Group, ...]
    spreads: tuple[Hypothesis, ...]
    scales: FloatArray

    @cached_property
    def members(self) -> tuple[Hypothesis, ...]:
        """All, in the order of the groups."""
        return (*(m for group in self.groups for m in group.members), *self.spreads)

    @cached_property
    def weights(self) -> FloatArray:
        """Prior weight of each member, as given."""
        return np.array([member.weight for member in self.members])

    @cached_property
    def test_weights(self) -> FloatArray:
        """Weight of each member in the test, together 1."""
        tested = self.weights * [member.test_weight for member in self.members]
        return np.asarray(tested / tested.sum())

    def at(self, axes: IntArray) -> HypothesisSet:
        """Return them as some of the axes have them."""
        groups = (one if one.of is None else one._replace(of=one.of[axes]) for one in self.groups)
        return replace(self, groups=tuple(groups))

    def course(self, i: int, factor: float, axis: int = 0) -> DialCourse:
        """Return the course of a member on an axis, of ``factor`` times its variance."""
        for group in self.groups:
            if i < len(group.members):
                k = group.vectors.shape[1] // len(group.members)
                vectors = group.vectors if group.shared else group.vectors[:, i * k : (i + 1) * k]
                if group.of is not None:
                    vectors = vectors[:, [group.of[axis]]]
                return DialCourse(vectors, factor * group.variances[i], np.ones(len(vectors)))
            i -= len(group.members)
        return scatter_alone(len(self.basis))._replace(scale=self.scales[i])


def build(members: Sequence[Hypothesis], rows: IntArray, basis: FloatArray) -> HypothesisSet:
    """Return the set of ``members`` on ``rows`` of the run, free of the orthonormal ``basis``.

    ``basis`` has shape (rows, f). Members that say nothing beside it are left out, and so are
    chains, which are sought in the readings themselves.
    """
    by_width: dict[tuple[int, bool], list[tuple[Hypothesis, FloatArray]]] = {}
    processes: dict[int, list[tuple[Hypothesis, Process]]] = {}
    spreads, scales = [], [np.empty((0, len(rows)))]
    for m in members:
        match m.form:
            case Shape(columns, of=of):
                kind = columns.shape[1], of is not None
                by_width.setdefault(kind, []).append((m, columns[rows]))
            case Process() as form:
                processes.setdefault(id(form.unit), []).append((m, form))
            case Spread(scale):
                spreads.append(m)
                scales.append(scale[np.newaxis, rows])
    groups = [
        shape_group([m for m, _ in own], np.stack([c for _, c in own], axis=1), basis)
        for _, own in sorted(by_width.items())
    ]
    groups += _process_groups([*processes.values()], rows, basis)
    kept = tuple(group for group in groups if group.members)
    return HypothesisSet(basis, kept, tuple(spreads), np.concatenate(scales))


def shape_group(members: Sequence[Hypothesis], columns: FloatArray, basis: FloatArray) -> Group:
    """Return the group of shapes with ``columns`` (n, members, k) beside ``basis``."""
    of = members[0].form.of
    vectors, usable = _orthonormal(columns, basis, apart=of is not None)
    kept = tuple(compress(members, usable))
    gain = np.array([m.gain for m in kept], dtype=np.float64)
    variances = np.repeat(gain[:, np.newaxis], columns.shape[2] if of is None else 1, axis=1)
    return Group(kept, vectors.reshape(len(basis), -1), variances, shared=False, of=of)


def _orthonormal(
    columns: FloatArray, basis: FloatArray, *, apart: bool = False
) -> tuple[FloatArray, list[bool]]:
    """Return Gram-Schmidt bases of columns (n, s, k) beside ``basis``, and which were usable.

    Columns ``apart`` are freed of the basis alone.
    """
    scale = np.linalg.norm(columns, axis=0)
    flat = columns.reshape(len(columns), -1)
    flat = flat - basis @ (basis.T @ flat)
    flat -= basis @ (basis.T @ flat)
    free = flat.reshape(columns.shape)
    usable = np.ones(columns.shape[1], dtype=bool)
    for i in range(columns.shape[2]):
        for j in range(0 if apart else i):
            free[:, :, i] -= (free[:, :, j] * free[:, :, i]).sum(axis=0) * free[:, :, j]
        length = np.linalg.norm(free[:, :, i], axis=0)
        usable &= length > 1e-6 * np.maximum(scale[:, i], _SHORTEST)
        free[:, :, i] /= np.maximum(length, _SHORTEST)
    return free[:, usable], [bool(u) for u in usable]


def _process_groups(
    by_unit: Sequence[Sequence[tuple[Hypothesis, Process]]], rows: IntArray, basis: FloatArray
) -> list[Group]:
    """Return a group for the processes of each unit, with the eigenvectors that say something."""
    if not by_unit:
        return []
    firsts = tuple(own[0][1] for own in by_unit)
    values, vectors = _eigen(firsts, rows.tobytes(), basis.tobytes())
    groups = []
    for own, value, vector in zip(by_unit, values, vectors, strict=True):
        s = np.outer([form.variance for _, form in own], value)
        s[s <= _LEAST_EIGENVALUE] = 0.0
        kept, said = np.asarray(s.any(axis=0)), np.asarray(s.any(axis=1))
        members = tuple(compress((m for m, _ in own), said))
        groups.append(Group(members, vector[:, kept], s[said][:, kept], True))
    return groups


@lru_cache(maxsize=4)
def _eigen(
    processes: tuple[Process, ...], of_rows: bytes, of_basis: bytes
) -> tuple[FloatArray, FloatArray]:
    """Return eigenvalues (units, n) and vectors (units, n, n) of units on rows, free of a basis.

    Tables of the same cycles share them.
    """
    rows = np.frombuffer(of_rows, dtype=np.int64)
    basis = np.frombuffer(of_basis).reshape(len(rows), -1)
    projector = np.eye(len(rows)) - basis @ basis.T
    covariance = np.stack([one.unit[np.ix_(rows, rows)] for one in processes])
    return np.linalg.eigh(projector @ covariance @ projector)


def constant(n: int) -> FloatArray:
    """Return the orthonormal basis of a constant pose, shape (n, 1)."""
    return np.full((n, 1), n**-0.5)


def extended(basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis of ``basis`` (n, f) and ``columns`` (n, k) together."""
    vectors, usable = _orthonormal(columns[:, :, np.newaxis], basis)
    if not any(usable):
        return basis
    q, r = np.linalg.qr(vectors[:, :, 0])
    return np.concatenate([basis, q[:, np.abs(np.diag(r)) > 1e-6]], axis=1)


class ManyPoses(NamedTuple):
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


@dataclass(frozen=True, eq=False, slots=True)
class Remainder:
    """What fitted terms leave of some rows of a run of so many ``cycles``.

    ``values`` (rows, axes) are the residual readings, ``half`` (rows, axes) half a division of
    each, 0 where there is no dial, ``known`` (axes,) their scatter, 0 where it is not known.
    ``views`` are theirs beside ``basis`` (rows, f), what is fitted; ``division`` (axes,) is the
    dial's in the units of the views, nan for an axis that can show no two states. ``members`` are
    the hypotheses that are still open.
    """

    rows: IntArray
    cycles: int
    basis: FloatArray
    values: FloatArray
    half: FloatArray
    known: FloatArray
    division: FloatArray
    views: Views
    members: tuple[Hypothesis, ...]


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


def at_amplitudes(
    hypotheses: HypothesisSet,
    columns: FloatArray,
    known: FloatArray | float = 0.0,
    misfit: float = 0.0,
) -> FloatArray:
    """Return `log_bayes` with every variance at each of AMPLITUDES, (amplitudes, members, m)."""
    found = [log_bayes(hypotheses, columns, known, factor, misfit) for factor in AMPLITUDES]
    return np.stack(found)


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


def wider(form: Form, factor: float) -> Form:
    """Return a random course of ``factor`` times the variance; any other form as it is."""
    if not isinstance(form, Process):
        return form
    return replace(form, variance=factor * form.variance)


def log_evidence_by_effect(hypotheses: HypothesisSet, views: Views) -> dict[str, FloatArray]:
    """Return the log evidence (axes,) that each axis alone has for each known effect's courses."""
    log_bf = log_bayes(hypotheses, views.columns, views.known)[:, : views.axes]
    found = {}
    for name, own in by_effect(hypotheses).items():
        weights = hypotheses.weights[own]
        if weights.any():
            logs = log_bf[own] + np.log(np.maximum(weights / weights.sum(), _TINY))[:, np.newaxis]
            found[name] = np.asarray(np.logaddexp.reduce(logs))
    return found


def by_effect(hypotheses: HypothesisSet) -> dict[str, list[int]]:
    """Return the members of each effect, by number."""
    found: dict[str, list[int]] = {}
    for i, member in enumerate(hypotheses.members):
        found.setdefault(member.effect, []).append(i)
    return found
