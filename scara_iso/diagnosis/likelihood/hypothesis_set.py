"""The hypothesis set: hypotheses made ready for fast comparison.

A deterministic shape under a g-prior and a random process are one thing here: a covariance
I + U diag(s) U' of the readings beside their scatter, U orthonormal. What was already fitted (at
least the constant pose) is projected out of U.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import compress, pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis
from scara_iso.effects import Process, Shape, Spread
from scara_iso.run import FloatArray, IntArray

_TINY = 1e-9
_LEAST_EIGENVALUE = 1e-4


@dataclass(frozen=True, eq=False)
class HypothesisSet:
    """Hypotheses over n cycles, orthogonal to ``basis`` (n, f), which holds what is fitted.

    ``vectors`` (n, m) are orthonormal columns, of which each member has ``widths`` from ``first``
    on; random courses that differ in their variance alone share theirs. ``shrink`` is s / (1 + s)
    of the members' columns, one member behind the other, ``penalty`` the members' log
    determinants. Spreads come last and have ``scales`` (spreads, n) instead.
    """

    members: tuple[Hypothesis, ...]
    basis: FloatArray
    vectors: FloatArray
    first: IntArray
    widths: IntArray
    shrink: FloatArray
    penalty: FloatArray
    scales: FloatArray

    @cached_property
    def weights(self) -> FloatArray:
        """Prior weight of each member, as given."""
        return np.array([member.weight for member in self.members])

    @cached_property
    def test_weights(self) -> FloatArray:
        """Weight of each member in the test, together 1."""
        tested = self.weights * [member.test_weight for member in self.members]
        return np.asarray(tested / tested.sum(), dtype=self.vectors.dtype)

    @cached_property
    def by_largest(self) -> IntArray:
        """Places of the members without a weight in the test, of which the likeliest counts."""
        return np.flatnonzero([not member.test_weight for member in self.members])

    def explained(self, squared: FloatArray, out: FloatArray) -> None:
        """Put the shrunk sums over each member's columns, of (columns, m), into ``out``.

        That has the shape (members, m).
        """
        begin = 0
        for own, at, k, shared in self._runs:
            count = own.stop - own.start
            shrink = self.shrink[begin : begin + count * k].reshape(count, k)
            begin += count * k
            if shared:
                np.matmul(shrink, squared[at : at + k], out=out[own])
                continue
            np.multiply(shrink[:, :1], squared[at : at + count * k : k], out=out[own])
            for i in range(1, k):
                out[own] += shrink[:, i : i + 1] * squared[at + i : at + count * k : k]

    @cached_property
    def _runs(self) -> tuple[tuple[slice, int, int, bool], ...]:
        """Members in a row that share columns of one width, or have them side by side.

        With the first column, the width, and whether they share.
        """
        shared = np.diff(self.first, prepend=-1, append=-1) == 0
        columns = np.where(shared[1:] | shared[:-1], self.first, -1)
        new = (np.diff(self.widths, prepend=-1) != 0) | (np.diff(columns, prepend=-2) != 0)
        return tuple(
            (slice(a, b), int(self.first[a]), int(self.widths[a]), bool(columns[a] >= 0))
            for a, b in pairwise([*np.flatnonzero(new).tolist(), len(new)])
        )

    def of_member(self, i: int) -> tuple[FloatArray, FloatArray]:
        """Return shrink (k,) and columns (n, k) of one member that has columns."""
        k, begin = int(self.widths[i]), int(self.widths[:i].sum())
        return self.shrink[begin : begin + k], self.vectors[:, self.first[i] : self.first[i] + k]

    def amplified(self, factor: float) -> HypothesisSet:
        """Return the set with every variance beside the scatter ``factor`` times as large."""
        s = self.shrink / (1 - self.shrink) * factor
        penalty = np.add.reduceat(np.log1p(s), _starts(self.widths))
        return replace(self, shrink=s / (1 + s), penalty=penalty)

    def in_single_precision(self) -> HypothesisSet:
        """Return the set in numbers of half the length, which are compared several times faster."""
        names = ("basis", "vectors", "shrink", "penalty", "scales")
        return replace(self, **{name: getattr(self, name).astype(np.float32) for name in names})

    def of(self, members: Sequence[Hypothesis]) -> HypothesisSet:
        """Return the set of those of ``members`` that this one holds."""
        wanted = set(members)
        held = np.array([member in wanted for member in self.members], dtype=bool)
        courses, spreads = np.split(held, [len(self.first)])
        own = np.repeat(courses, self.widths)
        at = np.repeat(self.first - _starts(self.widths), self.widths) + np.arange(len(own))
        used = np.zeros(self.vectors.shape[1], dtype=bool)
        used[at[own]] = True
        return HypothesisSet(
            members=tuple(compress(self.members, held)),
            basis=self.basis,
            vectors=np.compress(used, self.vectors, axis=1),
            first=(np.cumsum(used) - used)[self.first[courses]],
            widths=self.widths[courses],
            shrink=self.shrink[own],
            penalty=self.penalty[courses],
            scales=self.scales[spreads],
        )


def build(members: Sequence[Hypothesis], rows: IntArray, basis: FloatArray) -> HypothesisSet:
    """Return the set of ``members`` on ``rows`` of the run, free of the orthonormal ``basis``.

    ``basis`` has shape (rows, f). Members that say nothing beside it are left out, and so are
    chains, which are searched in the readings themselves.
    """
    kinds = _kinds(tuple(members))
    groups = [_shape_group(own, columns[rows], basis) for own, columns in kinds.shapes]
    groups += [_process_group(kinds.processes, rows, basis)] if kinds.processes else []
    behind = np.cumsum([0, *(group.vectors.shape[1] for group in groups)])
    return HypothesisSet(
        members=(*(m for group in groups for m in group.members), *kinds.spreads),
        basis=basis,
        vectors=np.concatenate([np.empty((len(basis), 0)), *(g.vectors for g in groups)], axis=1),
        first=_joined([g.first + at for g, at in zip(groups, behind, strict=False)], np.int64),
        widths=_joined([group.widths for group in groups], np.int64),
        shrink=_joined([group.shrink for group in groups]),
        penalty=_joined([group.penalty for group in groups]),
        scales=kinds.scales[:, rows] if kinds.spreads else np.empty((0, len(rows))),
    )


def _joined(parts: Sequence[npt.NDArray[Any]], kind: type = np.float64) -> npt.NDArray[Any]:
    return np.concatenate([np.empty(0, dtype=kind), *parts])


@dataclass(frozen=True, eq=False, slots=True)
class _Kinds:
    """Members by kind: shapes of one width with their columns (n, members, k), and the others."""

    shapes: tuple[tuple[tuple[Hypothesis, ...], FloatArray], ...]
    processes: tuple[tuple[Hypothesis, Process], ...]
    spreads: tuple[Hypothesis, ...]
    scales: FloatArray


@lru_cache(maxsize=2)
def _kinds(members: tuple[Hypothesis, ...]) -> _Kinds:
    """Return the members by kind; folds of one run share them."""
    by_width: dict[int, list[tuple[Hypothesis, FloatArray]]] = {}
    for m in members:
        if isinstance(m.form, Shape):
            by_width.setdefault(m.form.columns.shape[1], []).append((m, m.form.columns))
    spreads = [(m, m.form.scale) for m in members if isinstance(m.form, Spread)]
    return _Kinds(
        tuple(
            (
                tuple(m for m, _ in by_width[k]),
                np.stack([columns for _, columns in by_width[k]], axis=1),
            )
            for k in sorted(by_width)
        ),
        tuple((m, m.form) for m in members if isinstance(m.form, Process)),
        tuple(m for m, _ in spreads),
        np.array([scale for _, scale in spreads]),
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Group:
    """Members of one kind; fields as in `HypothesisSet`."""

    members: tuple[Hypothesis, ...]
    vectors: FloatArray
    first: IntArray
    widths: IntArray
    shrink: FloatArray
    penalty: FloatArray


def _starts(widths: IntArray) -> IntArray:
    return np.cumsum(widths) - widths


def _shape_group(shaped: Sequence[Hypothesis], columns: FloatArray, basis: FloatArray) -> _Group:
    vectors, usable = _orthonormal(columns, basis)
    members = tuple(compress(shaped, usable))
    k = vectors.shape[2]
    gain = np.array([m.gain for m in members], dtype=np.float64)
    widths = np.full(len(members), k)
    return _Group(
        members=members,
        vectors=vectors.reshape(len(basis), -1),
        first=k * np.arange(len(members)),
        widths=widths,
        shrink=np.repeat(gain / (1 + gain), k),
        penalty=k * np.log1p(gain),
    )


def _orthonormal(columns: FloatArray, basis: FloatArray) -> tuple[FloatArray, list[bool]]:
    """Return Gram-Schmidt bases of columns (n, s, k) beside ``basis``, and which were usable."""
    scale = np.linalg.norm(columns, axis=0)
    flat = columns.reshape(len(columns), -1)
    flat = flat - basis @ (basis.T @ flat)
    flat -= basis @ (basis.T @ flat)
    free = flat.reshape(columns.shape)
    usable = np.ones(columns.shape[1], dtype=bool)
    for i in range(columns.shape[2]):
        for j in range(i):
            free[:, :, i] -= (free[:, :, j] * free[:, :, i]).sum(axis=0) * free[:, :, j]
        length = np.linalg.norm(free[:, :, i], axis=0)
        usable &= length > 1e-6 * np.maximum(scale[:, i], _TINY)
        free[:, :, i] /= np.maximum(length, _TINY)
    return free[:, usable], [bool(u) for u in usable]


def _process_group(
    chosen: Sequence[tuple[Hypothesis, Process]], rows: IntArray, basis: FloatArray
) -> _Group:
    """Return the processes; those of one unit keep the eigenvectors that say something of any."""
    forms = tuple(form for _, form in chosen)
    eigen = _eigen_of_few if len(rows) <= _FEW else _eigen
    unit, values, vectors = eigen(forms, rows.tobytes(), basis.tobytes())
    s = np.array([form.variance for form in forms])[:, np.newaxis] * values[unit]
    s[s <= _LEAST_EIGENVALUE] = 0.0
    said = np.asarray(s.any(axis=1))
    s, unit = s[said], unit[said]
    columns, first, widths = [np.empty((len(rows), 0))], np.zeros_like(unit), np.zeros_like(unit)
    for u in sorted(set(unit.tolist())):
        kept = s[unit == u].any(axis=0)
        first[unit == u] = sum(part.shape[1] for part in columns)
        widths[unit == u] = kept.sum()
        columns.append(vectors[u][:, kept])
    last = [one[len(rows) - width :] for one, width in zip(s, widths, strict=True)]
    s = _joined(last)
    return _Group(
        members=tuple(compress((m for m, _ in chosen), said)),
        vectors=np.concatenate(columns, axis=1),
        first=first,
        widths=widths,
        shrink=s / (1 + s),
        penalty=np.array([np.log1p(one).sum() for one in last]),
    )


def _of_units(
    forms: tuple[Process, ...], of_rows: bytes, of_basis: bytes
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return each process' unit by number, and what the units are on rows, free of a basis.

    That is their eigenvalues (units, n), ascending, and vectors (units, n, n). Tables of the same
    cycles share them.
    """
    rows = np.frombuffer(of_rows, dtype=np.int64)
    basis = np.frombuffer(of_basis).reshape(len(rows), -1)
    projector = np.eye(len(rows)) - basis @ basis.T
    units = {id(form.unit): form.unit for form in forms}
    covariance = np.stack(list(units.values()))[:, rows[:, np.newaxis], rows]
    values, vectors = np.linalg.eigh(projector @ covariance @ projector)
    values.flags.writeable = vectors.flags.writeable = False
    place = {key: number for number, key in enumerate(units)}
    return np.array([place[id(form.unit)] for form in forms]), values, vectors


_eigen, _eigen_of_few = lru_cache(maxsize=2)(_of_units), lru_cache(maxsize=64)(_of_units)
_FEW = 64
"""Rows of which many bases are kept: a step in one table often lies where it does in another."""


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
