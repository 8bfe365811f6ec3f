"""The hypothesis set: every form of every effect, made ready for fast comparison.

A deterministic shape under a g-prior and a random process are one thing here: a covariance
I + U diag(s) U' of the readings beside their scatter, U orthonormal. What was already fitted (at
least the constant pose) is projected out of U.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from scara_iso.diagnosis.tuning import (
    GAIN,
    LEVELS_WEIGHT,
    PASSAGE_WEIGHT,
    ROUGH_LENGTHS,
    ROUGH_VARIANCES,
    ROUGH_WEIGHT,
    SMOOTH_LENGTHS,
    SMOOTH_VARIANCES,
    SMOOTH_WEIGHT,
    UNKNOWN,
)
from scara_iso.effects import (
    Chain,
    Conditions,
    Effect,
    Form,
    FoundBy,
    OwnEffect,
    Process,
    Shape,
    Spread,
)
from scara_iso.run import FloatArray, IntArray

_TINY = 1e-9
_LEAST_EIGENVALUE = 1e-4
_EVERY = "*"
_SAME = 0.9999
"""Cosine from which two courses are one."""


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """An effect (or UNKNOWN) in one of its forms.

    ``weight`` is its prior weight among all hypotheses, ``test_weight`` that in the test over it.
    ``ordered`` ones count in the test by permutation, ``named`` ones in the choice of a name.
    """

    effect: str
    form: Form
    weight: float
    test_weight: float = 1.0
    gain: float = GAIN
    ordered: bool = True
    named: bool = True

    @property
    def hidden(self) -> bool:
        """Whether its course is hidden and must be inferred from the readings."""
        return isinstance(self.form, Chain)


@dataclass(frozen=True, eq=False, slots=True)
class HypothesisSet:
    """Hypotheses over n cycles, orthogonal to ``basis`` (n, f), which holds what is fitted.

    ``vectors`` (n, m) are the members' orthonormal columns side by side, beginning at ``first``
    (one for each); ``shrink`` (m,) is s / (1 + s) of each column, ``penalty`` the members' log
    determinants. Spreads come last and have ``scales`` (spreads, n) instead.
    """

    members: tuple[Hypothesis, ...]
    basis: FloatArray
    vectors: FloatArray
    shrink: FloatArray
    first: IntArray
    penalty: FloatArray
    scales: FloatArray

    @property
    def weights(self) -> FloatArray:
        """Prior weight of each member, as given."""
        return np.array([member.weight for member in self.members])

    @property
    def test_weights(self) -> FloatArray:
        """Weight of each member in the test, together 1."""
        tested = self.weights * [member.test_weight for member in self.members]
        return np.asarray(tested / tested.sum())

    def amplified(self, factor: float) -> HypothesisSet:
        """Return the set with every variance beside the scatter ``factor`` times as large."""
        s = self.shrink / (1 - self.shrink) * factor
        return replace(self, shrink=s / (1 + s), penalty=np.add.reduceat(np.log1p(s), self.first))


def hypotheses_of(effects: Sequence[Effect], conditions: Conditions) -> tuple[Hypothesis, ...]:
    """Return every hypothesis about readings taken under ``conditions``, the unknown included.

    An effect of any column takes those through which no other effect acts. What a user wrote takes
    no other hypothesis away.
    """
    catalogue = [effect for effect in effects if not isinstance(effect, OwnEffect)]
    others = [effect for effect in catalogue if _EVERY not in effect.needs]
    free = conditions.without(
        {name for name in conditions.covariates if any(effect.takes(name) for effect in others)}
    )
    known = [
        hypothesis
        for effect in effects
        for hypothesis in _of_effect(effect, free if _EVERY in effect.needs else conditions)
    ]
    recorded = {effect.name for effect in catalogue if effect.needs}
    return (
        *_not_recorded(known, recorded),
        *_unknown(conditions),
        *_passages(conditions),
        *_levels(conditions),
    )


def _not_recorded(members: Sequence[Hypothesis], recorded: Set[str]) -> list[Hypothesis]:
    """Return the members without those shapes that a recorded column has too.

    The column takes their place; ``recorded`` are the effects through columns.
    """
    of_columns = [_turned(m.form) for m in members if m.effect in recorded]
    same = np.array([column for column in of_columns if column is not None])
    if not len(same):
        return list(members)

    def stays(member: Hypothesis) -> bool:
        course = None if member.effect in recorded else _turned(member.form)
        return course is None or float(np.abs(same @ course).max()) < _SAME

    return [member for member in members if stays(member)]


def _turned(form: Form) -> FloatArray | None:
    """Return the course of a shape of one column, centred and of unit length."""
    if not isinstance(form, Shape) or form.columns.shape[1] != 1:
        return None
    centred = form.columns[:, 0] - form.columns[:, 0].mean()
    return np.asarray(centred / np.linalg.norm(centred))


def _of_effect(effect: Effect, conditions: Conditions) -> list[Hypothesis]:
    forms = [form for form in effect.forms(conditions) if not _still(form)]
    total = sum(form.weight for form in forms)
    ordered = effect.found_by is FoundBy.ORDER
    return [
        Hypothesis(
            effect.name, form, effect.weight * form.weight / total, effect.test_weight,
            effect.gain, ordered,
        )
        for form in forms
    ]  # fmt: skip


def _still(form: Form) -> bool:
    """Return whether a shape moves nothing beside the pose."""
    return isinstance(form, Shape) and not np.ptp(form.columns, axis=0).all()


def _unknown(conditions: Conditions) -> list[Hypothesis]:
    """Return smooth (squared-exponential) and rough (exponential) processes over the cycles."""
    lag = np.abs(np.subtract.outer(conditions.elapsed, conditions.elapsed))
    smooth = [np.exp(-0.5 * (lag / length) ** 2) for length in SMOOTH_LENGTHS]
    rough = [np.exp(-lag / length) for length in ROUGH_LENGTHS]
    return [
        *_processes(smooth, SMOOTH_VARIANCES, SMOOTH_WEIGHT),
        *_processes(rough, ROUGH_VARIANCES, ROUGH_WEIGHT),
    ]


def _processes(
    correlations: Sequence[FloatArray], variances: Sequence[float], weight: float
) -> list[Hypothesis]:
    each = weight / (len(correlations) * len(variances))
    return [Hypothesis(UNKNOWN, Process(v * c), each) for c in correlations for v in variances]


def _passages(conditions: Conditions) -> list[Hypothesis]:
    """Return levels that come and go again: they help the test to see, and carry no name."""
    n = len(conditions)
    row = np.arange(n)[:, np.newaxis]
    stride = max(2, n // 15)
    spans = [(a, b) for a in range(2, n - 3, stride) for b in range(a + 2, n - 1, stride)]
    return [
        Hypothesis(UNKNOWN, Shape(np.where((row >= a) & (row < b), 1.0, 0.0)),
               PASSAGE_WEIGHT / len(spans), named=False)
        for a, b in spans
    ]  # fmt: skip


def _levels(conditions: Conditions) -> list[Hypothesis]:
    """Return courses of three and four levels: more than any one named effect has."""
    n = len(conditions)
    row = np.arange(n)[:, np.newaxis]
    members = []
    for levels, weight in LEVELS_WEIGHT.items():
        stride = max(levels - 1, (levels - 1) * n // 30)
        changes = list(combinations(range(levels - 1, n - levels + 2, stride), levels - 1))
        shapes = [Shape(np.where(row >= at, 1.0, 0.0)) for at in changes]
        members += [Hypothesis(UNKNOWN, s, weight / len(shapes), ordered=False) for s in shapes]
    return members


def build(members: Sequence[Hypothesis], rows: IntArray, basis: FloatArray) -> HypothesisSet:
    """Return the set of ``members`` on ``rows`` of the run, free of the orthonormal ``basis``.

    ``basis`` has shape (rows, f). Members that say nothing beside it are left out, and so are
    chains, which are searched in the readings themselves.
    """
    groups = [*_shape_groups(members, rows, basis), *_process_groups(members, rows, basis)]
    spreads = [(m, m.form) for m in members if isinstance(m.form, Spread)]
    scales = [np.empty((0, len(rows))), *(form.scale[np.newaxis, rows] for _, form in spreads)]
    return HypothesisSet(
        members=(*(m for group in groups for m in group.members), *(m for m, _ in spreads)),
        basis=basis,
        vectors=np.concatenate([np.empty((len(basis), 0)), *(g.vectors for g in groups)], axis=1),
        shrink=np.concatenate([np.empty(0), *(group.shrink for group in groups)]),
        first=_starts([width for group in groups for width in group.widths]),
        penalty=np.concatenate([np.empty(0), *(group.penalty for group in groups)]),
        scales=np.concatenate(scales),
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Group:
    """Members of one kind with their columns side by side; fields as in `HypothesisSet`."""

    members: tuple[Hypothesis, ...]
    vectors: FloatArray
    shrink: FloatArray
    widths: tuple[int, ...]
    penalty: FloatArray


def _starts(widths: Sequence[int]) -> IntArray:
    return np.cumsum([0, *widths])[:-1]


def _shape_groups(members: Sequence[Hypothesis], rows: IntArray, basis: FloatArray) -> list[_Group]:
    shaped = [(m, m.form.columns) for m in members if isinstance(m.form, Shape)]
    widths = sorted({columns.shape[1] for _, columns in shaped})
    return [_shape_group([s for s in shaped if s[1].shape[1] == k], rows, basis) for k in widths]


def _shape_group(
    shaped: Sequence[tuple[Hypothesis, FloatArray]], rows: IntArray, basis: FloatArray
) -> _Group:
    columns = np.stack([columns for _, columns in shaped])[:, rows]
    vectors, usable = _orthonormal(columns, basis)
    members = tuple(m for (m, _), use in zip(shaped, usable, strict=True) if use)
    k = vectors.shape[2]
    gain = np.array([m.gain for m in members], dtype=np.float64)
    return _Group(
        members=members,
        vectors=np.moveaxis(vectors, 0, 1).reshape(len(basis), -1),
        shrink=np.repeat(gain / (1 + gain), k),
        widths=(k,) * len(members),
        penalty=k * np.log1p(gain),
    )


def _orthonormal(columns: FloatArray, basis: FloatArray) -> tuple[FloatArray, list[bool]]:
    """Return Gram-Schmidt bases of columns (s, n, k) beside ``basis``, and which were usable."""
    scale = np.linalg.norm(columns, axis=1)
    free = columns - basis @ (basis.T @ columns)
    free -= basis @ (basis.T @ free)
    usable = np.ones(len(columns), dtype=bool)
    for i in range(columns.shape[2]):
        for j in range(i):
            free[:, :, i] -= (free[:, :, j] * free[:, :, i]).sum(1)[:, None] * free[:, :, j]
        length = np.linalg.norm(free[:, :, i], axis=1)
        usable &= length > 1e-6 * np.maximum(scale[:, i], _TINY)
        free[:, :, i] /= np.maximum(length, _TINY)[:, np.newaxis]
    return free[usable], [bool(u) for u in usable]


def _process_groups(
    members: Sequence[Hypothesis], rows: IntArray, basis: FloatArray
) -> list[_Group]:
    chosen = [(m, m.form.covariance) for m in members if isinstance(m.form, Process)]
    return [_process_group(chosen, rows, basis)] if chosen else []


def _process_group(
    chosen: Sequence[tuple[Hypothesis, FloatArray]], rows: IntArray, basis: FloatArray
) -> _Group:
    projector = np.eye(len(rows)) - basis @ basis.T
    covariance = np.stack([c for _, c in chosen])[:, rows[:, np.newaxis], rows]
    values, vectors = np.linalg.eigh(projector @ covariance @ projector)
    keep = values > _LEAST_EIGENVALUE
    said = [i for i in range(len(chosen)) if keep[i].any()]
    shrink = [values[i][keep[i]] / (1 + values[i][keep[i]]) for i in said]
    columns = [np.empty((len(rows), 0)), *(vectors[i][:, keep[i]] for i in said)]
    return _Group(
        members=tuple(chosen[i][0] for i in said),
        vectors=np.concatenate(columns, axis=1),
        shrink=np.concatenate([np.empty(0), *shrink]),
        widths=tuple(len(s) for s in shrink),
        penalty=np.array([-np.log1p(-s).sum() for s in shrink]),
    )


def constant(n: int) -> FloatArray:
    """Return the orthonormal basis of a constant pose, shape (n, 1)."""
    return np.full((n, 1), n**-0.5)


def extended(basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis of ``basis`` (n, f) and ``columns`` (n, k) together."""
    vectors, usable = _orthonormal(columns.T[:, :, np.newaxis], basis)
    if not any(usable):
        return basis
    q, r = np.linalg.qr(vectors[:, :, 0].T)
    return np.concatenate([basis, q[:, np.abs(np.diag(r)) > 1e-6]], axis=1)
