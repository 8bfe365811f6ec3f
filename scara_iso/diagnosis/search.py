"""Find effects one after another: test, choose, fit, test what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from scara_iso.diagnosis.bank import UNKNOWN, Bank, Member, build, members_of
from scara_iso.diagnosis.choice import Choice, choose, hidden_sides
from scara_iso.diagnosis.evidence import Views, views_of
from scara_iso.diagnosis.fit import Term, fit, fitted_basis, row_scale, term_of
from scara_iso.diagnosis.order_free import OrderFreeTest, order_free_test
from scara_iso.diagnosis.permutation import OrderTest, order_test
from scara_iso.diagnosis.residual import Prediction, Residual, residual_of
from scara_iso.effects import Chain, Effect, Process, Shape
from scara_iso.errors import DataError
from scara_iso.run import FloatArray, IntArray, Run

ORDER_LEVEL = 0.04
ORDER_FREE_LEVEL = 0.01
"""Together 5 % for the first effect: scatter of any one family trips one order-free test only."""

FURTHER_LEVEL = 0.01
MOST_EFFECTS = 3
_DUST = 1e-9
_ADJACENT = 2.5
"""Readings within fewer divisions than this are neighbours on the dial: no proof of two sides."""


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """A residual and every hypothesis about it; ``directions`` as in `views_of`."""

    residual: Residual
    members: tuple[Member, ...]
    directions: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def rows(self) -> IntArray:
        """All rows of the residual."""
        return np.arange(len(self.residual))


def problem_of(
    run: Run,
    predicted: Prediction | None = None,
    *,
    directions: Mapping[str, Mapping[str, float]],
    effects: tuple[Effect, ...],
) -> Problem:
    """Return the problem that ``predicted`` leaves of one pose's run; see `diagnose`."""
    if len(list(run.rows_by_pose())) > 1:
        raise DataError("several poses in one diagnosis", remedy="diagnose one pose at a time")
    residual = residual_of(run, predicted)
    along = {
        name: np.array([movement.get(axis, 0.0) for axis in residual.axes])
        for name, movement in directions.items()
    }
    usable = {name: vector for name, vector in along.items() if np.any(vector)}
    return Problem(residual, members_of(effects, residual.conditions), usable)


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """One look at what is left: bank, views and residual values (rows, axes) beside ``terms``."""

    rows: IntArray
    bank: Bank
    views: Views
    values: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """One round: the tests, and what was chosen (None where the tests were quiet)."""

    order: OrderTest
    order_free: OrderFreeTest
    level: float
    choice: Choice | None

    @property
    def p_value(self) -> float:
        """Smallest p-value of the round."""
        return min(self.order.p_value, self.order_free.two_levels, self.order_free.outlier)


def look(problem: Problem, terms: Sequence[Term], rows: IntArray) -> Look:
    """Return what ``terms`` leave of ``rows`` and the bank of what could explain it."""
    residual = problem.residual
    scale = row_scale(terms, residual.conditions.cycle)
    fitted = fit(terms, residual.values[rows], rows, len(residual))
    values = _without_dust((residual.values - fitted.predicted)[rows] / scale[rows], residual)
    basis = fitted_basis(terms, rows)
    bank = build(problem.members, residual.conditions.cycle, rows, basis)
    return Look(rows, bank, views_of(values, basis, problem.directions), values)


def _without_dust(values: FloatArray, residual: Residual) -> FloatArray:
    """Return values with 0 for an axis that the terms explain to the last digit."""
    explained = np.ptp(values, axis=0) < _DUST * np.ptp(residual.values, axis=0)
    return np.where(explained, 0.0, values)


def find(problem: Problem, rng: np.random.Generator) -> tuple[tuple[Term, ...], tuple[Stage, ...]]:
    """Return the terms found in the residual and every stage of the search.

    The last stage has no choice, or chose the unknown, or MOST_EFFECTS were reached.
    """
    terms: tuple[Term, ...] = ()
    stages: list[Stage] = []
    while True:
        stage, now = _stage(problem, terms, rng)
        stages.append(stage)
        full = len(terms) == MOST_EFFECTS
        if stage.choice is None or stage.choice.best == UNKNOWN or full:
            return terms, tuple(stages)
        terms = (*terms, _term(stage.choice.best, stage.choice, now))
        if isinstance(terms[-1].form, Process):  # a random course explains any further order
            return terms, tuple(stages)


def find_again(
    problem: Problem, rows: IntArray, count: int, *, with_chains: bool
) -> tuple[Term, ...]:
    """Return ``count`` terms chosen anew on some rows, as the search of the whole run chose them.

    The unknown cannot be added to a model, so the likeliest effect is taken beside it.
    """
    terms: tuple[Term, ...] = ()
    for _ in range(count):
        now = look(problem, terms, rows)
        choice = _choice(problem, now, with_chains=with_chains)
        named = {name: p for name, p in choice.probability.items() if name != UNKNOWN}
        if not named:
            return terms
        terms = (*terms, _term(max(named, key=named.__getitem__), choice, now))
    return terms


def _stage(problem: Problem, terms: Sequence[Term], rng: np.random.Generator) -> tuple[Stage, Look]:
    now = look(problem, terms, problem.rows)
    first = not terms
    level = ORDER_LEVEL if first else FURTHER_LEVEL
    order = order_test(now.bank, now.views, rng)
    free = order_free_test(now.values, problem.residual.division, rng)
    free_level = ORDER_FREE_LEVEL if first else ORDER_FREE_LEVEL / 4
    ordered = order.p_value <= level
    if ordered or free.two_levels <= free_level:
        choice = _choice(problem, now, with_chains=True)
    elif free.outlier <= free_level:
        choice = _outlier(problem, free)
    else:
        choice = None
    return Stage(order, free, level, choice), now


def _choice(problem: Problem, now: Look, *, with_chains: bool) -> Choice:
    chains = [m for m in problem.members if isinstance(m.form, Chain)] if with_chains else []
    residual = problem.residual
    length = np.maximum(np.linalg.norm(now.values, axis=0), 1e-300)
    coarse = np.ptp(residual.values, axis=0) < _ADJACENT * residual.division
    division = np.where(coarse | ~now.values.any(axis=0), np.nan, residual.division / length)
    sides = hidden_sides(chains, now.views, division, now.rows, len(residual))
    return choose(now.bank, now.views, sides)


def _outlier(problem: Problem, free: OrderFreeTest) -> Choice:
    alone = np.zeros((len(problem.residual), 1))
    alone[free.outlier_row] = 1.0
    cycle = int(problem.residual.conditions.cycle[free.outlier_row])
    return Choice({"outlier": 1.0}, {"outlier": Shape(alone, {"at_cycle": cycle})})


def _term(name: str, choice: Choice, now: Look) -> Term:
    return term_of(name, choice.forms[name], now.values, now.rows, now.bank.basis)
