"""Find effects one after another: test what is left, choose a name, fit, test again.

No machine follows an equation to the last digit: one that warms up has several time constants, and
what one exponential leaves of it has an order. A further course that is slow, and small beside the
slow ones before it, is no effect of its own, and is said as misfit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.diagnosis.engine.evidence import (
    HypothesisSet,
    Remainder,
    Views,
    build,
    joint_evidence,
    log_bayes,
    views_of,
)
from scara_iso.diagnosis.engine.fit import (
    SearchProblem,
    Term,
    fit,
    given_the_others,
    located_term,
    remainder,
    term_of,
    undecided,
)
from scara_iso.diagnosis.engine.hypotheses import ODD, Hypothesis, of_visits, on_axes
from scara_iso.diagnosis.engine.marginal import MarginalTests, marginal_tests, odd_rows
from scara_iso.diagnosis.engine.naming import (
    Weighed,
    choose,
    in_common,
    likeliest,
    on_levels,
    two_at_once,
    two_states,
    widest,
)
from scara_iso.diagnosis.engine.order import (
    PERMUTATIONS,
    OrderTest,
    drawn_in,
    log_statistic,
    order_test,
)
from scara_iso.diagnosis.engine.places import possible_places
from scara_iso.diagnosis.engine.residual import TWO_DIVISIONS, Residual, neighbours
from scara_iso.diagnosis.engine.two_levels import FEWEST_ON_A_LEVEL, Emissions, emissions_of
from scara_iso.diagnosis.verdict import FURTHER_LEVEL, LEVEL, UNKNOWN, Choice
from scara_iso.effects import Chain, Form, Process, Shape
from scara_iso.iso9283 import median
from scara_iso.run import IntArray

HEAVY_TAILS = "heavy_tails"
"""Name of scatter with heavier tails than the level of the tests allows for."""

AS_OFTEN_ODD = 0.04
"""An odd reading is as likely as tails which throw one as far in so large a share of tables."""

STEP = "step"
"""Name of the effect that a recorded column which changes once looks like."""

MOST_EFFECTS = 3

ORDER_SHARE, TWO_LEVELS_SHARE, OUTLIER_SHARE = 0.7, 0.15, 0.25
"""How much of the level each test of readings uses, together 1.1: what trips one marginal test
(skewed scatter the two levels, heavy tails the outlier) hardly ever trips the other, and Gaussian
scatter trips neither (ablation.py, scatter alone)."""

FINE = 8.0  # benchmarks/blind_spots.py
"""Divisions that the widest direction spreads over at least where it is tested: the lumps of coarse
dials are levels too."""

MOST_MISFIT = 0.15
"""Share of its size up to which what a smooth course leaves along courses like its own is misfit
and no further effect (mended.py, strong courses by other equations)."""

SHOWN = 20.0
"""The same of an axis that needs no unseen error to fall (ablation.py, two effects)."""

LIKELY = 0.02
"""A fold chooses among the effects that were likelier than this in the whole run."""


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """One round: the tests, and what was chosen (None where the tests were quiet)."""

    order: OrderTest
    marginal: MarginalTests
    choice: Choice | None = None
    limit: float = -np.inf
    """What the statistic of the order had to reach; -inf where another test has decided."""
    misfit: float = 0.0
    """Share of the slow courses before, by which they differ from their equations."""

    @property
    def on_levels(self) -> int:
        """Which axis lies on levels in no order, where nothing else was found; else -1."""
        by_order, by_levels, _ = self.shared
        found = self.choice is not None and by_levels < by_order
        return self.marginal.levels_axis if found else -1

    @property
    def shared(self) -> tuple[float, float, float]:
        """The p-values of order, two levels and odd readings, each over its share of the level."""
        return (
            self.order.p_value / ORDER_SHARE,
            self.marginal.two_levels / TWO_LEVELS_SHARE,
            self.marginal.outlier / OUTLIER_SHARE,
        )

    @property
    def p_value(self) -> float:
        """Smallest of the p-values, each divided by its share of the level."""
        return min(1.0, *self.shared)

    @property
    def p_value_at_floor(self) -> bool:
        """Whether the test of the smallest p-value met nothing as far from scatter by chance."""
        found, floor = self.marginal, self.marginal.floor
        at_floor = (self.order.at_floor, found.two_levels <= floor, found.outlier <= floor)
        return min(zip(self.shared, at_floor, strict=True))[1]


def find(
    problem: SearchProblem, rng: np.random.Generator, *, level: float = LEVEL
) -> tuple[tuple[Term, ...], tuple[Stage, ...]]:
    """Return the terms found in the residual and every stage of the search.

    ``level`` is that of the first effect; a further one needs FURTHER_LEVEL. The last stage has no
    choice, or chose the unknown, or there are MOST_EFFECTS, or one for each pose.
    """
    terms: tuple[Term, ...] = ()
    stages: list[Stage] = []
    most = MOST_EFFECTS if problem.poses is None else max(MOST_EFFECTS, 1 + problem.poses.of.max())
    while True:
        stage, left = chosen(problem, terms, rng, min(level, FURTHER_LEVEL) if terms else level)
        if stage.choice is None:
            stage = _at_a_further_pose(problem, left, stage, stages, rng)
        stages.append(stage)
        if stage.choice is None:
            return terms, tuple(stages)
        term = _term(problem, stage.choice.best, stage.choice, left)
        misfit = _misfit(problem, terms, term)
        if misfit:
            stages[-1] = replace(stage, choice=None, misfit=misfit)
        if misfit or term.effect == UNKNOWN or len(terms) == most:
            return terms, tuple(stages)
        terms = given_the_others((*terms, term), problem.residual.values, problem.rows)
        if isinstance(term.form, Process):  # a random course explains any further order
            return terms, tuple(stages)


def _at_a_further_pose(
    problem: SearchProblem,
    left: Remainder,
    stage: Stage,
    before: Sequence[Stage],
    rng: np.random.Generator,
) -> Stage:
    """Return the stage with the choice of a pose that shows by itself what all together hide."""
    named = {one.choice.pose for one in before if one.choice} - {None}
    of = problem.poses.of if problem.poses is not None and named else np.zeros(0, np.int64)
    others = sorted({*of.tolist()} - named)
    for pose in others:
        own = _of_axes(left, np.flatnonzero(of == pose))
        hypotheses = build([m for m in own.members if m.ordered], own.rows, own.basis)
        order = order_test(hypotheses, own.views, rng, further=True)
        if order.p_value * len(others) <= FURTHER_LEVEL * ORDER_SHARE:
            return replace(stage, order=order, choice=replace(_choice(problem, own), pose=pose))
    return stage


def _misfit(problem: SearchProblem, terms: Sequence[Term], further: Term) -> float:
    """Return the size of a slow ``further`` course over that of the slow ``terms``.

    That is on the axis where it is largest; 0 where it is more than a misfit may be.
    """
    if not any(is_slow(problem, term) for term in terms):
        return 0.0
    nameless = further.effect == UNKNOWN or isinstance(further.form, Process)
    if not is_slow(problem, further) and not nameless:
        return 0.0
    residual = problem.residual
    together = fit((*terms, further), residual.values, problem.rows, len(residual))
    *before, own = (part.std(axis=0) for part in together.parts)
    size = np.sum(before, axis=0)
    share = float(np.max(own[size > 0] / size[size > 0], initial=0.0))
    alone = bool((own[size == 0] > 0).any())
    return share if share < MOST_MISFIT and not alone else 0.0


def is_slow(problem: SearchProblem, term: Term) -> bool:
    """Return whether a term moves smoothly, by one course: a sine of another phase is no misfit."""
    effect, form = problem.effects.get(term.effect), term.form
    smooth = effect is not None and effect.smooth
    return smooth and form.columns.shape[1] == 1


def find_again(problem: SearchProblem, rows: IntArray, stages: Sequence[Stage]) -> tuple[Term, ...]:
    """Return the terms chosen anew on some rows, in as many rounds as there are ``stages``.

    It ends where the statistic of the order is below the limit which the run's own orders set for
    the round: rows that would not have shown the effect have none. In each round the choice is
    among the effects that were LIKELY in the run's; what dial and tails change in their evidence is
    taken over from there. The unknown cannot be added to a model.
    """
    terms: tuple[Term, ...] = ()
    for stage in stages:
        assert stage.choice is not None  # noqa: S101 - the stage of a term
        left = remainder(problem, terms, rows)
        hypotheses, views, emissions = in_order(problem, terms, left)
        seen = log_statistic(hypotheses, views, None, emissions, stage.order.temper).item()
        if stage.limit > -np.inf and seen < stage.limit:
            return terms
        likely = {n for n, p in stage.choice.probability.items() if p > LIKELY and n != UNKNOWN}
        left = replace(left, members=tuple(m for m in left.members if m.effect in likely))
        choice = _chosen_again(problem, left, stage.choice)
        if not choice.probability:  # nothing of it moves on these rows
            return terms
        term = _term(problem, choice.best, choice, left)
        terms = (*terms, replace(term, form=undecided(term, left)))
        terms = given_the_others(terms, problem.residual.values[rows], rows)
    return terms


def _chosen_again(problem: SearchProblem, left: Remainder, before: Choice) -> Choice:
    pose = before.pose
    if problem.poses is not None and pose is not None:
        left = _of_axes(left, np.flatnonzero(problem.poses.of == pose))
    choice, _ = _first_choice(left, before.log_change)
    return replace(choice, pose=pose)


def chosen(
    problem: SearchProblem, terms: Sequence[Term], rng: np.random.Generator, level: float = LEVEL
) -> tuple[Stage, Remainder]:
    """Return the tests of what ``terms`` leave, and the choice where they pass ``level``.

    At level 0 there is none.
    """
    left = remainder(problem, terms, problem.rows)
    stage = _tests(problem, terms, left, rng)
    by_order, by_levels, by_outlier = stage.shared
    if stage.p_value > level:
        return stage, left
    limit = stage.order.limit(level * ORDER_SHARE) if by_order <= level else -np.inf
    choice = _choice(problem, left)
    if by_levels <= level and replace(stage, choice=choice).on_levels >= 0:
        choice = replace(choice, probability={UNKNOWN: 1.0})
    if by_outlier <= level and ODD in problem.effects:
        alone = min(by_order, by_levels) > level
        choice = _with_odd(problem, left, stage.marginal, choice, alone=alone)
    return replace(stage, choice=choice, limit=limit), left


def _tests(
    problem: SearchProblem, terms: Sequence[Term], left: Remainder, rng: np.random.Generator
) -> Stage:
    hypotheses, views, emissions = in_order(problem, terms, left)
    order = order_test(hypotheses, views, rng, emissions=emissions, further=bool(terms))
    decided = order.p_value / ORDER_SHARE * TWO_LEVELS_SHARE
    enough = np.count_nonzero(~np.isnan(left.division)) > 1
    along, least = widest(left.views, left.division)
    marginal = marginal_tests(
        left.values,
        problem.residual.division,
        rng,
        levels_below=decided,
        widest=along if enough and np.ptp(along) > FINE * least else None,
    )
    return Stage(order, marginal)


def in_order(
    problem: SearchProblem, terms: Sequence[Term], left: Remainder
) -> tuple[HypothesisSet, Views, Emissions | None]:
    """Return what the test of the order compares."""
    ordered = [member for member in left.members if member.ordered]
    calm = drawn_in(left.values, 2 * left.half.max(axis=0))
    emissions = None if terms else _emissions(replace(problem.residual, values=calm), ordered)
    hypotheses = build(ordered, left.rows, left.basis)
    return hypotheses, problem.views_of(calm, left.basis), emissions


def floor_of(orders: int) -> float:
    """Return the p-value of a table which none of so many orders of its cycles came as far as."""
    return 1 / (orders + 1) / ORDER_SHARE


def finer_p_value(
    problem: SearchProblem, rng: np.random.Generator, orders: int
) -> tuple[float, bool]:
    """Return the p-value by more ``orders``, and whether none of them came as far.

    For a problem which none of the first PERMUTATIONS came as far as; those are the first of these.
    It is at most what they gave: else such a table would have the larger of two p-values, and one
    that was not compared again the smaller.
    """
    hypotheses, views, emissions = in_order(problem, (), remainder(problem, (), problem.rows))
    found = order_test(hypotheses, views, rng, emissions=emissions, permutations=orders)
    return min(found.p_value / ORDER_SHARE, floor_of(PERMUTATIONS)), found.at_floor


def _emissions(residual: Residual, members: Sequence[Hypothesis]) -> Emissions | None:
    """Return the two states of the axes that can show them, if those of some effect persist."""
    chains = [member.form for member in members if isinstance(member.form, Chain)]
    persistent = [chain for chain in chains if chain.leave_lower + chain.leave_upper < 1]
    shown = ~neighbours(residual)
    if not persistent or not shown.any() or len(residual) < 2 * FEWEST_ON_A_LEVEL:
        return None
    return emissions_of(residual.values[:, shown], residual.division[shown], persistent)


def _with_odd(
    problem: SearchProblem, left: Remainder, found: MarginalTests, choice: Choice, *, alone: bool
) -> Choice:
    """Return a choice of all odd readings at once where it is an outlier, or nothing else is there.

    ``alone`` says whether only the test of outliers has found anything: what else they may be is
    scatter with heavy tails.
    """
    if not alone and choice.best != ODD:
        return choice
    far = np.flatnonzero(found.of_axes <= LEVEL * OUTLIER_SHARE)
    own = [odd_rows(left.values[:, a]) for a in far] or [found.rows]
    rows = left.rows[list(dict.fromkeys(np.concatenate(own).tolist()))]
    cycle = problem.residual.conditions.cycle
    columns = (np.arange(len(cycle))[:, np.newaxis] == rows).astype(np.float64)
    forms = {**choice.forms, ODD: Shape(columns, {"at_cycle": cycle[rows[0]].item()})}
    if not alone:
        return replace(choice, forms=forms)
    odd = max(0.5, AS_OFTEN_ODD / (AS_OFTEN_ODD + found.heavy_tailed))
    return Choice({ODD: odd, HEAVY_TAILS: 1 - odd}, forms)


def _first_choice(
    left: Remainder, log_change: Mapping[str, float] | None = None
) -> tuple[Choice, list[Weighed]]:
    """Return how likely each effect is where readings are exact, and hidden states beside them.

    ``log_change`` is that of `choose`.
    """
    hidden = two_states(left)
    hypotheses = _and_shared(left, left.members)
    return choose(hypotheses, left.views, hidden, log_change=log_change), hidden


def _choice(problem: SearchProblem, left: Remainder) -> Choice:
    """Return how likely each effect is, forms between those of the grid compared too.

    Those are near the likeliest one of each effect. Pairs are weighed where no effect has a name,
    and beside recorded columns.
    """
    first, hidden = _first_choice(left)
    weight = {id(member.form): member.weight for member in left.members}
    finer = [
        Hypothesis(name, one, weight.get(id(form), 0.0) / len(near))
        for name, form in first.forms.items()
        if (near := _near(problem, name, form))
        for one in near
    ]
    finer += on_levels(left)
    hypotheses = _and_shared(left, [*left.members, *finer])
    choice = choose(hypotheses, left.views, hidden, left)
    named = choice.best != UNKNOWN and not isinstance(choice.forms[choice.best], Process)
    if named and not _has_columns(problem, left):
        return choice
    if left.views.axes > 1 and not named:
        alone = _of_one_part(problem, hypotheses, left)
        if alone is not None:
            return alone
    both = two_at_once(hypotheses, left)
    return choose(hypotheses, left.views, [*hidden, *both], left) if both else choice


def _has_columns(problem: SearchProblem, left: Remainder) -> bool:
    """Say whether a recorded column may act: it and another effect look like a third one."""
    known = {m.effect for m in left.members} & problem.effects.keys()
    return any(problem.effects[name].needs for name in known)


def _and_shared(left: Remainder, members: Sequence[Hypothesis]) -> HypothesisSet:
    own = build(members, left.rows, left.basis)
    shared = in_common(own, left)
    return build([*members, *shared], left.rows, left.basis) if shared else own


def _of_one_part(
    problem: SearchProblem, hypotheses: HypothesisSet, left: Remainder
) -> Choice | None:
    """Return the choice of the axis that shows most, where each of several has a course of its own.

    Of several poses it is the pose that does. A random course that fits them all is likelier than
    the course of one; each alone has a name, and together they are likelier than any in common.
    """
    poses, axes = left.views.poses, np.arange(left.views.axes)
    part = axes if poses is None else poses.of
    weights, found = hypotheses.weights / hypotheses.weights.sum(), list[tuple[float, Choice]]()
    for k in np.unique(part).tolist():
        own = _of_axes(left, axes[part == k])
        log_bf = log_bayes(hypotheses.at(axes[part == k]), own.views.columns, own.views.known)
        if (evidence := float(weights @ joint_evidence(log_bf, own.views))) > SHOWN:
            choice = _choice(problem, own)
            found.append((evidence, choice if poses is None else replace(choice, pose=k)))
    best = [(choice.best, choice.forms[choice.best]) for _, choice in found]
    likely = float(weights @ joint_evidence(log_bayes(hypotheses, left.views.columns), left.views))
    apart = sum(math.log(evidence) for evidence, _ in found) > math.log(likely)
    named = apart and all(name != UNKNOWN and isinstance(form, Shape) for name, form in best)
    return max(found, key=lambda one: one[0])[1] if len(found) > 1 and named else None


def _of_axes(left: Remainder, a: IntArray) -> Remainder:
    values, half, known = left.values[:, a], left.half[:, a], left.known[a]
    views = views_of(values, left.basis, sigma=known)
    members = tuple(replace(m, form=on_axes(m.form, a)) for m in left.members)
    own = replace(left, values=values, half=half, known=known, views=views, members=members)
    return replace(own, division=left.division[a])


def _term(problem: SearchProblem, name: str, choice: Choice, left: Remainder) -> Term:
    form = choice.forms[name]
    if problem.poses is not None and form.of is not None:
        form = replace(form, of=problem.poses.of_views)
    if near := _near(problem, name, form):
        form, _ = likeliest(near, left)
    if problem.poses is not None and isinstance(form, Shape) and name != ODD:
        of = problem.poses.of
        grows = name in problem.effects and problem.effects[name].may_be_growth
        places = possible_places(problem.places, of, choice.pose, grows=grows)
        return located_term(name, form, left, places, of)
    term = term_of(name, form, left)
    if name != ODD or not isinstance(form, Shape):
        return term
    far = np.abs(left.values - median(left.values, axis=0))[form.columns[left.rows].any(axis=1)]
    moves = term.moves & (far.max(axis=0) > TWO_DIVISIONS * problem.residual.division)
    return replace(term, moves=moves) if moves.any() else term


def _near(problem: SearchProblem, name: str, form: Form) -> tuple[Form, ...]:
    if name not in problem.effects or not isinstance(form, Shape):
        return ()
    now, near = problem.residual.conditions, problem.effects[name].near
    if form.of is not None:
        return of_visits(lambda visits: near(visits, form.parameters), now, form.of)
    return near(now, form.parameters)
