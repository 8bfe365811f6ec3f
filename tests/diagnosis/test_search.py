"""The search round by round: small hypothesis sets, and tests whose outcome is given."""

from dataclasses import replace

import numpy as np
import pytest

from scara_iso.diagnosis.engine import search as module
from scara_iso.diagnosis.engine.fit import SearchProblem, Term, remainder
from scara_iso.diagnosis.engine.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.engine.marginal import MarginalTests
from scara_iso.diagnosis.engine.order import OrderTest
from scara_iso.diagnosis.engine.residual import Residual
from scara_iso.diagnosis.engine.search import (
    ORDER_SHARE,
    OUTLIER_SHARE,
    TWO_LEVELS_SHARE,
    Stage,
    chosen,
    find,
    find_again,
)
from scara_iso.diagnosis.verdict import UNKNOWN, Choice
from scara_iso.effects import Chain, Conditions, Process, Shape, Spread, find_effects

N = 16
ROWS = np.arange(N)
CONDITIONS = Conditions(np.arange(2, N + 2))
EFFECTS = {effect.name: effect for effect in find_effects()}
NOISE = 0.1 * np.array([1, -2, 0, 1, 2, -1, -1, 0, 2, -1, 1, 0, -2, 1, 0, -1.0])
RAMP = Shape(np.arange(N, dtype=float)[:, None])
WALK = Process(np.minimum.outer(np.arange(N), np.arange(N)).astype(float))
WIDE = Spread(np.where(np.arange(N) >= 8, 5.0, 1.0))
QUIET = OrderTest(0.0, 1.0, at_floor=False)


def step(at, size=1.0):
    return Shape(np.where(np.arange(N) >= at, size, 0.0)[:, None], {"at_cycle": at + 2.0})


STEPS = [Hypothesis("step", step(at), 0.1) for at in range(3, 14)]
DRIFT = Hypothesis("linear_drift", RAMP, 1.0)
ODD = Hypothesis(UNKNOWN, Process(2.0 * np.exp(-np.abs(np.subtract.outer(ROWS, ROWS)) / 2)), 0.5)


def problem(values, members, division=0.0, effects=()):
    values = np.reshape(values, (N, -1)).astype(float)
    axes = tuple("XYZ"[: values.shape[1]])
    residual = Residual(axes, values, np.full(len(axes), division), CONDITIONS)
    return SearchProblem(
        residual, tuple(members), effects={name: EFFECTS[name] for name in effects}
    )


def marginal(two_levels=1.0, outlier=1.0, row=0, floor=0.001):
    return MarginalTests(two_levels, outlier, outlier, 0, row, floor, np.ones(1))


def order(p, at_floor=False):
    return OrderTest(1.0, p, at_floor)


def stage(name=None, form=RAMP):
    return Stage(QUIET, marginal(), None if name is None else Choice({name: 1.0}, {name: form}))


def likely(*names):
    """Return a stage in which these effects were."""
    return Stage(QUIET, marginal(), Choice(dict.fromkeys(names, 1 / len(names)), {}))


@pytest.mark.parametrize(
    ("p_order", "p_levels", "p_outlier", "expected"),
    [
        (0.2 * ORDER_SHARE, 0.06, 0.06, 0.2),
        (0.5, 0.2 * TWO_LEVELS_SHARE, 0.06, 0.2),
        (0.5, 0.06, 0.2 * OUTLIER_SHARE, 0.2),
        (1, 1, 1, 1.0),
    ],
)
def test_the_p_value_is_the_smallest_over_its_share_of_the_level(
    p_order, p_levels, p_outlier, expected
):
    assert Stage(order(p_order), marginal(p_levels, p_outlier), None).p_value == pytest.approx(
        expected
    )


def test_the_smallest_p_value_is_at_its_floor_or_not():
    def at_floor(*tests):
        return Stage(*tests, None).p_value_at_floor

    assert at_floor(order(0.001, True), marginal())
    assert not at_floor(order(0.001), marginal())
    assert at_floor(order(0.5), marginal(two_levels=0.001))
    assert not at_floor(order(0.5), marginal(two_levels=0.0015))
    assert at_floor(order(0.5), marginal(outlier=0.001))
    assert not at_floor(order(0.5), marginal(outlier=0.0015))
    assert not at_floor(order(0.5, True), marginal(two_levels=0.01))


@pytest.fixture
def scripted(monkeypatch):
    """Give `find` its stages; returns the levels that it asked for and the terms it had then."""

    def play(*stages):
        asked = []

        def next_stage(problem, terms, rng, level):
            asked.append((level, [term.effect for term in terms]))
            return stages[len(asked) - 1], remainder(problem, terms, problem.rows)

        monkeypatch.setattr(module, "chosen", next_stage)
        return asked

    return play


def test_the_search_ends_where_the_tests_are_quiet(rng, scripted):
    asked = scripted(stage("step", step(6)), stage("linear_drift"), stage())
    terms, stages = find(problem(NOISE, STEPS), rng, level=0.2)
    assert [term.effect for term in terms] == ["step", "linear_drift"]
    assert len(stages) == 3
    assert asked == [(0.2, []), (0.01, ["step"]), (0.01, ["step", "linear_drift"])]


def test_a_stricter_level_holds_for_further_effects_too(rng, scripted):
    asked = scripted(stage("step", step(6)), stage())
    find(problem(NOISE, STEPS), rng, level=0.002)
    assert [level for level, _ in asked] == [0.002, 0.002]


def test_the_first_effect_is_admitted_at_a_level_of_a_twentieth(rng, scripted):
    asked = scripted(stage())
    assert find(problem(NOISE, STEPS), rng)[0] == ()
    assert asked == [(0.05, [])]


def test_the_search_ends_with_the_unknown(rng, scripted):
    scripted(stage("step", step(6)), stage(UNKNOWN, ODD.form))
    terms, stages = find(problem(NOISE, STEPS), rng)
    assert [term.effect for term in terms] == ["step"]
    assert len(stages) == 2


def test_a_random_course_ends_the_search_and_stays(rng, scripted):
    scripted(stage("random_walk", WALK))
    terms, stages = find(problem(NOISE, STEPS), rng)
    assert [term.effect for term in terms] == ["random_walk"]
    assert len(stages) == 1
    scripted(stage("step", step(6)), stage("random_walk", WALK))
    terms, stages = find(problem(NOISE, STEPS), rng)
    assert [term.effect for term in terms] == ["step", "random_walk"]
    assert len(stages) == 2


def test_a_fourth_effect_is_chosen_and_not_taken(rng, scripted):
    scripted(*(stage(f"effect {k}", step(3 + 2 * k)) for k in range(5)))
    terms, stages = find(problem(NOISE, STEPS), rng)
    assert [term.effect for term in terms] == ["effect 0", "effect 1", "effect 2"]
    assert [each.choice.best for each in stages] == [f"effect {k}" for k in range(4)]


def test_a_step_is_found_where_it_is_and_nothing_beside_it(rng):
    found = problem(NOISE + 2.0 * (ROWS >= 9), [*STEPS, DRIFT, ODD])
    terms, stages = find(found, rng)
    assert [term.effect for term in terms] == ["step"]
    np.testing.assert_array_equal(terms[0].columns, step(9).columns)
    assert [each.choice is None for each in stages] == [False, True]


@pytest.fixture
def outcome(monkeypatch):
    """Give `chosen` the outcome of the tests."""

    def give(p_order=1.0, two_levels=1.0, outlier=1.0, row=0):
        given = Stage(order(p_order), marginal(two_levels, outlier, row), None)
        monkeypatch.setattr(module, "_tests", lambda *_: given)

    return give


@pytest.mark.parametrize(
    ("outcome_given", "passes"),
    [
        ({"p_order": 0.5 * ORDER_SHARE}, True),
        ({"p_order": 0.51 * ORDER_SHARE}, False),
        ({"two_levels": 0.5 * TWO_LEVELS_SHARE}, True),
        ({"two_levels": 0.51 * TWO_LEVELS_SHARE}, False),
        ({"outlier": 0.5 * OUTLIER_SHARE}, True),
        ({"outlier": 0.51 * OUTLIER_SHARE}, False),
    ],
)
def test_a_name_is_chosen_where_a_test_passes_the_level(rng, outcome, outcome_given, passes):
    outcome(**outcome_given)
    found, left = chosen(problem(NOISE + 2.0 * (ROWS >= 9), [*STEPS, DRIFT]), (), rng, 0.5)
    assert (found.choice is not None) == passes
    assert passes == (found.choice is not None and found.choice.best == "step")
    np.testing.assert_allclose(left.values.mean(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("moved", "said"),
    [
        ((11,), {"outlier"}),
        ((4, 11), {"outlier"}),
        ((15,), {"outlier", "step"}),
        ((0,), {"outlier", "step"}),
    ],
)
def test_an_isolated_reading_is_weighed_against_all_that_looks_the_same(rng, outcome, moved, said):
    outcome(outlier=0.001)
    both = [EFFECTS[name] for name in ("step", "outlier")]
    members = hypotheses_of(both, CONDITIONS)
    found = chosen(problem(NOISE + 8.0 * np.isin(ROWS, moved), members), (), rng)[0].choice
    assert {found.best, *(rival.effect for rival in found.rivals)} == said
    assert (found.probability[found.best] > 0.9) == (len(said) == 1)
    assert {int(found.forms[n].parameters["at_cycle"]) - 2 for n in said} <= {*moved, moved[-1] + 1}


def test_a_shift_of_fewer_readings_than_three_has_no_part_in_the_test_of_the_order():
    members = hypotheses_of([EFFECTS["step"], EFFECTS["outlier"]], CONDITIONS)
    ordered = [m for m in members if m.ordered and m.effect != UNKNOWN]
    assert [m.form.parameters["at_cycle"] for m in ordered] == list(CONDITIONS.cycle[3:-2])
    assert sum(m.weight for m in ordered) == pytest.approx(EFFECTS["step"].weight)


def test_tests_alone_choose_nothing(rng):
    given = problem(NOISE + 2.0 * (ROWS >= 9), STEPS)
    before, _ = chosen(given, (), rng, 0.0)
    term = Term("step", step(9), np.array([True]))
    after, _ = chosen(given, [term], rng, 0.0)
    assert before.choice is None
    assert before.order.p_value < 0.01
    assert after.order.p_value > 0.1


def test_members_in_no_order_do_not_count_in_the_test_by_order(rng, monkeypatch):
    seen = []
    monkeypatch.setattr(
        module, "order_test", lambda h, *_, **given: seen.append((h, given)) or QUIET
    )
    loose = Hypothesis(UNKNOWN, step(5), 1.0, ordered=False)
    chain = Hypothesis("sides", Chain(0.1, 0.2), 1.0)
    brisk = Hypothesis("sides", Chain(0.4, 0.6), 1.0)
    given = problem(
        np.column_stack([NOISE, 0 * NOISE + ROWS % 2]), [DRIFT, loose, chain, brisk], 1.0
    )
    given.residual.division[0] = 0.01
    chosen(given, (), rng, 0.0)
    chosen(given, [Term("linear_drift", RAMP, np.array([True, True]))], rng, 0.0)
    chosen(problem(NOISE, [DRIFT, brisk]), (), rng, 0.0)
    assert [member.effect for member in seen[0][0].members] == ["linear_drift"]
    sides = seen[0][1]["emissions"]  # the second axis shows two neighbouring divisions
    assert sides.chains == [chain.form]
    assert sides.lower.shape == (N, 1)
    assert [each[1]["emissions"] for each in seen[1:]] == [None, None]


@pytest.fixture
def weighed(monkeypatch):
    """Record what is asked of hidden states."""
    asked = {"division": [], "chains": []}

    def two_states(left):
        asked["division"].append(left.division)
        asked["chains"].append(
            [member.effect for member in left.members if isinstance(member.form, Chain)]
        )
        return []

    monkeypatch.setattr(module, "two_states", two_states)
    return asked


def test_states_are_sought_in_units_of_the_views_where_the_dial_can_show_them(
    rng, outcome, weighed
):
    outcome(p_order=0.001)
    values = np.column_stack([NOISE, ROWS % 2, ROWS])
    given = problem(values, [*STEPS, Hypothesis("sides", Chain(0.1, 0.1), 1.0)], 1.0)
    given.residual.division[0] = 0.02
    drift = Term("linear_drift", RAMP, np.array([False, False, True]))
    _, left = chosen(given, [drift], rng)
    length = np.sqrt(((NOISE - NOISE.mean()) ** 2).sum())
    np.testing.assert_allclose(weighed["division"][0], [0.02 / length, np.nan, np.nan])
    assert weighed["chains"] == [["sides"]]
    assert not left.values[:, 2].any()
    find_again(given, ROWS, [likely("step")])
    find_again(given, ROWS, [likely("step", "sides")])
    assert find_again(given, ROWS, [likely("linear_drift")]) == ()
    assert weighed["chains"][1:] == [[], ["sides"], []]
    turns = Hypothesis("sides", Shape((ROWS % 2)[:, np.newaxis] * 1.0), 1.0)
    both = problem(NOISE + 9.0 * (ROWS % 2) + 4.0 * (ROWS >= 9), [*given.members, turns])
    first, second = find_again(both, ROWS, [likely("step", "sides"), likely("step")])
    assert (first.effect, second.effect) == ("sides", "step")
    assert weighed["chains"][4:] == [["sides"], []]


def test_the_form_is_refined_among_those_near_it(rng, scripted):
    """Of an effect that knows nearer forms the likeliest is taken, else the form as it is."""
    periodic = EFFECTS["periodic"]
    forms = periodic.forms(CONDITIONS)
    coarse = forms[len(forms) // 2]
    near = periodic.near(CONDITIONS, coarse.parameters)
    true = near[len(near) // 3]
    y = NOISE + (true.columns @ np.array([[20.0], [10.0]]))[:, 0]
    scripted(stage("periodic", coarse), stage())
    (term,), _ = find(problem(y, STEPS, effects=("periodic",)), rng)
    assert term.form.parameters == true.parameters
    scripted(stage("periodic", coarse), stage())
    (term,), _ = find(problem(y, STEPS), rng)
    assert term.form is coarse
    scripted(stage("step", step(9)), stage())
    (term,), _ = find(problem(y, STEPS, effects=("step",)), rng)
    np.testing.assert_array_equal(term.columns, step(9).columns)


def test_a_change_of_scatter_moves_the_axes_that_it_widens(rng, scripted):
    values = np.column_stack([NOISE * WIDE.scale, NOISE])
    scripted(stage("scatter_change", WIDE), stage())
    (term,), _ = find(problem(values, STEPS), rng)
    np.testing.assert_array_equal(term.moves, [True, False])


def test_effects_found_again_on_some_rows_are_as_many_as_asked_for():
    y = NOISE + 3.0 * (ROWS >= 9) + 0.5 * ROWS
    given = problem(y, [*STEPS, DRIFT, ODD])
    rows = np.delete(ROWS, [2, 9])
    either = likely("step", "linear_drift")
    terms = find_again(given, rows, [either, either])
    assert {term.effect for term in terms} == {"step", "linear_drift"}
    assert find_again(given, rows, []) == ()
    (one,) = find_again(given, rows, [likely("linear_drift")])
    assert one.effect == "linear_drift"


def test_effects_are_not_found_again_where_the_rows_would_not_have_shown_them():
    given, lasting = problem(NOISE, [*STEPS, DRIFT, ODD]), likely("step")
    assert find_again(given, ROWS, [replace(lasting, limit=0.0)]) == ()
    assert find_again(given, ROWS, [replace(lasting, limit=-90.0)])


def test_the_unknown_is_never_found_again():
    likelier = Hypothesis(UNKNOWN, Shape((ROWS % 8 >= 4)[:, None].astype(float)), 9.0)
    given = problem(NOISE + 3.0 * (ROWS % 8 >= 4), [ODD, likelier, DRIFT])
    (term,) = find_again(given, ROWS, [likely(UNKNOWN, "linear_drift")])
    assert term.effect == "linear_drift"


def test_forms_that_do_not_differ_on_the_rows_seen_are_averaged():
    """Steps at 9, 10 and 11 are one where cycles 9 and 10 were not seen; others do not count."""
    same = Hypothesis("other", step(10), 0.001)
    given = problem(NOISE + 3.0 * (ROWS >= 9), [*STEPS, same])
    (term,) = find_again(given, np.delete(ROWS, [9, 10]), [likely("step", "other")])
    assert term.effect == "step"
    expected = [0.0] * 9 + [1 / 3, 2 / 3] + [1.0] * 5
    np.testing.assert_allclose(term.columns[:, 0], expected)


def test_where_scatter_is_wider_a_division_is_so_much_less_of_it():
    given = problem(NOISE * WIDE.scale, STEPS, division=0.1)
    left = remainder(given, [Term("scatter_change", WIDE, np.array([True]))], ROWS)
    np.testing.assert_allclose(left.half[:, 0], 0.05 / WIDE.scale)
