"""What the search is about: a residual, the hypotheses on it, and what fitted terms leave."""

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
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build
from scara_iso.diagnosis.likelihood.on_dial import DialReadings
from scara_iso.diagnosis.places import Place
from scara_iso.diagnosis.residual import Predicted, Residual, residual_of
from scara_iso.diagnosis.tuning import NEIGHBOURS
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
