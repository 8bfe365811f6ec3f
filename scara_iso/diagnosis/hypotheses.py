"""The hypotheses about readings: forms of effects, courses of no name, made ready to compare.

A shape under a g-prior and a random course are one thing here: a covariance I + U diag(s) U' of the
readings beside their scatter, U orthonormal and free of what is fitted (at least the pose).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import compress

import numpy as np

from scara_iso.diagnosis.rounded import DialCourse, scatter_alone
from scara_iso.diagnosis.tuning import (
    CHANGING_LENGTHS,
    CHANGING_VARIANCES,
    CHANGING_WEIGHT,
    FEWEST_MOVED,
    GAIN,
    RECURRING,
    RECURRING_VARIANCES,
    RECURRING_WEIGHT,
    SMOOTH_CYCLES,
    SMOOTH_LENGTHS,
    SMOOTH_VARIANCES,
    SMOOTH_WEIGHT,
    SWINGS,
    UNKNOWN,
)
from scara_iso.effects import CLOCK, Conditions, Effect, Form, OwnEffect, Process, Shape, Spread
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_EVERY = "*"
_SAME = 0.9999
"""Cosine from which two courses are one."""
_TINY = 1e-9
_LEAST_EIGENVALUE = 1e-4


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """An effect (or UNKNOWN) in one of its forms.

    ``weight`` is its prior weight among all hypotheses, ``test_weight`` that in the test over it.
    ``ordered`` ones count in the test by permutation. A course that axes share is ``of`` a form.
    """

    effect: str
    form: Form
    weight: float
    test_weight: float = 1.0
    gain: float = GAIN
    ordered: bool = True
    of: Form | None = None


def hypotheses_of(
    effects: Sequence[Effect], conditions: Conditions, of: IntArray | None = None
) -> tuple[Hypothesis, ...]:
    """Return every hypothesis about readings taken under ``conditions``, the unknown included.

    An effect of any column takes those through which no other effect acts. A recorded column takes
    the place of a shape of the same course; what a user wrote takes none away. ``of`` is that of
    `of_visits`.
    """
    catalogue = [effect for effect in effects if not isinstance(effect, OwnEffect)]
    others = [effect for effect in catalogue if _EVERY not in effect.needs]

    def left(columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        return {n: c for n, c in columns.items() if not any(one.takes(n) for one in others)}

    visits = {pose: left(columns) for pose, columns in conditions.visits.items()}
    free = Conditions(conditions.cycle, left(conditions.covariates), visits)
    plain = tuple(effect for effect in effects if not effect.needs and not effect.hidden_by)
    clock = np.asarray(conditions.covariates.get(CLOCK, ()), dtype=np.float64).tobytes()
    cycle = np.asarray(conditions.cycle, dtype=np.int64).tobytes()
    shared, unknown = _of_cycles(plain, cycle, clock)
    known = [
        hypothesis
        for effect in effects
        for hypothesis in shared.get(effect)
        or _of_effect(effect, free if _EVERY in effect.needs else conditions, of)
    ]
    by_column = {effect.name for effect in catalogue if effect.needs}
    return (*_not_recorded(known, by_column), *unknown)


@lru_cache(maxsize=8)
def _of_cycles(
    plain: tuple[Effect, ...], cycle: bytes, clock: bytes
) -> tuple[dict[Effect, tuple[Hypothesis, ...]], tuple[Hypothesis, ...]]:
    """Return the forms of effects without columns, and the unknown; tables alike share them."""
    seconds = {CLOCK: np.frombuffer(clock)} if clock else {}
    conditions = Conditions(np.frombuffer(cycle, dtype=np.int64), seconds)
    return {effect: _of_effect(effect, conditions) for effect in plain}, _unknown(conditions)


def _not_recorded(members: Sequence[Hypothesis], recorded: Set[str]) -> list[Hypothesis]:
    of_columns = [_turned(m.form) for m in members if m.effect in recorded]
    same = np.array([column for column in of_columns if column is not None])
    if not len(same):
        return list(members)

    def stays(member: Hypothesis) -> bool:
        course = None if member.effect in recorded else _turned(member.form)
        return course is None or float(np.abs(same @ course).max()) < _SAME

    return [member for member in members if stays(member)]


def of_visits(
    forms: Callable[[Conditions], Sequence[Form]], conditions: Conditions, of: IntArray
) -> tuple[Shape, ...]:
    """Return the shapes among ``forms`` that take columns of which each pose has its own.

    ``of`` (views,) says which pose each view shows; -1 is the mean of all.
    """
    at_poses = (forms(conditions.at(pose)) for pose in conditions.visits)
    each = ([form for form in found if isinstance(form, Shape)] for found in at_poses)
    found = []
    for same in zip(*each, strict=False):
        columns = np.hstack([one.columns for one in same])
        alike = all(one.parameters == same[0].parameters for one in same)
        if alike and columns.shape[1] == len(same) and np.ptp(columns, axis=1).any():
            columns = np.column_stack([columns, columns.mean(axis=1)])
            found.append(replace(same[0], columns=columns, of=of))
    return tuple(found)


def on_axes(form: Form, axes: IntArray) -> Form:
    """Return a form as some of the axes have it."""
    return form if form.of is None else replace(form, of=form.of[axes])


def _turned(form: Form) -> FloatArray | None:
    if form.columns.shape[1] != 1:
        return None
    centred = form.columns[:, 0] - form.columns[:, 0].mean()
    return np.asarray(centred / np.linalg.norm(centred))


def _of_effect(
    effect: Effect, conditions: Conditions, of: IntArray | None = None
) -> tuple[Hypothesis, ...]:
    """Return the forms of an effect; those that have an order share its weight, if any has."""
    own = () if of is None or not effect.needs else of_visits(effect.forms, conditions, of)
    forms = [f for f in (*effect.forms(conditions), *own) if np.ptp(f.columns, axis=0).all()]
    ordered = [_has_order(effect, form) for form in forms]
    total = sum(compress((form.weight for form in forms), ordered))
    total = total or sum(form.weight for form in forms)
    return tuple(
        Hypothesis(
            effect.name,
            form,
            effect.weight * form.weight / total,
            effect.test_weight,
            effect.gain,
            use,
        )
        for form, use in zip(forms, ordered, strict=True)
    )


def _has_order(effect: Effect, form: Form) -> bool:
    """Return whether the test of the order counts a form.

    A shape of the catalogue that moves one or two readings is hardly rarer than any other order.
    """
    if effect.needs or isinstance(effect, OwnEffect) or not isinstance(form, Shape):
        return True
    moved = form.columns != median(form.columns, axis=0)
    return int(moved.any(axis=1).sum()) >= FEWEST_MOVED


def _unknown(conditions: Conditions) -> tuple[Hypothesis, ...]:
    """Return Gaussian processes over the cycles: smooth, of changing width, swinging, recurring.

    Smooth ones are squared exponentials; any course may recur after so many cycles.
    """
    lag = np.abs(np.subtract.outer(conditions.elapsed, conditions.elapsed))
    unit = len(conditions) / SMOOTH_CYCLES
    smooth = [np.exp(-0.5 * (lag / (unit * length)) ** 2) for length in SMOOTH_LENGTHS]
    changing = [gibbs(conditions.elapsed, unit * np.array(ends)) for ends in CHANGING_LENGTHS]
    swinging = [swing(conditions.elapsed, unit * np.array(e), keeps) for *e, keeps in SWINGS]
    recurring = [
        (lag % period == 0).astype(np.float64) for period in RECURRING if 3 * period <= len(lag)
    ]
    kinds = (
        (smooth, SMOOTH_VARIANCES, SMOOTH_WEIGHT),
        ([*changing, *swinging], CHANGING_VARIANCES, CHANGING_WEIGHT),
        (recurring, RECURRING_VARIANCES, RECURRING_WEIGHT),
    )
    return tuple(
        Hypothesis(UNKNOWN, Process(c, variance=v), weight / (len(courses) * len(variances)))
        for courses, variances, weight in kinds
        for c in courses
        for v in variances
    )


def gibbs(elapsed: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the correlation (n, n) of a course whose width goes from ``ends[0]`` to ``ends[1]``.

    k(i, j) = sqrt(2 l_i l_j / (l_i^2 + l_j^2)) exp(-(t_i - t_j)^2 / (l_i^2 + l_j^2)), l linear in
    time (Gibbs 1997, eq. 3.40).
    """
    width = np.interp(elapsed, elapsed[[0, -1]], ends)
    squares = width[:, np.newaxis] ** 2 + width**2
    lag = np.subtract.outer(elapsed, elapsed)
    return np.asarray(np.sqrt(2 * np.outer(width, width) / squares) * np.exp(-(lag**2) / squares))


def swing(elapsed: FloatArray, ends: FloatArray, keeps: float) -> FloatArray:
    """Return the correlation (n, n) of a swing whose period goes from ``ends[0]`` to ``ends[1]``.

    k(i, j) = cos(2 pi d) exp(-(d / c)^2 / 2), d the periods between i and j, of which the phase is
    kept for c = ``keeps``.
    """
    frequency = 1 / np.interp(elapsed, elapsed[[0, -1]], ends)
    between = np.diff(elapsed) * (frequency[1:] + frequency[:-1]) / 2
    periods = np.append(0.0, np.cumsum(between))
    apart = np.subtract.outer(periods, periods)
    return np.asarray(np.cos(2 * np.pi * apart) * np.exp(-0.5 * (apart / keeps) ** 2))


@dataclass(frozen=True, eq=False, slots=True)
class Group:
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
        groups = (one if one.of is None else replace(one, of=one.of[axes]) for one in self.groups)
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
        return replace(scatter_alone(len(self.basis)), scale=self.scales[i])


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
        usable &= length > 1e-6 * np.maximum(scale[:, i], _TINY)
        free[:, :, i] /= np.maximum(length, _TINY)
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
