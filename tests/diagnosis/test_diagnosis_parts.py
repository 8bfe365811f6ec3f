"""The parts of the search against independent oracles."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from scara_iso.base.errors import DataError
from scara_iso.diagnosis.engine.evidence import (
    Remainder,
    Views,
    build,
    constant,
    extended,
    joint_evidence,
    log_bayes,
    log_evidence_by_effect,
    views_of,
)
from scara_iso.diagnosis.engine.fit import SearchProblem, fit
from scara_iso.diagnosis.engine.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.engine.marginal import (
    _FAMILIES,
    _skewed,
    level_statistic,
    marginal_tests,
    outlier_statistic,
)
from scara_iso.diagnosis.engine.naming import two_states
from scara_iso.diagnosis.engine.order import log_statistic, order_test
from scara_iso.diagnosis.engine.residual import Residual, residual_of
from scara_iso.diagnosis.engine.rounded import KNOWN_FROM
from scara_iso.diagnosis.engine.search import chosen, find, find_again
from scara_iso.diagnosis.engine.two_levels import Emissions, emissions_of, two_levels
from scara_iso.diagnosis.findings import match
from scara_iso.diagnosis.gears import diagnose_sweep
from scara_iso.diagnosis.held_out import cross_validated
from scara_iso.diagnosis.planning import PlannedRun, _crossing, collinear, smallest_effects
from scara_iso.diagnosis.verdict import Verdict
from scara_iso.effects import (
    Chain,
    Conditions,
    Process,
    Shape,
    Spread,
    Sweep,
    find_effects,
    find_gear_effects,
)
from scara_iso.run import Axis, Run, common_step, seen_step

N = 20
CONDITIONS = Conditions(np.arange(2, N + 2))
MEMBERS = hypotheses_of(find_effects(), CONDITIONS)
ORDERED = [member for member in MEMBERS if member.ordered and not isinstance(member.form, Chain)]


def set_of(members, n=N):
    return build(members, np.arange(n), constant(n))


def log_marginal(y, covariance):
    """Return the log marginal likelihood of y with flat mean and prior 1 / scatter."""
    n = len(y)
    inverse = np.linalg.inv(covariance)
    one = np.ones(n)
    S = y @ inverse @ y - (one @ inverse @ y) ** 2 / (one @ inverse @ one)
    _, determinant = np.linalg.slogdet(covariance)
    return -(determinant + math.log(one @ inverse @ one) + (n - 1) * math.log(S)) / 2


def test_evidence_is_the_ratio_of_marginal_likelihoods(rng):
    y = rng.normal(size=N)
    y -= y.mean()
    ramp = np.arange(N) - (N - 1) / 2
    unit = ramp / np.linalg.norm(ramp)
    random = np.exp(-0.5 * np.subtract.outer(ramp, ramp) ** 2 / 4)
    centre = np.eye(N) - 1 / N
    wide = np.where(np.arange(N) >= 8, 2.5, 1.0)
    cases = {
        "shape": (Shape(ramp[:, None]), np.eye(N) + 15 * np.outer(unit, unit)),
        "process": (Process(random), np.eye(N) + centre @ random @ centre),
        "spread": (Spread(wide), np.diag(wide**2)),
    }
    members = [Hypothesis(name, form, 1.0) for name, (form, _) in cases.items()]
    hypotheses = set_of([*members, Hypothesis("process", Process(random), 1.0)])
    log_bf = log_bayes(hypotheses, y[:, None])[:, 0]
    found = dict(zip([m.effect for m in hypotheses.members], log_bf, strict=True))
    for name, (_, covariance) in cases.items():
        expected = log_marginal(y, covariance) - log_marginal(y, np.eye(N))
        assert found[name] == pytest.approx(expected, abs=1e-3), name


def test_a_known_scatter_counts_as_cycles_on_which_nothing_acted(rng):
    """The evidence with those cycles appended, where no effect reaches them."""
    y = rng.normal(size=(N, 1))
    y -= y.mean(axis=0)
    views = views_of(y, constant(N), sigma=np.array([0.7]))
    ramp = np.arange(N) - (N - 1) / 2
    unit = ramp / np.linalg.norm(ramp)
    random = Hypothesis("random", Process(np.eye(N)), 1.0)
    hypotheses = set_of([Hypothesis("ramp", Shape(ramp[:, None]), 1.0), random])
    found = log_bayes(hypotheses, views.columns, views.known)
    more = (KNOWN_FROM - 1) * 0.7**2
    nu = N - 1 + KNOWN_FROM - 1
    share = 15 / 16 * (unit @ y[:, 0]) ** 2 / ((y**2).sum() + more)
    assert found[0, 0] == pytest.approx(-nu / 2 * np.log(1 - share) - np.log(16) / 2)
    assert views_of(y, constant(N), sigma=np.zeros(1)).known.tolist() == [0.0]


def test_two_levels_a_known_scatter_apart_are_no_levels(rng):
    y = rng.normal(size=24)
    free, wide, narrow = (
        two_levels(y, 0.0, [Chain(0.6, 0.4)], known=(KNOWN_FROM - 1) * sigma**2).log_bf[0]
        for sigma in (0.0, y.std(), 0.4 * y.std())
    )
    assert wide < free < narrow


def test_an_amplified_set_is_that_of_larger_variances(rng):
    y = rng.normal(size=(N, 3))
    y -= y.mean(axis=0)
    lag = np.subtract.outer(np.arange(N), np.arange(N))
    kernel = np.exp(-np.abs(lag) / 3.0)
    small = set_of(
        [Hypothesis("a", Process(kernel), 1.0), Hypothesis("b", Shape(lag[:, :1] * 1.0), 1.0)]
    )
    large = set_of([Hypothesis("a", Process(13 * kernel), 1.0),
                     Hypothesis("b", Shape(lag[:, :1] * 1.0), 1.0, gain=195.0)])  # fmt: skip
    np.testing.assert_allclose(log_bayes(small, y, factor=13.0), log_bayes(large, y), atol=1e-6)


@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_process_that_moves_nothing_is_no_hypothesis(place, rng):
    ramp = np.arange(N)
    moving = [Process(np.exp(-np.abs(np.subtract.outer(ramp, ramp)) / b)) for b in (2.0, 5.0)]
    forms = [*moving[:place], Process(np.ones((N, N))), *moving[place:]]
    y = rng.normal(size=(N, 2))
    y -= y.mean(axis=0)
    found = set_of([Hypothesis("any", form, 1.0) for form in forms])
    alone = set_of([Hypothesis("any", form, 1.0) for form in moving])
    np.testing.assert_allclose(log_bayes(found, y), log_bayes(alone, y))


def test_the_evidence_of_an_effect_alone_is_a_mean_over_its_forms(rng):
    """However likely the effect itself is beside others."""
    views = views_of(rng.normal(size=(N, 2)).cumsum(axis=0), constant(N))
    usual, often = (
        log_evidence_by_effect(set_of([replace(m, weight=k * m.weight) for m in ORDERED]), views)
        for k in (1, 7)
    )
    assert len(usual) > 3
    for name, logs in usual.items():
        assert often[name] == pytest.approx(logs)


def test_a_set_ignores_what_is_already_fitted(rng):
    trend = np.arange(N, dtype=float)[:, None]
    basis = extended(constant(N), trend)
    hypotheses = build(ORDERED, np.arange(N), basis)
    assert max(np.abs(basis.T @ group.vectors).max() for group in hypotheses.groups) < 1e-9
    assert "linear_drift" not in {member.effect for member in hypotheses.members}


def test_another_order_is_judged_free_of_what_is_already_fitted(rng):
    """As readings that came in that order would be, from which the same is taken out."""
    basis = extended(constant(N), np.column_stack([np.arange(N), np.cos(np.arange(N))]))
    hypotheses = build(ORDERED, np.arange(N), basis)
    left = rng.normal(size=(N, 2)).cumsum(axis=0)
    left -= basis @ (basis.T @ left)
    orders, as_is = np.array([rng.permutation(N) for _ in range(5)]), np.arange(N)[np.newaxis]
    found = log_statistic(hypotheses, views_of(left, basis), orders)
    expected = [log_statistic(hypotheses, views_of(left[one], basis), as_is)[0] for one in orders]
    assert found == pytest.approx(expected, abs=1e-4)


def test_the_order_test_is_exact():
    """p <= k / 20 has probability k / 20 in scatter alone, whatever its distribution."""
    hypotheses = set_of(ORDERED)
    p_values = []
    for seed in range(400):
        rng = np.random.default_rng(seed)
        scatter = np.round(rng.standard_t(3, size=(N, 2)) @ [[1, 0.5], [0, 1]])
        views = views_of(scatter, constant(N))
        p_values.append(order_test(hypotheses, views, rng, permutations=19).p_value)
    counts = np.bincount(np.round(np.array(p_values) * 20).astype(int), minlength=21)[1:]
    assert stats.chisquare(counts).pvalue > 0.001


def test_shuffling_ends_early_only_where_the_test_stays_quiet():
    rng = np.random.default_rng(4)
    hypotheses, stopped = set_of(ORDERED), []
    for _ in range(40):
        views = views_of(rng.normal(size=(N, 1)), constant(N))
        early = order_test(hypotheses, views, np.random.default_rng(1)).p_value
        orders = np.random.default_rng(1)
        order = np.array([orders.permutation(N) for _ in range(999)])
        observed = log_statistic(hypotheses, views, np.arange(N)[np.newaxis])
        full = np.mean([1, *(log_statistic(hypotheses, views, order) >= observed - 1e-3)])
        stopped.append(early > 0.05)
        assert early == full if full <= 0.05 else early > 0.05
    assert 0 < sum(stopped)


def test_hidden_states_are_not_sought_where_nothing_moves(rng):
    two = rng.normal(size=(N, 2))
    two = np.column_stack([two, np.zeros(N)])
    views, sticky = views_of(two, constant(N)), Hypothesis("sides", Chain(0.1, 0.1, 1.0), 1.0)
    left = Remainder(
        rows=np.arange(N),
        cycles=N,
        basis=constant(N),
        values=two,
        half=0 * two,
        known=np.zeros(3),
        division=np.array([0, 0, np.nan]),
        views=views,
        members=(sticky,),
    )
    (found,) = two_states(left)
    assert np.isfinite(found.log_evidence)


def test_the_order_test_sees_a_trend_but_no_constant_scatter(rng):
    hypotheses = set_of(ORDERED)
    trend = rng.normal(size=(N, 1)) + 0.3 * np.arange(N)[:, None]
    assert (
        order_test(hypotheses, views_of(trend, constant(N)), rng, permutations=199).p_value < 0.02
    )


def test_joint_evidence_without_any_is_one():
    for axes, columns in ((1, 1), (2, 2), (4, 4)):
        views = Views(np.zeros((N, columns)), axes, np.zeros(columns))
        assert joint_evidence(np.zeros((5, columns, 1)), views) == pytest.approx(1.0)


def test_hidden_states_agree_with_the_sum_over_every_course(rng):
    """The forward algorithm against brute force over all 2^8 courses, levels and scatter given."""
    y = rng.normal(size=8) + 4 * np.array([0, 0, 1, 1, 1, 0, 0, 1])
    chain = Chain(0.2, 0.3)
    sides = (np.arange(256)[:, None] >> np.arange(8)) & 1
    leave = np.array([chain.leave_lower, chain.leave_upper])
    start = np.array([chain.leave_upper, chain.leave_lower]) / leave.sum()
    moved = sides[:, 1:] != sides[:, :-1]
    step = np.where(moved, leave[sides[:, :-1]], 1 - leave[sides[:, :-1]])
    prior = start[sides[:, 0]] * step.prod(axis=1)
    assert prior.sum() == pytest.approx(1.0)
    fit_of = stats.norm.logpdf(y, loc=np.array([0.0, 4.0])[sides]).sum(axis=1)
    posterior = prior * np.exp(fit_of - fit_of.max())
    expected = posterior @ sides / posterior.sum()
    found = two_levels(y, 0.0, [chain])
    np.testing.assert_array_equal(found.share_upper > 0.5, expected > 0.5)


def test_hidden_states_bridge_cycles_that_were_not_seen(rng):
    y = rng.normal(size=24) + 8.0 * ((np.arange(24) >= 8) & (np.arange(24) < 18))
    y[[3, 14]] = np.nan
    found = two_levels(y, 0.0, [Chain(0.1, 0.1)])
    assert found.share_upper[3] < 0.1
    assert found.share_upper[14] > 0.9
    assert found.log_bf[0] > 3


def courses_of(chain, n):
    """Return every course of two sides over n cycles, and its probability."""
    sides = (np.arange(2**n)[:, None] >> np.arange(n)) & 1
    leave = np.array([chain.leave_lower, chain.leave_upper])
    start = leave[::-1] / leave.sum()
    moved = sides[:, 1:] != sides[:, :-1]
    step = np.where(moved, leave[sides[:, :-1]], 1 - leave[sides[:, :-1]])
    return sides, start[sides[:, 0]] * step.prod(axis=1)


def test_persistence_is_the_likelihood_ratio_against_sides_drawn_anew(rng):
    chain = Chain(0.2, 0.3)
    sides = Emissions(*rng.uniform(0.1, 1.0, size=(2, 8, 2)), [chain])
    courses, prior = courses_of(chain, 8)
    orders = np.array([np.arange(8), rng.permutation(8)])
    for order, found in zip(orders, sides.persistence(orders), strict=True):
        likelihood = np.stack([sides.lower, sides.upper])[:, order]
        sticky = prior @ likelihood[courses, np.arange(8)].prod(axis=1)
        anew = (0.6 * sides.lower + 0.4 * sides.upper).prod(axis=0)
        assert found == pytest.approx((sticky / anew).mean())


def test_sides_that_stay_add_to_the_test_by_order(rng):
    """Levels of the best split: 0 and 5, whatever the order; only the order tells them."""
    y = rng.normal(size=N) + 5.0 * (np.arange(N) // 4 % 2)
    values = (y - y.mean())[:, np.newaxis]
    views = views_of(values, constant(N))
    sides = emissions_of(values, np.zeros(1), [Chain(0.16, 0.16)])
    assert ((sides.upper[:, 0] == 1) == (np.arange(N) // 4 % 2)).all()
    without = order_test(set_of(ORDERED), views, np.random.default_rng(1))
    both = order_test(set_of(ORDERED), views, np.random.default_rng(1), emissions=sides)
    sticky = sides.persistence(np.arange(N)[np.newaxis]).item()
    assert sticky > 10
    assert both.statistic == pytest.approx(np.log(np.exp(without.statistic) + 0.08 * sticky))


def test_the_test_weighs_effects_by_their_own_test_weights():
    hypotheses = set_of(ORDERED)
    share = Counter()
    for member, weight in zip(hypotheses.members, hypotheses.test_weights, strict=True):
        share[member.effect] += weight
    assert share.total() == pytest.approx(1.0)
    effects = {effect.name: effect for effect in find_effects()}
    periodic, drift = effects["periodic"], effects["linear_drift"]
    assert share["periodic"] / share["linear_drift"] == pytest.approx(
        periodic.weight * periodic.test_weight / (drift.weight * drift.test_weight)
    )


def test_a_step_between_unseen_cycles_is_half_way_in_a_fold(rng):
    values = rng.normal(size=(N, 1)) + 9.0 * (np.arange(N) >= 9)[:, None]
    problem = SearchProblem(Residual(("X",), values, np.zeros(1), CONDITIONS), MEMBERS)
    stage, _ = chosen(problem, (), rng)
    (term,) = find_again(problem, np.delete(np.arange(N), 9), [stage])
    assert term.effect == "step"
    np.testing.assert_array_equal(term.columns[:, 0], [0.0] * 9 + [0.5] + [1.0] * (N - 10))


def test_marginal_statistics_ignore_order_shift_and_scale(rng):
    y = rng.normal(size=30)
    for statistic in (level_statistic, outlier_statistic):
        other = statistic(5 - 3 * rng.permutation(y))
        assert other == pytest.approx(statistic(y), rel=1e-6)


def test_the_outlier_statistic_is_the_distance_of_two_readings_from_the_median(rng):
    y = rng.normal(size=30)
    y[4] = 9.0
    apart = np.abs(y - np.median(y))
    inner = y[np.argsort(apart)[:27]]
    expected = np.sort(apart)[-2:] @ [1 / 3, 1]
    assert outlier_statistic(y) == pytest.approx(expected / inner.std(ddof=1), rel=1e-6)
    assert outlier_statistic(y, least=3.0) == pytest.approx(expected / 3.0)


def test_one_gross_reading_does_not_hide_another(rng):
    y = np.round(rng.normal(size=30))
    for other in (26.0, -26.0):
        y[[4, 20]] = 25.0, other
        assert marginal_tests(y[:, None], np.ones(1), rng).outlier < 0.005


@pytest.mark.parametrize("far", [9.0, -9.0])
def test_the_outlier_is_told_by_its_row_wherever_the_level_is(far, rng):
    y = np.round(100.0 + rng.normal(size=(30, 2)), 3)
    y[4, 1] += far
    found = marginal_tests(y, np.full(2, 0.001), rng)
    assert (found.outlier_axis, found.outlier_row) == (1, 4)


@pytest.mark.parametrize("family", list(_FAMILIES))
def test_every_family_of_scatter_has_no_mean_and_unit_variance(family, rng):
    drawn = _FAMILIES[family](rng, (400, 1000))
    assert abs(drawn.mean()) < 0.01
    assert drawn.var() == pytest.approx(1.0, rel=0.1)


def test_a_neighbouring_division_never_is_an_outlier(rng):
    y = np.repeat([5.0], 31)
    y[7] = 6.0
    found = marginal_tests(y[:, None], np.ones(1), rng)
    assert (found.outlier, found.gaussian_outlier, found.two_levels) == (1.0, 1.0, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("n", [30, 60])
@pytest.mark.parametrize("kind", ["uniform", "arcsine", "laplace"])
def test_scatter_between_limits_is_seldom_two_levels(kind, n):
    alarms = 0
    for seed in range(60):
        rng = np.random.default_rng([seed, n])
        drawn = {
            "uniform": rng.uniform(-3, 3, n),
            "arcsine": 3 * np.sin(rng.uniform(0, 2 * np.pi, n)),
            "laplace": rng.laplace(0, 2, n),
        }[kind]
        found = marginal_tests(np.round(drawn)[:, None], np.ones(1), rng)
        alarms += found.two_levels < 0.0075
    assert alarms <= 3


def test_levels_with_an_empty_gap_are_no_vibration_between_limits(rng):
    y = rng.permutation(np.repeat([0.0, 1.0, 6.0, 7.0], [5, 3, 10, 12]))
    assert marginal_tests(y[:, None], np.ones(1), rng).two_levels < 0.001


def test_axes_share_their_simulations():
    y = np.round(np.random.default_rng(1).standard_t(2, size=(30, 2)) * 3)
    both = marginal_tests(y, np.ones(2), np.random.default_rng(5))
    alone = [marginal_tests(one[:, None], np.ones(1), np.random.default_rng(5)) for one in y.T]
    assert both.gaussian_outlier == 2 * min(one.gaussian_outlier for one in alone) < 1


def test_neighbouring_divisions_never_prove_two_levels(rng):
    readings = rng.permutation(np.repeat([0.0, 2.0], 15))[:, None]
    fine = marginal_tests(readings, np.array([0.1]), rng)
    coarse = marginal_tests(readings, np.array([1.0]), rng)
    assert fine.two_levels < 0.01
    assert coarse.two_levels == 1.0
    decided = marginal_tests(readings, np.array([0.1]), rng, levels_below=0.0001)
    assert decided.two_levels == 1.0


def test_two_levels_are_tested_to_the_end_only_where_they_may_decide():
    """A p-value is the same however small it must be, and 1 where it is not."""

    def two_levels(below):
        rng = np.random.default_rng(1)
        readings = rng.normal(size=(30, 2)) + 3.4 * (rng.random((30, 2)) < 0.5)
        return marginal_tests(readings, np.zeros(2), rng, levels_below=below).two_levels

    whole = two_levels(1.0)
    assert 0.002 < whole < 0.1
    assert two_levels(whole * 1.01) == whole
    assert two_levels(whole * 0.99) == 1.0


def test_a_dial_of_which_nothing_is_stated_is_known_by_its_steps(rng):
    coarse = 0.37 + 0.01 * rng.integers(0, 4, 30)
    assert common_step(coarse) == pytest.approx(0.01)
    assert common_step(rng.normal(size=30)) == 0.0
    assert common_step(np.full(30, 0.37)) == 0.0


@pytest.mark.parametrize(
    ("places", "step"),
    [
        ([0, 0.005, 0.01, 0], 0.005),
        ([0.013, 0.025, 0.038, 0.127, 0], 0.0127),  # 0.0005 inch, shown in mm
        ([0.025, 0.051, 0.102, 0.254, 0], 0.0254),
        ([0, 0.002, 0.005, 0.009], 0.001),
        ([0, 0.022, 0.038, 0.05, 0.058, 0.064, 0.069], 0.001),
        ([0, 0.008], 0.001),
        ([0, 0.1, 0.2], 0.001),
    ],
)
def test_a_dial_coarser_than_stated_is_known_by_three_steps(places, step):
    axis = Axis("Z", 12.3 + np.array(places), resolution=0.001)
    assert seen_step(axis) == pytest.approx(step, rel=0.01)


def test_a_neighbouring_step_of_a_dial_stated_too_fine_is_nothing():
    readings = np.full(30, 12.1)
    readings[[8, 27]] = 12.105, 12.095
    run = Run(np.arange(1, 31), {"Z": Axis("Z", readings, resolution=0.001)})
    residual = residual_of(run, None)
    assert residual.division == pytest.approx(0.005)
    assert "steps of 0.005, coarser than the resolution stated" in residual.notes[0]


def test_cross_validation_is_no_better_than_the_fit(rng):
    values = rng.normal(size=(N, 1)) + 6.0 * (np.arange(N) >= 9)[:, None]
    problem = SearchProblem(Residual(("X",), values, np.zeros(1), CONDITIONS), MEMBERS)
    terms, stages = find(problem, rng)
    assert [term.effect for term in terms] == ["step"]
    assert stages[-1].choice is None
    fitted = fit(terms, values, problem.rows, N)
    unseen = cross_validated(problem, fitted, stages, rng)
    inside = np.sqrt(((values - fitted.predicted) ** 2).mean())
    assert inside < unseen.after[0] < unseen.before[0]


GEAR = {effect.name: effect for effect in find_gear_effects()}


@pytest.fixture
def sweep():
    I_L = np.array([0.5, 1.0, 2.0, 4.749, 8.0, 12.0])
    torque = np.array([1.0, 5.0, 2.0, 8.0, 3.0, 6.0])
    return Sweep(np.full(6, 2.65e-4), I_L, np.full(6, 3.490659e-3), torque)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("reflected_inertia", {"N": 50.0}),
        ("wind_up", {"compliance": 2e-4}),
        ("held_motor", {}),
    ],
)
def test_a_sweep_is_traced_to_its_effect(name, values, sweep, rng):
    true = GEAR[name].changed(sweep, **values).deviation
    measured = true + 0.02 * np.abs(true).mean() * rng.normal(size=6)
    found = diagnose_sweep(sweep, measured)
    assert found.verdict is Verdict.EXPLAINED
    assert found.effects[0].effect == name
    assert found.error.after.rms < 0.2 * found.error.before.rms
    assert found.error.after.held_out_rms >= found.error.after.rms * 0.999
    for key, value in values.items():
        low, high = found.effects[0].intervals[key]
        assert low * 0.98 <= value <= high * 1.02


def test_effects_that_scale_the_deviation_are_rivals(sweep, rng):
    true = 0.6 * sweep.deviation
    found = diagnose_sweep(sweep, true * (1 + 0.01 * rng.normal(size=6))).effects[0]
    assert {found.effect, *(rival.effect for rival in found.rivals)} >= {"gap", "friction_hold"}


@pytest.mark.slow
def test_a_sweep_that_follows_the_model_holds_nothing(sweep):
    alarms = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        measured = sweep.deviation + 1e-8 * rng.normal(size=6)
        alarms += diagnose_sweep(sweep, measured).verdict is not Verdict.NOTHING
    assert alarms <= 7


def test_a_sweep_that_no_effect_fits_is_unexplained(sweep):
    measured = -1e-3 * np.array([1.0, 9.0, 1.0, 9.0, 1.0, 9.0])
    found = diagnose_sweep(sweep, measured, uncertainty=np.full(6, 1e-5))
    assert found.verdict is Verdict.UNEXPLAINED


def test_a_sweep_says_what_it_cannot_tell(sweep):
    one = Sweep(sweep.I_m, np.full(6, 2.0), sweep.gap)
    notes = " ".join(diagnose_sweep(one, np.full(6, -1e-3)).notes)
    assert "one ratio of inertias only" in notes
    assert "wind-up was not tried" in notes
    with pytest.raises(DataError, match="2 reversals"):
        diagnose_sweep(one, np.zeros(2))


def test_the_smallest_travel_lies_where_the_power_crosses_80_percent():
    travels = np.geomspace(1, 20, 9)
    found = _crossing(lambda travel: travel / 20, travels, sigma=0.002)
    assert found == pytest.approx(16 * 0.002)
    assert _crossing(lambda _: 0.79, travels, sigma=1.0) is None
    assert _crossing(lambda _: 0.8, travels, sigma=0.5) == 0.5


def test_a_movement_fits_a_direction_within_its_uncertainty_in_any_unit():
    directions = {"joint 1": np.array([-300.0, 400.0])}
    movement, uncertainty = np.array([-0.03, 0.041]), np.array([0.0004, 0.0004])
    for factor in (1.0, 1000.0):
        assert match(factor * movement, factor * uncertainty, directions)[0] == "joint 1"
        off = factor * (movement + np.array([0.004, 0.003]))
        assert match(off, factor * uncertainty, directions)[0] is None


def test_simulated_skewness_is_that_of_the_readings_in_any_unit(rng):
    skewed = rng.gamma(4.0, size=30)
    assert _skewed(1000 * skewed, 1, (30, 5)) == pytest.approx(_skewed(skewed, 1, (30, 5)))
    drawn = _skewed(skewed, 1, (4000, 5))
    even = _skewed(np.arange(30.0), 1, (4000, 5))
    assert stats.skew(drawn.ravel()) > stats.skew(even.ravel()) + 0.5


def test_a_planned_test_finds_smaller_effects_with_more_cycles_and_a_finer_dial():
    effects = [effect for effect in find_effects() if effect.name in {"step", "linear_drift"}]
    found = {}
    for label, n, division in (("plan", 20, 0.03), ("longer", 50, 0.03), ("finer", 20, 0.01)):
        plan = PlannedRun(Conditions(np.arange(n)), sigma=0.01, division=division)
        found[label] = smallest_effects(plan, effects, np.random.default_rng(1))
    for name in ("step", "linear_drift"):
        assert 0.01 < found["plan"][name] < 0.07
        assert found["longer"][name] < found["plan"][name]
        assert found["finer"][name] < found["plan"][name]


def test_a_slow_warm_up_is_known_to_look_like_a_drift():
    alike = {a.effects for a in collinear(find_effects(), CONDITIONS)}
    assert ("linear_drift", "warm_up") in alike
    assert ("linear_drift", "periodic") not in alike
