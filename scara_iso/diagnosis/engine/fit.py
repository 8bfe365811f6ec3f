"""What is searched, and the effects chosen in it: fitted together, where each acts, the rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.diagnosis.engine.evidence import (
    AMPLITUDES,
    ManyPoses,
    Remainder,
    Views,
    at_amplitudes,
    build,
    constant,
    extended,
    log_bayes,
    log_bayes_of_course,
    views_of,
    wider,
)
from scara_iso.diagnosis.engine.hypotheses import Hypothesis, hypotheses_of, on_axes
from scara_iso.diagnosis.engine.places import JOINTS, Located, Place, locate, places_of
from scara_iso.diagnosis.engine.residual import (
    AllPoses,
    Joints,
    Predicted,
    Residual,
    neighbours,
    residual_of,
)
from scara_iso.diagnosis.verdict import UNKNOWN
from scara_iso.effects import Chain, Effect, Form, Process, Shape, Spread, find_effects
from scara_iso.robot import Arm
from scara_iso.run import FloatArray, IntArray, Run

_SWEEPS = 20
_TINY = 1e-300
_DUST = 1e-9

TAKES_PART = 3.0
"""Bayes factor from which an axis moves with the others: at 1, one still axis in six does."""

JOINS = 100.0
"""The same of an axis on which a course shows only beside another (test_stated.py)."""

JOINTS_SHARE = 0.75
"""Share of the joints among the directions of the test of all poses (joints.py)."""
_STRONG = 3.0
"""Log Bayes factor from which an axis shows a course; the one with the largest always does."""
_MOST_FREEDOM = 0.5
"""Effective degrees of freedom of a course, of each reading: more would learn the scatter too."""


@dataclass(frozen=True, eq=False, slots=True)
class SearchProblem:
    """A residual and every hypothesis about it; ``directions`` and ``poses`` as in `views_of`.

    ``effects`` are those that the members belong to, by name; ``sigma`` (axes,) is the scatter of
    the readings where it is known beforehand, else 0. ``places`` are those where an effect may act
    that several poses show.
    """

    residual: Residual
    members: tuple[Hypothesis, ...]
    directions: Mapping[str, FloatArray] = field(default_factory=dict)
    effects: Mapping[str, Effect] = field(default_factory=dict)
    sigma: FloatArray | float = 0.0
    places: tuple[Place, ...] = ()
    poses: ManyPoses | None = None

    @property
    def rows(self) -> IntArray:
        """All rows of the residual."""
        return np.arange(len(self.residual))

    def views_of(self, values: FloatArray, basis: FloatArray) -> Views:
        """Return the views of some residuals (n, axes), ``basis`` (n, f) projected out."""
        return views_of(values, basis, self.directions, self.sigma, self.poses)


def problem_of(
    run: Run,
    predicted: Predicted | None = None,
    *,
    directions: Mapping[str, Mapping[str, float]],
    effects: tuple[Effect, ...],
    sigma: Mapping[str, float] | None = None,
) -> SearchProblem:
    """Return the problem that ``predicted`` leaves of one pose's run; see `diagnose`."""
    if len(list(run.rows_by_pose())) > 1:
        raise DataError("several poses in one diagnosis", remedy="diagnose one pose at a time")
    residual = residual_of(run, predicted)
    along = {
        name: np.array([movement.get(axis, 0.0) for axis in residual.axes])
        for name, movement in directions.items()
    }
    usable = {name: vector for name, vector in along.items() if np.any(vector)}
    members = hypotheses_of(effects, residual.conditions)
    if all(neighbours(residual)):
        members = tuple(m for m in members if not isinstance(m.form, Spread | Chain))
    wrong = [value for value in (sigma or {}).values() if not 0 < value < math.inf]
    if wrong:
        raise DataError(f"a known scatter of {wrong[0]:g}", remedy="state a positive, finite one")
    known = np.array([(sigma or {}).get(axis, 0.0) for axis in residual.axes])
    by_name = {effect.name: effect for effect in effects}
    return SearchProblem(residual, members, usable, by_name, known)


def problem_of_poses(
    test: AllPoses,
    predicted: Predicted | None = None,
    arm: Arm | None = None,
    joints_deg: Mapping[str, Joints] | None = None,
    effects: Sequence[Effect] | None = None,
    sigma: float | None = None,
) -> SearchProblem:
    """Return the search that `diagnose_poses` makes; ``predicted`` is by the test's axes."""
    catalogue = tuple(find_effects() if effects is None else effects)
    known = {name: sigma for name, one in test.axes.items() if sigma and one.unit == "mm"}
    problem = problem_of(test.run, predicted, directions={}, effects=catalogue, sigma=known)
    columns = [test.axes[name] for name in problem.residual.axes]
    places = places_of(columns, arm, joints_deg)
    lines = [place for place in places if place.tied]
    labels = list(dict.fromkeys(column.pose for column in columns))
    poses = ManyPoses(np.array([labels.index(c.pose) for c in columns]), _shares(lines))
    now = problem.residual.conditions
    conditions = replace(now, visits=test.conditions(labels).visits)
    own = hypotheses_of(catalogue, conditions, poses.of_views) if test.visits else ()
    return replace(
        problem,
        residual=replace(problem.residual, conditions=conditions),
        members=problem.members + tuple(m for m in own if m.form.of is not None),
        places=places,
        directions={place.name: place.movement[:, 0] for place in lines},
        poses=poses,
    )


def _shares(lines: Sequence[Place]) -> np.ndarray:
    """Return how much each direction counts in the test: the joints for most of it."""
    joints = np.array([place.name in JOINTS for place in lines])
    if not joints.any():
        return np.full(len(lines), 1 / max(1, len(lines)))
    others = max(1, int((~joints).sum()))
    return np.where(joints, JOINTS_SHARE / joints.sum(), (1 - JOINTS_SHARE) / others)


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

    def moved(self, coefficients: FloatArray, columns: FloatArray | None = None) -> FloatArray:
        """Return the courses (..., n, axes) of coefficients (k, axes).

        They are those of its ``columns`` unless others (..., n, k) are given.
        """
        columns = self.columns if columns is None else columns
        if self.form.of is None:
            return columns @ coefficients
        return columns[..., self.form.of[: coefficients.shape[1]]] * coefficients


class Fit(NamedTuple):
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


class HeldOut(NamedTuple):
    """Root mean square error on unseen cycles, shape (axes,): constant pose, and with effects."""

    before: FloatArray
    after: FloatArray


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


def remainder(problem: SearchProblem, terms: Sequence[Term], rows: IntArray) -> Remainder:
    """Return what ``terms`` leave of ``rows`` and what could explain it."""
    residual = problem.residual
    scale = row_scale(terms, len(residual))
    fitted = fit(terms, residual.values[rows], rows, len(residual))
    values = (residual.values - fitted.predicted)[rows] / scale[rows]
    explained = np.ptp(values, axis=0) < _DUST * np.ptp(residual.values, axis=0)
    values = np.where(explained, 0.0, values)
    basis = fitted_basis(terms, rows)
    spread = any(isinstance(term.form, Spread) for term in terms)
    members = tuple(m for m in problem.members if not (spread and isinstance(m.form, Spread)))
    length = np.maximum(np.linalg.norm(values, axis=0), 1e-300)
    still = neighbours(residual) | ~values.any(axis=0)
    return Remainder(
        rows=rows,
        cycles=len(residual),
        basis=basis,
        values=values,
        half=np.broadcast_to(residual.division / 2 / scale[rows], values.shape),
        known=np.broadcast_to(problem.sigma, values.shape[1]),
        division=np.where(still, np.nan, residual.division / length),
        views=problem.views_of(values, basis),
        members=members,
    )


def learn(problem: SearchProblem, terms: Sequence[Term], rows: IntArray) -> tuple[Term, ...]:
    """Return a term for each axis that shows a course beside ``terms`` on some rows of the run."""
    left = remainder(problem, terms, rows)
    unnamed = [m for m in left.members if m.effect == UNKNOWN]
    hypotheses = build(unnamed, rows, left.basis)
    axes = left.views.axes
    columns = left.views.columns[:, :axes]
    log_bf = at_amplitudes(hypotheses, columns)
    freedom = np.array([_freedom(m.form, rows) for m in hypotheses.members]).T
    log_bf = np.where((freedom > _MOST_FREEDOM * len(rows))[..., np.newaxis], -np.inf, log_bf)
    best = log_bf.reshape(-1, axes).argmax(axis=0)
    strength = log_bf.max(axis=(0, 1))
    found = []
    for a in range(axes):
        amplitude, i = divmod(int(best[a]), len(hypotheses.members))
        if strength[a] >= min(_STRONG, strength.max()):
            form = wider(hypotheses.members[i].form, AMPLITUDES[amplitude])
            found.append(Term(UNKNOWN, form, np.arange(axes) == a))
    return tuple(found)


def _freedom(form: object, rows: IntArray) -> FloatArray:
    """Return the effective degrees of freedom of a course, its smoother's trace, at AMPLITUDES."""
    assert isinstance(form, Process)  # noqa: S101 - of courses of unknown form only
    K = form.covariance[np.ix_(rows, rows)]
    K = K - K.mean(axis=0) - K.mean(axis=1)[:, np.newaxis] + K.mean()
    own = np.multiply.outer(AMPLITUDES, np.linalg.eigvalsh(K).clip(0.0))
    return np.asarray((own / (1.0 + own)).sum(axis=1))
