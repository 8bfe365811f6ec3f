"""Find effects one after another: test, choose, fit, test what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.diagnosis.bank import UNKNOWN, Form, Member
from scara_iso.diagnosis.choice import Choice, choose, hidden_sides
from scara_iso.diagnosis.evidence import log_bayes
from scara_iso.diagnosis.fit import Term, spread_term, term_of
from scara_iso.diagnosis.levels import Sides, sides_of
from scara_iso.diagnosis.order_free import OrderFreeTest, order_free_test
from scara_iso.diagnosis.pairs import pairs
from scara_iso.diagnosis.permutation import OrderTest, order_test
from scara_iso.diagnosis.problem import Look, Problem, look, neighbours
from scara_iso.diagnosis.residual import Residual
from scara_iso.effects import Chain, Process, Shape, Spread
from scara_iso.run import IntArray

LEVEL = 0.05
"""Family-wise level at which a first effect is admitted."""

FURTHER_LEVEL = 0.01
"""Level at which a further one is."""

_ORDER_SHARE, _TWO_LEVELS_SHARE, _OUTLIER_SHARE = 0.95, 0.15, 0.1
"""How much of the level each test may use. What trips one order-free test (skewed scatter the two
levels, heavy tails the outlier) hardly ever trips the other, and Gaussian scatter trips neither,
so no scatter uses up more than about the whole."""

FLAG_LEVEL = 0.01
"""Level of a flagged reading in Gaussian scatter."""
MOST_EFFECTS = 3


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """One round: the tests, and what was chosen (None where the tests were quiet)."""

    order: OrderTest
    order_free: OrderFreeTest
    choice: Choice | None

    @property
    def p_value(self) -> float:
        """Smallest of the p-values, each divided by its share of the level."""
        return min(1.0, *_shared(self.order, self.order_free))

    @property
    def p_value_at_floor(self) -> bool:
        """Whether the test of the smallest p-value met nothing as far from scatter by chance."""
        free = self.order_free
        at_floor = (self.order.at_floor, free.two_levels <= free.floor, free.outlier <= free.floor)
        return min(zip(_shared(self.order, free), at_floor, strict=True))[1]


def _shared(order: OrderTest, free: OrderFreeTest) -> tuple[float, float, float]:
    return (
        order.p_value / _ORDER_SHARE,
        free.two_levels / _TWO_LEVELS_SHARE,
        free.outlier / _OUTLIER_SHARE,
    )


def find(
    problem: Problem, rng: np.random.Generator, *, level: float = LEVEL
) -> tuple[tuple[Term, ...], tuple[Stage, ...]]:
    """Return the terms found in the residual and every stage of the search.

    ``level`` is that of the first effect; a further one needs FURTHER_LEVEL.

    The last stage has no choice, or chose the unknown, or MOST_EFFECTS were reached.
    """
    terms: tuple[Term, ...] = ()
    stages: list[Stage] = []
    while True:
        stage, now = chosen(problem, terms, rng, min(level, FURTHER_LEVEL) if terms else level)
        stages.append(stage)
        full = len(terms) == MOST_EFFECTS
        if stage.choice is None or stage.choice.best == UNKNOWN or full:
            return terms, tuple(stages)
        terms = (*terms, _term(problem, stage.choice.best, stage.choice, now))
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
        now = replace(now, members=tuple(m for m in now.members if not _unknown_shape(m)))
        choice = _choice(problem, now, with_chains=with_chains)
        named = {name: p for name, p in choice.probability.items() if name != UNKNOWN}
        if not named:
            return terms
        term = _term(problem, max(named, key=named.__getitem__), choice, now)
        terms = (*terms, replace(term, form=_undecided(term, now)))
    return terms


def _unknown_shape(member: Member) -> bool:
    return member.effect == UNKNOWN and isinstance(member.form, Shape)


def _undecided(term: Term, now: Look) -> Form:
    """Return the mean of all forms that do not differ on the rows looked at.

    Where a step lies between two seen cycles, those between them are half way.
    """
    if not isinstance(term.form, Shape):
        return term.form
    seen = term.form.columns[now.rows]
    alike = [
        member.form.columns
        for member in now.members
        if member.effect == term.effect
        and isinstance(member.form, Shape)
        and np.array_equal(member.form.columns[now.rows], seen)
    ]
    return replace(term.form, columns=np.mean(alike, axis=0)) if alike else term.form


def tested(problem: Problem, terms: Sequence[Term], rng: np.random.Generator) -> Stage:
    """Return both tests of what ``terms`` leave, and no choice yet."""
    return _tests(problem, terms, look(problem, terms, problem.rows), rng)


def _tests(problem: Problem, terms: Sequence[Term], now: Look, rng: np.random.Generator) -> Stage:
    ordered = [member for member in now.members if member.ordered]
    sides = [] if terms else _sides(problem.residual, ordered)
    bank = now.bank(problem.residual.conditions.cycle, ordered)
    order = order_test(bank, now.views, rng, sides=sides)
    return Stage(order, order_free_test(now.values, problem.residual.division, rng), None)


def chosen(
    problem: Problem, terms: Sequence[Term], rng: np.random.Generator, level: float = LEVEL
) -> tuple[Stage, Look]:
    """Return the tests of what ``terms`` leave, and the choice where they pass ``level``."""
    now = look(problem, terms, problem.rows)
    stage = _tests(problem, terms, now, rng)
    by_order, by_levels, by_outlier = _shared(stage.order, stage.order_free)
    if min(by_order, by_levels) <= level:
        stage = replace(stage, choice=_choice(problem, now, with_chains=True))
    elif by_outlier <= level:
        stage = replace(stage, choice=_outlier(problem, stage.order_free))
    return stage, now


def _sides(residual: Residual, members: Sequence[Member]) -> list[Sides]:
    """Return the sides of contact on each axis that can show two, if some effect has any."""
    chains = [member.form for member in members if isinstance(member.form, Chain)]
    sticky = [chain for chain in chains if chain.leave_lower + chain.leave_upper < 1]
    return [
        sides_of(residual.values[:, a], residual.division[a], sticky)
        for a in np.flatnonzero(~neighbours(residual))
        if sticky
    ]


def _choice(problem: Problem, now: Look, *, with_chains: bool) -> Choice:
    chains = [member for member in now.members if member.chained] if with_chains else []
    named = [member for member in now.members if member.named]
    residual = problem.residual
    length = np.maximum(np.linalg.norm(now.values, axis=0), 1e-300)
    coarse = neighbours(residual)
    division = np.where(coarse | ~now.values.any(axis=0), np.nan, residual.division / length)
    sides = hidden_sides(
        chains, now.views, now.basis, division=division, rows=now.rows, n=len(residual)
    )
    cycle = residual.conditions.cycle
    bank = now.bank(cycle, named)
    choice = choose(bank, now.views, sides)
    if choice.best != UNKNOWN and not isinstance(choice.forms[choice.best], Process):
        return choice
    return choose(bank, now.views, [*sides, *pairs(bank, now.views, cycle, now.rows)])


def _outlier(problem: Problem, free: OrderFreeTest) -> Choice:
    alone = np.zeros((len(problem.residual), 1))
    alone[free.outlier_row] = 1.0
    cycle = int(problem.residual.conditions.cycle[free.outlier_row])
    return Choice({"outlier": 1.0}, {"outlier": Shape(alone, {"at_cycle": cycle})})


def _term(problem: Problem, name: str, choice: Choice, now: Look) -> Term:
    form = _refined(problem, name, choice.forms[name], now)
    if isinstance(form, Spread):
        return spread_term(name, form, now.values, problem.residual.conditions.cycle[now.rows])
    return term_of(name, form, now.values, now.rows, now.basis)


def _refined(problem: Problem, name: str, form: Form, now: Look) -> Form:
    """Return the likeliest of the shapes near ``form``, where its effect knows nearer ones."""
    if name not in problem.effects or not isinstance(form, Shape):
        return form
    numbers = {key: value for key, value in form.parameters.items() if not isinstance(value, str)}
    near = problem.effects[name].nearby(problem.residual.conditions, numbers)
    if not near:
        return form
    cycle = problem.residual.conditions.cycle
    bank = now.bank(cycle, [Member(name, shape, 1.0) for shape in near])
    log_bf = log_bayes(bank, now.views.columns[:, : now.views.axes])
    return bank.members[int(np.argmax(log_bf.sum(axis=1)))].form
