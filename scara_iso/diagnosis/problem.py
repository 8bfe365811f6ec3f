"""What the search is about: a residual, the hypotheses on it, and what fitted terms leave.

No machine follows an equation to the last digit: one that warms up has several time constants, and
what one exponential leaves of it has an order. That is no second effect: it lies among the effect's
own courses, and is small beside the first. It is taken off before more is sought, and is said as
misfit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.diagnosis.fit import Term, fit, fitted_basis, row_scale
from scara_iso.diagnosis.likelihood.evidence import ManyPoses, Views, views_of
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build, extended
from scara_iso.diagnosis.likelihood.on_dial import DialReadings
from scara_iso.diagnosis.places import Place
from scara_iso.diagnosis.residual import Predicted, Residual, residual_of
from scara_iso.diagnosis.tuning import (
    LEAST_OF_COURSES,
    MISFIT_BY_CHANCE,
    MISFIT_COURSES,
    MISFIT_LIKE,
    MOST_MISFIT,
    NEIGHBOURS,
)
from scara_iso.effects import Chain, Effect, Shape, Spread
from scara_iso.run import FloatArray, IntArray, Run

_DUST = 1e-9
_OUT_OF_REACH = 0.01


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
    sigma: FloatArray | None = None
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
    known_effects = {effect.name: effect for effect in effects}
    members = _in_reach(hypotheses_of(effects, residual.conditions), known_effects, residual)
    if all(neighbours(residual)):
        members = tuple(m for m in members if not isinstance(m.form, Spread | Chain))
    wrong = [value for value in (sigma or {}).values() if not 0 < value < math.inf]
    if wrong:
        raise DataError(f"a known scatter of {wrong[0]:g}", remedy="state a positive, finite one")
    known = np.array([(sigma or {}).get(axis, 0.0) for axis in residual.axes])
    return SearchProblem(residual, members, usable, known_effects, known)


def _in_reach(
    members: Sequence[Hypothesis], effects: Mapping[str, Effect], residual: Residual
) -> tuple[Hypothesis, ...]:
    """Return the members, less likely the farther their size is beyond what their effect reaches.

    Far beyond it they are left out.
    """
    found = []
    for member in members:
        effect = effects.get(member.effect)
        likely = 1.0 if effect is None else _reached(member, effect, residual)
        if likely > _OUT_OF_REACH:
            weight = member.weight * likely
            found.append(member if likely == 1 else replace(member, weight=weight))
    return tuple(found)


def _reached(member: Hypothesis, effect: Effect, residual: Residual) -> float:
    if effect.reach == math.inf or not isinstance(member.form, Shape):
        return 1.0
    design = np.concatenate([np.ones((len(residual), 1)), member.form.columns], axis=1)
    size = np.abs(np.linalg.lstsq(design, residual.values, rcond=1e-9)[0][1])
    reach = effect.reach * residual.division
    farthest = max((s / r for s, r in zip(size, reach, strict=True) if r), default=0.0)
    return math.exp(-(farthest**2) / 2)


def neighbours(residual: Residual) -> npt.NDArray[np.bool_]:
    """Return which axes show at most three neighbouring divisions, shape (axes,).

    Rounding alone makes such readings look like two states, or like a changing scatter.
    """
    return np.asarray(np.ptp(residual.values, axis=0) < NEIGHBOURS * residual.division)


@dataclass(frozen=True, eq=False)
class Remainder:
    """What fitted terms leave: residual values (rows, axes), their views, what is fitted.

    ``members`` are the hypotheses that are still open.
    """

    rows: IntArray
    basis: FloatArray
    views: Views
    values: FloatArray
    readings: DialReadings
    members: tuple[Hypothesis, ...]

    @cached_property
    def hypotheses(self) -> HypothesisSet:
        """The set of all members beside what is fitted."""
        return build(self.members, self.rows, self.basis)


def remainder(problem: SearchProblem, terms: Sequence[Term], rows: IntArray) -> Remainder:
    """Return what ``terms`` leave of ``rows`` and what could explain it."""
    residual = problem.residual
    scale = row_scale(terms, len(residual))
    fitted = fit(terms, residual.values[rows], rows, len(residual))
    values = _without_dust((residual.values - fitted.predicted)[rows] / scale[rows], residual)
    basis = fitted_basis(terms, rows)
    spread = any(isinstance(term.form, Spread) for term in terms)
    members = tuple(m for m in problem.members if not (spread and isinstance(m.form, Spread)))
    half = np.broadcast_to(residual.division / 2 / scale[rows], values.shape)
    known = np.zeros(values.shape[1]) if problem.sigma is None else problem.sigma
    views = problem.views_of(values, basis)
    return Remainder(rows, basis, views, values, DialReadings(values, half, known), members)


def _without_dust(values: FloatArray, residual: Residual) -> FloatArray:
    """Return values with 0 for an axis that the terms explain to the last digit."""
    explained = np.ptp(values, axis=0) < _DUST * np.ptp(residual.values, axis=0)
    return np.where(explained, 0.0, values)


def without_misfit(
    problem: SearchProblem, terms: Sequence[Term], left: Remainder
) -> tuple[Remainder, float]:
    """Return what is left beside the misfit of slow ``terms``, and its share of their size.

    The share is 0, and nothing is taken off, where no term is slow, where no more is left along
    courses like theirs than by chance, or more than a misfit may be.
    """
    slow = [
        (term.effect, term.form.columns[left.rows])
        for term in terms
        if isinstance(term.form, Shape) and is_slow(problem, term)
    ]
    if not slow:
        return left, 0.0
    courses = [_own_courses(effect, found, left) for effect, found in slow]
    basis = extended(left.basis, np.concatenate(courses, axis=1))
    own = basis[:, left.basis.shape[1] :]
    part = own @ (own.T @ left.values)
    beyond = left.values - part
    free = max(1, len(own) - basis.shape[1])
    by_chance = MISFIT_BY_CHANCE * own.shape[1] * (beyond**2).sum(axis=0) / free
    share = _share(problem.residual.values[left.rows], left.values, part, by_chance)
    if not share:
        return left, 0.0
    readings = replace(left.readings, values=beyond)
    views = problem.views_of(beyond, basis)
    return replace(left, basis=basis, values=beyond, readings=readings, views=views), share


def is_slow(problem: SearchProblem, term: Term) -> bool:
    """Return whether a term moves smoothly, by one course: a sine of another phase is no misfit."""
    effect, form = problem.effects.get(term.effect), term.form
    smooth = effect is not None and effect.smooth
    return smooth and isinstance(form, Shape) and form.columns.shape[1] == 1


def _own_courses(effect: str, found: FloatArray, left: Remainder) -> FloatArray:
    """Return the few courses (rows, k) of which the effect's forms like ``found`` are mixtures."""
    forms = [m.form for m in left.members if m.effect == effect and isinstance(m.form, Shape)]
    columns = [form.columns[left.rows] for form in forms if form.columns.shape[1] == 1]
    courses = np.concatenate([found, *columns], axis=1)
    courses -= courses.mean(axis=0)
    courses /= np.maximum(np.linalg.norm(courses, axis=0), 1e-300)
    alike = courses[:, np.abs(courses[:, 0] @ courses) > MISFIT_LIKE]
    free = alike - left.basis @ (left.basis.T @ alike)
    vectors, sizes, _ = np.linalg.svd(free, full_matrices=False)
    return vectors[:, sizes > LEAST_OF_COURSES * sizes.max(initial=0.0)][:, :MISFIT_COURSES]


def _share(values: FloatArray, left: FloatArray, part: FloatArray, by_chance: FloatArray) -> float:
    """Return the size of ``part`` over that of the terms on the axis (axes,) that they move most.

    0 where it is within ``by_chance``, or on any axis more than a misfit may be.
    """
    whole = ((values - values.mean(axis=0) - left) ** 2).sum(axis=0)
    squares, most = (part**2).sum(axis=0), int(whole.argmax())
    too_large = np.any(squares > MOST_MISFIT**2 * whole + by_chance)
    small = squares[most] <= by_chance[most]
    return 0.0 if too_large or small else float(np.sqrt(squares[most] / whole[most]))
