"""Fit chosen effects together: which axes each moves, by how much, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.evidence import log_bayes, log_bayes_of_course
from scara_iso.diagnosis.hypotheses import Hypothesis, build, constant, extended, on_axes
from scara_iso.diagnosis.naming import Remainder
from scara_iso.diagnosis.places import Located, Place, locate
from scara_iso.diagnosis.tuning import JOINS, TAKES_PART
from scara_iso.effects import Form, Process, Shape, Spread
from scara_iso.run import FloatArray, IntArray

_SWEEPS = 20
_TINY = 1e-300


@dataclass(frozen=True, eq=False, slots=True)
class Term:
    """One chosen effect: its form over all n cycles, and which axes (axes,) it moves."""

    effect: str
    form: Form
    moves: npt.NDArray[np.bool_]
    located: Located | None = None
    """Where in the robot it acts, of several poses."""

    @property
    def tied(self) -> bool:
        """Whether its axes move together, in proportions that its place gives."""
        return self.located is not None and self.located.place.tied

    @property
    def columns(self) -> FloatArray:
        """Columns (n, k) of a known course, else (n, 0)."""
        return self.form.columns

    def of_axis(self, a: int) -> FloatArray:
        """Return the columns (n, k) that an axis follows."""
        return self.columns if self.form.of is None else self.columns[:, [self.form.of[a]]]

    def moved(self, coefficients: FloatArray) -> FloatArray:
        """Return the courses (n, axes) of coefficients (k, axes)."""
        if self.form.of is None:
            return self.columns @ coefficients
        return self.columns[:, self.form.of[: coefficients.shape[1]]] * coefficients


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """Terms fitted together on some rows of the run.

    ``predicted`` (n, axes) holds all cycles: the pose and each term's contribution, ``parts``
    (n, axes) with ``coefficients`` (k, axes). ``wider`` (axes,) is how many times as wide scatter
    is as what is left: a random course takes part of the scatter too. ``cured`` (axes,) is the same
    of the scatter that stays once the causes of random courses are cured.
    """

    terms: tuple[Term, ...]
    predicted: FloatArray
    coefficients: tuple[FloatArray, ...]
    parts: tuple[FloatArray, ...]
    wider: FloatArray
    cured: FloatArray


def term_of(effect: str, form: Form, left: Remainder) -> Term:
    """Return the term with the axes that ``form`` moves in what is left.

    An axis takes part where its own Bayes factor speaks for it, scatter that changes where it is
    likelier with the change than without; the axis with the largest always does.
    """
    values, rows, basis = left.values, left.rows, left.basis
    needed = np.log(TAKES_PART)
    if form.of is not None:
        each = zip(form.columns[rows].T[form.of], values.T, strict=False)
        log_bf = np.concatenate(
            [log_bayes_of_course(c[:, np.newaxis], basis, y[:, np.newaxis]) for c, y in each]
        )
    elif isinstance(form, Shape):
        log_bf = log_bayes_of_course(form.columns[rows], basis, values)
    elif isinstance(form, Spread):
        log_bf, needed = _log_gain(form.scale[rows, np.newaxis], values), 0.0
    else:
        alone = build([Hypothesis(effect, form, 1.0)], rows, basis)
        log_bf = log_bayes(alone, values - basis @ (basis.T @ values)).sum(axis=0)
    return Term(effect, form, (log_bf > needed) | (log_bf == log_bf.max()))


def _log_gain(scale: FloatArray, values: FloatArray) -> FloatArray:
    left = values - values.mean(axis=0)
    as_is, even = ((r**2).mean(axis=0) + np.finfo(float).tiny for r in (left, left / scale))
    return np.asarray(len(values) / 2 * np.log(as_is / even) - np.log(scale).sum())


def log_bf_of_axes(
    term: Term, others: Sequence[Term], values: FloatArray, rows: IntArray
) -> FloatArray:
    """Return log Bayes factors (axes,) of a known course beside the courses of other terms."""
    found = np.empty(values.shape[1])
    for a in range(len(found)):
        basis = fitted_basis([one for one in others if one.moves[a]], rows)
        found[a] = log_bayes_of_course(term.of_axis(a)[rows], basis, values[:, [a]])[0]
    return found


def given_the_others(terms: Sequence[Term], values: FloatArray, rows: IntArray) -> tuple[Term, ...]:
    """Return terms with the axes that the course of each moves beside the others' courses.

    A drift that a step takes back shows on an axis only beside it. An axis that did not show it
    alone is to show it beyond doubt.
    """
    found = list(terms)
    for i, term in enumerate(terms):
        others = [one for j, one in enumerate(found) if j != i and one.columns.size]
        if term.columns.size and term.located is None and others:
            log_bf = log_bf_of_axes(term, others, values, rows)
            needed = np.log(np.where(term.moves, TAKES_PART, JOINS))
            found[i] = replace(term, moves=(log_bf > needed) | (log_bf == log_bf.max()))
    return tuple(found)


def undecided(term: Term, left: Remainder) -> Form:
    """Return the mean of all forms that do not differ on the rows that are seen.

    Where a step lies between two seen cycles, those between them are half way.
    """
    if not isinstance(term.form, Shape):
        return term.form
    seen = term.form.columns[left.rows]
    alike = [
        member.form.columns
        for member in left.members
        if member.effect == term.effect
        and isinstance(member.form, Shape)
        and np.array_equal(member.form.columns[left.rows], seen)
    ]
    return replace(term.form, columns=np.mean(alike, axis=0)) if alike else term.form


def located_term(
    effect: str, form: Shape, left: Remainder, places: Sequence[Place], poses: IntArray
) -> Term:
    """Return the term at the place where ``form`` acts; as `term_of`, of the axes of that place."""
    course = form.columns[left.rows]
    located = locate(course, left.basis, left.values, places, poses, form.of)
    there = np.asarray(located.place.movement.any(axis=1))
    if located.place.tied:
        return Term(effect, form, there, located)
    some = np.zeros_like(there)
    own = on_axes(form, np.flatnonzero(there))
    some[there] = term_of(effect, own, replace(left, values=left.values[:, there])).moves
    return Term(effect, form, some, located)


def fit(terms: Sequence[Term], values: FloatArray, rows: IntArray, n: int) -> Fit:
    """Return the least-squares fit of pose and ``terms`` to ``values`` (rows, axes).

    Random courses are smoothed (kriging) in what the other terms leave.
    """
    axes = values.shape[1]
    pose = np.empty(axes)
    coefficients = [np.zeros((term.of_axis(0).shape[1], axes)) for term in terms]
    parts = [np.zeros((n, axes)) for _ in terms]
    free = [i for i, term in enumerate(terms) if not term.tied]
    tied = [i for i, term in enumerate(terms) if term.tied]
    for _ in range(_SWEEPS if tied and len(terms) > 1 else 1):  # in turn: Buja and Hastie 1989
        for i in tied:
            others = sum((p for j, p in enumerate(parts) if j != i), np.zeros((n, axes)))
            coefficients[i] = _tied(terms[i], values - others[rows], rows)
            parts[i] = terms[i].moved(coefficients[i])
        left = values - sum((parts[i] for i in tied), np.zeros((n, axes)))[rows]
        for a in range(axes):
            pose[a] = _fit_axis(terms, free, coefficients, left[:, a], rows, a)
        for i in free:
            parts[i] = terms[i].moved(coefficients[i])
    left = values - pose - sum(parts, np.zeros((n, axes)))[rows]
    wider = cured = np.ones(axes)
    for i, term in enumerate(terms):
        if isinstance(term.form, Process):
            covariance = term.form.covariance
            among = covariance[np.ix_(rows, rows)]
            kriged = covariance[:, rows] @ np.linalg.solve(among + np.eye(len(rows)), left)
            parts[i] = kriged * term.moves
            much = _wider(among, left, parts[i][rows], fitted_basis(terms, rows))
            wider = np.where(term.moves, much, wider)
            stays = 1 + term.form.variance * term.form.stays
            cured = np.where(term.moves, much * stays**0.5, cured)
    predicted = pose + sum(parts, np.zeros((n, axes)))
    return Fit(tuple(terms), predicted, tuple(coefficients), tuple(parts), wider, cured)


def _fit_axis(
    terms: Sequence[Term],
    free: Sequence[int],
    coefficients: Sequence[FloatArray],
    values: FloatArray,
    rows: IntArray,
    a: int,
) -> float:
    """Fit the terms that move one axis of their own accord into ``coefficients``; return its pose.

    ``values`` (rows,) are those of axis ``a``.
    """
    used = [i for i in free if terms[i].moves[a]]
    columns = [terms[i].of_axis(a)[rows] for i in used]
    design = np.concatenate([np.ones((len(rows), 1)), *columns], axis=1)
    solution = np.linalg.lstsq(design, values, rcond=1e-9)[0]
    rest = solution[1:]
    for i in used:
        coefficients[i][:, a], rest = np.split(rest, [len(coefficients[i])])
    return float(solution[0])


def _tied(term: Term, values: FloatArray, rows: IntArray) -> FloatArray:
    """Return the coefficients (k, axes) of a term in its place, least squares along it."""
    assert term.located is not None  # noqa: S101
    weights, movement = term.located.weights, term.located.place.movement.T
    own = term.form.of is not None
    seen, course = values @ weights, term.moved(movement) @ weights if own else term.columns
    design = np.concatenate([np.ones((len(rows), 1)), course[rows]], axis=1)
    sizes = np.linalg.lstsq(design, seen, rcond=1e-9)[0][1:]
    return np.asarray(sizes @ movement)


def row_scale(terms: Sequence[Term], n: int) -> FloatArray:
    """Return how wide the scatter of each of n cycles is by the terms that change it.

    Its shape is (n, axes), or (n, 1) where none does.
    """
    scale = np.ones((n, 1))
    for term in terms:
        if isinstance(term.form, Spread):
            scale = scale * np.where(term.moves, term.form.scale[:, np.newaxis], 1.0)
    return scale


def fitted_basis(terms: Sequence[Term], rows: IntArray) -> FloatArray:
    """Return an orthonormal basis (rows, f) of the pose and every known course in ``terms``."""
    basis = constant(len(rows))
    for term in terms:
        basis = extended(basis, term.columns[rows])
    return basis


def _wider(
    covariance: FloatArray, left: FloatArray, course: FloatArray, basis: FloatArray
) -> FloatArray:
    """Return how many times as wide (axes,) scatter is as what a random course leaves.

    ``left`` (rows, axes) is what the known courses leave, which ``basis`` holds. The scatter is
    that of the largest restricted likelihood (Patterson and Thompson 1971).
    """
    beside = np.eye(len(basis)) - basis @ basis.T
    free, narrow = beside @ left, left - course
    even = np.linalg.solve(beside @ covariance @ beside + np.eye(len(basis)), free)
    narrow = narrow - narrow.mean(axis=0)
    squares = np.maximum((narrow**2).sum(axis=0), _TINY)
    return np.asarray(np.sqrt((free * even).sum(axis=0) / squares))
