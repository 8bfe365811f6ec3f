"""Find effects one after another: test, choose, fit, test what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from scara_iso.diagnosis.fit import Term, located_term, spread_term, term_of
from scara_iso.diagnosis.likelihood.evidence import Views
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build
from scara_iso.diagnosis.likelihood.two_state import Emissions, emissions_of
from scara_iso.diagnosis.naming.choice import Choice, choose, two_states
from scara_iso.diagnosis.naming.off_the_grid import (
    pairs,
    refined,
    refined_courses,
    refined_members,
    with_levels,
)
from scara_iso.diagnosis.problem import (
    Remainder,
    SearchProblem,
    neighbours,
    remainder,
    without_misfit,
)
from scara_iso.diagnosis.residual import Residual
from scara_iso.diagnosis.significance.marginal import MarginalTests, marginal_tests, odd_rows
from scara_iso.diagnosis.significance.permutation import OrderTest, order_statistic, order_test
from scara_iso.diagnosis.tuning import (
    AS_OFTEN_ODD,
    FEWEST_ON_A_LEVEL,
    FURTHER_LEVEL,
    GROSS,
    HEAVY_TAILS,
    LEVEL,
    MOST_EFFECTS,
    ODD,
    ORDER_SHARE,
    OUTLIER_SHARE,
    TWO_LEVELS_SHARE,
    UNKNOWN,
)
from scara_iso.effects import Chain, Form, Process, Shape, Spread
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """One round: the tests, and what was chosen (None where the tests were quiet)."""

    order: OrderTest
    marginal: MarginalTests
    choice: Choice[Form] | None
    limit: float = -np.inf
    """What the statistic of the order had to reach; -inf where another test has decided."""
    misfit: float = 0.0
    """Share of their size by which the slow courses before differ from their equations."""

    @property
    def p_value(self) -> float:
        """Smallest of the p-values, each divided by its share of the level."""
        return min(1.0, *_shared(self.order, self.marginal))

    @property
    def p_value_at_floor(self) -> bool:
        """Whether the test of the smallest p-value met nothing as far from scatter by chance."""
        found, floor = self.marginal, self.marginal.floor
        at_floor = (self.order.at_floor, found.two_levels <= floor, found.outlier <= floor)
        return min(zip(_shared(self.order, self.marginal), at_floor, strict=True))[1]


def _shared(order: OrderTest, marginal: MarginalTests) -> tuple[float, float, float]:
    return (
        order.p_value / ORDER_SHARE,
        marginal.two_levels / TWO_LEVELS_SHARE,
        marginal.outlier / OUTLIER_SHARE,
    )


def find(
    problem: SearchProblem, rng: np.random.Generator, *, level: float = LEVEL
) -> tuple[tuple[Term, ...], tuple[Stage, ...]]:
    """Return the terms found in the residual and every stage of the search.

    ``level`` is that of the first effect; a further one needs FURTHER_LEVEL.

    The last stage has no choice, or chose the unknown, or MOST_EFFECTS were reached.
    """
    terms: tuple[Term, ...] = ()
    stages: list[Stage] = []
    while True:
        stage, left = chosen(problem, terms, rng, min(level, FURTHER_LEVEL) if terms else level)
        stages.append(stage)
        full = len(terms) == MOST_EFFECTS
        if stage.choice is None or stage.choice.best == UNKNOWN or full:
            return terms, tuple(stages)
        terms = (*terms, _term(problem, stage.choice.best, stage.choice, left))
        if isinstance(terms[-1].form, Process):  # a random course explains any further order
            return terms, tuple(stages)


def find_again(
    problem: SearchProblem,
    rows: IntArray,
    count: int,
    *,
    hidden: int,
    log_changes: Sequence[Mapping[str, float]] = (),
    limits: Sequence[float] = (),
) -> tuple[Term, ...]:
    """Return up to ``count`` terms chosen anew on some rows, as the search of the run chose them.

    It ends where the statistic of the order is below that of the ``limits`` which the run's own
    orders set for each round: a fold that would not have found the effect has none. The misfit of
    slow courses is taken off, as there.
    What dial and tails change in each effect's evidence is taken over from its choices, as
    ``log_changes``. The unknown cannot be added to a model, so the likeliest effect is taken beside
    it. Hidden states are sought until ``hidden`` effects that have them are found.
    """
    terms: tuple[Term, ...] = ()
    for i in range(count):
        left, _ = without_misfit(problem, terms, remainder(problem, terms, rows))
        if i < len(limits) and not _reaches(problem, terms, left, limits[i]):
            return terms
        named = [m for m in left.members if m.named and not _unknown_shape(m)]
        changed = log_changes[i] if i < len(log_changes) else {}
        chained = {member.effect for member in left.members if member.hidden}
        wanted = sum(term.effect in chained for term in terms) < hidden
        choice = _choice(problem, left, named, changed, with_chains=wanted)
        likely = {name: p for name, p in choice.probability.items() if name != UNKNOWN}
        if not likely:
            return terms
        term = _term(problem, max(likely, key=likely.__getitem__), choice, left)
        terms = (*terms, replace(term, form=_undecided(term, left)))
    return terms


def _unknown_shape(member: Hypothesis) -> bool:
    return member.effect == UNKNOWN and isinstance(member.form, Shape)


def _undecided(term: Term, left: Remainder) -> Form:
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


def tested(problem: SearchProblem, terms: Sequence[Term], rng: np.random.Generator) -> Stage:
    """Return both tests of what ``terms`` leave, and no choice yet."""
    return _tests(problem, terms, remainder(problem, terms, problem.rows), rng)


def _tests(
    problem: SearchProblem, terms: Sequence[Term], left: Remainder, rng: np.random.Generator
) -> Stage:
    hypotheses, views, emissions, spreading = in_order(problem, terms, left)
    order = order_test(
        hypotheses, views, rng, emissions=emissions, spreading=spreading, further=bool(terms)
    )
    decided = order.p_value / ORDER_SHARE * TWO_LEVELS_SHARE
    marginal = marginal_tests(left.values, problem.residual.division, rng, levels_below=decided)
    return Stage(order, marginal, None)


def in_order(
    problem: SearchProblem, terms: Sequence[Term], left: Remainder
) -> tuple[HypothesisSet, Views, Emissions | None, FloatArray]:
    """Return what the test of the order compares."""
    ordered = [member for member in left.members if member.ordered]
    calm = _drawn_in(left)
    emissions = None if terms else _emissions(replace(problem.residual, values=calm), ordered)
    spreading = left.values[:, ~neighbours(problem.residual)]
    return left.hypotheses.of(ordered), problem.views_of(calm, left.basis), emissions, spreading


def _reaches(problem: SearchProblem, terms: Sequence[Term], left: Remainder, limit: float) -> bool:
    """Return whether the statistic of the order of what is left on some rows reaches ``limit``.

    What comes from outside the set only adds to it.
    """
    hypotheses, views, emissions, spreading = in_order(problem, terms, left)
    alone = order_statistic(hypotheses, views)
    return alone >= limit or order_statistic(hypotheses, views, emissions, spreading) >= limit


def _drawn_in(left: Remainder) -> FloatArray:
    """Return the residuals with gross ones drawn in, so that none hides an order of the others.

    The limit does not depend on the order of the cycles, so the test stays exact.
    """
    middle = median(left.values, axis=0)
    robust = 1.4826 * median(np.abs(left.values - middle), axis=0)
    limit = GROSS * np.maximum(robust, 2 * left.readings.half.max(axis=0))
    limit = np.where(robust > 0, limit, np.inf)
    return np.clip(left.values, middle - limit, middle + limit)


def chosen(
    problem: SearchProblem, terms: Sequence[Term], rng: np.random.Generator, level: float = LEVEL
) -> tuple[Stage, Remainder]:
    """Return the tests of what ``terms`` leave, and the choice where they pass ``level``."""
    left = remainder(problem, terms, problem.rows)
    stage = _tests(problem, terms, left, rng)
    if stage.p_value <= level:
        left, misfit = without_misfit(problem, terms, left)
        if misfit:
            stage = replace(_tests(problem, terms, left, rng), misfit=misfit)
    by_order, by_levels, by_outlier = _shared(stage.order, stage.marginal)
    if stage.p_value <= level:
        limit = stage.order.limit(level * ORDER_SHARE) if by_order <= level else -np.inf
        named = [member for member in left.members if member.named]
        choice = _choice(problem, left, named, with_chains=True, of_two=by_outlier <= level)
        if by_outlier <= level and ODD in problem.effects:
            alone = min(by_order, by_levels) > level
            choice = _with_odd(problem, left, stage.marginal, choice, alone=alone)
        stage = replace(stage, choice=choice, limit=limit)
    return stage, left


def _with_odd(
    problem: SearchProblem,
    left: Remainder,
    found: MarginalTests,
    choice: Choice[Form],
    *,
    alone: bool,
) -> Choice[Form]:
    """Return a choice of all odd readings at once where it is an outlier, or nothing else is there.

    ``alone`` says whether only the test of outliers has found anything: what else they may be is
    scatter with heavy tails.
    """
    if not alone and choice.best != ODD:
        return choice
    far = np.flatnonzero(found.of_axes <= LEVEL * OUTLIER_SHARE)
    own = [odd_rows(left.values[:, a]) for a in far] or [np.array([found.outlier_row])]
    rows = left.rows[list(dict.fromkeys(np.concatenate(own).tolist()))]
    cycle = problem.residual.conditions.cycle
    columns = (np.arange(len(cycle))[:, np.newaxis] == rows).astype(np.float64)
    forms = {**choice.forms, ODD: Shape(columns, {"at_cycle": cycle[rows[0]].item()})}
    if not alone:
        return replace(choice, forms=forms)
    odd = max(0.5, AS_OFTEN_ODD / (AS_OFTEN_ODD + found.heavy_tailed))
    return Choice({ODD: odd, HEAVY_TAILS: 1 - odd}, forms, choice.log_change)


def _emissions(residual: Residual, members: Sequence[Hypothesis]) -> Emissions | None:
    """Return the two states of the axes that can show them, if those of some effect persist."""
    chains = [member.form for member in members if isinstance(member.form, Chain)]
    persistent = [chain for chain in chains if chain.leave_lower + chain.leave_upper < 1]
    shown = ~neighbours(residual)
    if not persistent or not shown.any() or len(residual) < 2 * FEWEST_ON_A_LEVEL:
        return None
    return emissions_of(residual.values[:, shown], residual.division[shown], persistent)


def _choice(
    problem: SearchProblem,
    left: Remainder,
    named: Sequence[Hypothesis],
    log_change: Mapping[str, float] | None = None,
    *,
    with_chains: bool,
    of_two: bool = False,
) -> Choice[Form]:
    """Return the likeliest of ``named``; ``log_change`` of the whole run's choice on its rows.

    Two effects at once are weighed beside one where a course of no name, or a random one, would win
    or where ``of_two`` says so: an odd reading may have company.
    """
    chains = [member for member in left.members if member.hidden] if with_chains else []
    residual = problem.residual
    length = np.maximum(np.linalg.norm(left.values, axis=0), 1e-300)
    coarse = neighbours(residual)
    division = np.where(coarse | ~left.values.any(axis=0), np.nan, residual.division / length)
    hidden = two_states(
        chains, left.views, left.basis, division=division, rows=left.rows, n=len(residual)
    )
    hypotheses = left.hypotheses.of(named)
    readings = None
    if log_change is None:
        hypotheses, readings = with_levels(hypotheses, left, len(residual)), left.readings
    finer = partial(refined_courses, problem, left)
    choice = choose(hypotheses, left.views, hidden, readings, log_change, finer)
    named_course = choice.best != UNKNOWN and not isinstance(choice.forms[choice.best], Process)
    if named_course and not of_two:
        return choice
    both = pairs(hypotheses, left.views, left.rows)
    finer_ones = refined_members(problem, choice.forms, hypotheses.members)
    hypotheses = build([*hypotheses.members, *finer_ones], left.rows, left.basis)
    return choose(hypotheses, left.views, [*hidden, *both], readings, log_change, finer)


def _term(problem: SearchProblem, name: str, choice: Choice[Form], left: Remainder) -> Term:
    form = refined(problem, name, choice.forms[name], left)
    if isinstance(form, Spread):
        return spread_term(name, form, left.values, left.rows)
    if problem.poses is not None and isinstance(form, Shape) and name != ODD:
        data = (left.values, left.rows, left.basis)
        return located_term(name, form, *data, problem.places, problem.poses.of)
    return term_of(name, form, left.values, left.rows, left.basis)
