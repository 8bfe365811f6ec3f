"""The hypothesis set: hypotheses made ready for fast comparison.

A deterministic shape under a g-prior and a random process are one thing here: a covariance
I + U diag(s) U' of the readings beside their scatter, U orthonormal. What was already fitted (at
least the constant pose) is projected out of U.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import compress

import numpy as np

from scara_iso.diagnosis.hypotheses import Hypothesis
from scara_iso.effects import Process, Shape, Spread
from scara_iso.frozen import dataclass
from scara_iso.run import FloatArray, IntArray

_TINY = 1e-9
_LEAST_EIGENVALUE = 1e-4


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

    def summed(self, columns: FloatArray) -> FloatArray:
        """Return the sums over each member's columns, shape (members, m) from (columns, m)."""
        single = np.diff(self.first, append=len(columns)) == 1
        found = np.empty((len(self.first), columns.shape[1]))
        found[single] = columns[self.first[single]]
        ends = [*self.first[1:], len(columns)]
        for k in np.flatnonzero(~single):  # several times as fast as reduceat across the rows
            columns[self.first[k] : ends[k]].sum(axis=0, out=found[k])
        return found

    def amplified(self, factor: float) -> HypothesisSet:
        """Return the set with every variance beside the scatter ``factor`` times as large."""
        s = self.shrink / (1 - self.shrink) * factor
        return replace(self, shrink=s / (1 + s), penalty=np.add.reduceat(np.log1p(s), self.first))

    def of(self, members: Sequence[Hypothesis]) -> HypothesisSet:
        """Return the set of those of ``members`` that this one holds."""
        wanted = set(members)
        held = np.array([member in wanted for member in self.members], dtype=bool)
        courses, spreads = np.split(held, [len(self.first)])
        widths = np.diff(self.first, append=len(self.shrink))
        columns = np.repeat(courses, widths)
        return HypothesisSet(
            members=tuple(compress(self.members, held)),
            basis=self.basis,
            vectors=np.compress(columns, self.vectors, axis=1),
            shrink=self.shrink[columns],
            first=_starts(widths[courses]),
            penalty=self.penalty[courses],
            scales=self.scales[spreads],
        )


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


def _starts(widths: Sequence[int] | IntArray) -> IntArray:
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
    chosen = [(m, m.form) for m in members if isinstance(m.form, Process)]
    return [_process_group(chosen, rows, basis)] if chosen else []


def _process_group(
    chosen: Sequence[tuple[Hypothesis, Process]], rows: IntArray, basis: FloatArray
) -> _Group:
    values, vectors = _eigen(tuple(form for _, form in chosen), rows.tobytes(), basis.tobytes())
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


@lru_cache(maxsize=2)
def _eigen(
    forms: tuple[Process, ...], of_rows: bytes, of_basis: bytes
) -> tuple[FloatArray, FloatArray]:
    """Return eigenvalues (processes, n) and vectors (processes, n, n) on rows, free of a basis.

    Tables of the same cycles share them.
    """
    rows = np.frombuffer(of_rows, dtype=np.int64)
    basis = np.frombuffer(of_basis).reshape(len(rows), -1)
    projector = np.eye(len(rows)) - basis @ basis.T
    covariance = np.stack([form.covariance for form in forms])[:, rows[:, np.newaxis], rows]
    values, vectors = np.linalg.eigh(projector @ covariance @ projector)
    values.flags.writeable = vectors.flags.writeable = False
    return values, vectors


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
