"""Likelihoods of rounded readings against numerical integration, and what they change."""

import numpy as np
import pytest
from scipy.special import ndtr, stdtr

from scara_iso.diagnosis.engine.evidence import constant
from scara_iso.diagnosis.engine.rounded import (
    LEAST_ON_DIAL,
    DialCourse,
    log_likelihoods,
    scatter_alone,
)
from scara_iso.diagnosis.readings import diagnose_readings as diagnose
from scara_iso.run import Axis, Run

N = 16
GAIN = 15.0


def integrated(y, column, F):
    """Return log marginal likelihoods of a constant, and of a constant and a column, by sums."""
    at = np.linspace(-20, 20, 241)
    apart, level = at[1] - at[0], at * N**-0.5
    alone, beside = [], []
    for s in np.geomspace(LEAST_ON_DIAL, 6, 40):

        def likelihood(mean):
            p = F((y + 0.5 - mean) / s) - F((y - 0.5 - mean) / s)  # noqa: B023
            return np.prod(np.maximum(p, 1e-300), axis=-1)

        alone.append(likelihood(level[:, None]).sum() * apart)
        both = likelihood(level[:, None, None] + at[None, :, None] * column)
        prior = np.exp(-0.5 * at**2 / (GAIN * s**2)) / np.sqrt(2 * np.pi * GAIN * s**2)
        beside.append((both * prior).sum() * apart**2)
    return np.log(np.sum(beside)) - np.log(np.sum(alone))


def student_4(x):
    """Return the distribution function of Student's t with four degrees of freedom."""
    share = 1 / (1 + x**2 / 4)
    return 0.5 + 0.375 * x * np.sqrt(share) * (1 - x**2 * share / 12)


def test_the_closed_form_is_that_distribution():
    x = np.linspace(-30, 30, 601)
    assert student_4(x) == pytest.approx(stdtr(4, x), abs=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize(("family", "F"), [(0, ndtr), (1, student_4)])
@pytest.mark.parametrize("scatter", [0.3, 0.8])
def test_the_bayes_factor_is_that_of_numerical_integration(family, F, scatter):
    rng = np.random.default_rng(4)
    y = np.round(0.4 + scatter * rng.normal(size=N) + 1.5 * (np.arange(N) >= 9))
    column = (np.arange(N) >= 9) - 7 / N
    column = column / np.linalg.norm(column)
    step = DialCourse(column[:, None], np.array([GAIN]), np.ones(N))
    found = log_likelihoods(y, np.full(N, 0.5), constant(N), [step, scatter_alone(N)])
    expected = integrated(y, column, F)
    assert found[0, family] - found[1, family] == pytest.approx(expected, abs=0.35)


def walk_by_filter(y, s, step):
    """Return the log likelihood of a rounded walk with scatter, its start anywhere, on a grid."""
    x = np.arange(y.min() - 3, y.max() + 3, 0.05)
    seen = ndtr((y[:, None] + 0.5 - x) / s) - ndtr((y[:, None] - 0.5 - x) / s)
    moves = np.exp(-0.5 * (np.subtract.outer(x, x) / step) ** 2) * 0.05 / np.sqrt(2 * np.pi) / step
    ahead = np.ones(len(x))
    for one in seen[:0:-1]:
        ahead = moves @ (one * ahead)
    return np.log((seen[0] * ahead).sum() * 0.05)


@pytest.mark.parametrize("variance", [1.0, 10.0])
def test_a_walk_along_the_stairs_of_the_dial_weighs_what_a_filter_gives(variance):
    y = np.repeat([0.0, 1.0, 2.0, 3.0], 10)
    n = len(y)
    apart = np.eye(n) - 1 / n
    values, vectors = np.linalg.eigh(apart @ np.minimum.outer(np.arange(n), np.arange(n)) @ apart)
    kept = variance * values > 0.05
    walk = DialCourse(vectors[:, kept], variance * values[kept], np.ones(n))
    found = log_likelihoods(y - y.mean(), np.full(n, 0.5), constant(n), [walk])[0, 0]
    scatters = np.geomspace(0.15, 0.6, 5)
    of_scatters = [walk_by_filter(y, s, variance**0.5 * s) for s in scatters]
    expected = np.logaddexp.reduce(of_scatters) + np.log(np.log(scatters[1] / scatters[0]))
    assert found + 0.5 * np.log(2 * np.pi / n) == pytest.approx(expected, abs=2.5)


def run_of(y, **recorded):
    axis = Axis("X", np.asarray(y, dtype=float), resolution=1.0)
    return Run(np.arange(1, len(y) + 1), {"X": axis}, covariates=recorded)


def effects_of(run):
    """Return the effects without the folds of cross-validation, which change no name."""
    return diagnose(run, held_out=run).effects


@pytest.mark.parametrize(("before", "after"), [(14, 16), (29, 16)])
def test_a_perfect_step_of_one_division_is_not_surely_a_step(before, after):
    (found,) = effects_of(run_of([0] * before + [1] * after))
    assert found.effect == "step"
    assert found.probability < 0.9
    assert found.rivals


LEVELS = [2, 1, 3, 3, 3, 4, *[-2] * 7, -1, -1, -2, -2, -1, -2, -1, 0, -1, 3, 4, 2, 2, 3, 3, 3, 3]
"""Readings with three changes of level, simulated."""


def test_no_name_is_sure_beside_several_levels_that_fit_better():
    found = effects_of(run_of(LEVELS))[0]
    assert found.probability < 0.9
    assert "unknown" in {rival.effect for rival in found.rivals}


def test_a_machine_that_heats_up_for_longer_than_its_test():
    rng, j = np.random.default_rng(3), np.arange(30)
    (found,) = effects_of(run_of(np.round(60 * (1 - np.exp(-j / 39)) + 0.4 * rng.normal(size=30))))
    assert found.effect == "warm_up"
    assert found.parameters["tau"] == pytest.approx(39, rel=0.15)


PROBE = [0, 0, 0, 1, 1, 2, 2, 2, 3, 3, *[5] * 9, *[6] * 11]
"""Touches of a probe while its machine heats and soaks, in divisions."""


def test_a_smooth_course_along_the_stairs_of_the_dial_is_a_warm_up_before_it_is_a_walk():
    assert effects_of(run_of(PROBE))[0].effect == "warm_up"


def test_two_levels_in_no_order_are_nearly_sure():
    rng = np.random.default_rng(3)
    y = np.round(0.7 * (rng.normal(size=30) + 7 * (rng.random(30) < 0.5)))
    (found,) = effects_of(run_of(y))
    assert found.effect == "contact_side"
    assert found.probability == 0.89  # two levels are no contact without evidence of it


def test_an_odd_reading_does_not_hide_what_else_moves():
    rng = np.random.default_rng(5)
    y = np.round(rng.normal(size=30) + 4 * (np.arange(30) >= 15))
    y[5] = 14
    assert "step" in {found.effect for found in effects_of(run_of(y))}
    y[5] = 25
    assert effects_of(run_of(y))


def test_a_recorded_approach_takes_the_place_of_alternation():
    rng = np.random.default_rng(6)
    side = np.where(np.arange(30) % 2, 1.0, -1.0)
    (found,) = effects_of(run_of(np.round(rng.normal(size=30) + 3 * side), approach=side))
    assert found.effect == "lost_motion"
    assert found.probability >= 0.8
    assert "contact_side" not in {rival.effect for rival in found.rivals}


def test_a_gap_that_grows_is_seen():
    rng = np.random.default_rng(7)
    side = np.where(np.arange(30) % 2, 1.0, -1.0)
    y = np.round(rng.normal(size=30) + (2 + 0.3 * np.arange(30)) * side)
    assert effects_of(run_of(y, approach=side))[0].effect == "gap_growth"


def test_a_strong_smooth_course_with_a_small_misfit_is_one_effect():
    y = [0, 22, 38, 50, 58, 64, 69, 73, 76, 78, 80, 81, 82, 83, 84, 84, 85, 85, 86, 86, 86, 87, 87,
         87, 87, 88, 88, 88, 88, 88]  # fmt: skip
    assert [found.effect for found in effects_of(run_of(y))] == ["warm_up"]


def test_a_machine_that_lags_behind_the_thermometer():
    rng = np.random.default_rng(8)
    heat = 20 + 6 * np.interp(np.arange(40), [0, 15, 18, 40], [0, 1, 1, 0])
    body = heat.copy()
    for j in range(1, 40):
        body[j] = body[j - 1] + (heat[j] - body[j - 1]) / 8
    y = np.round(rng.normal(size=40) + 6 * (body - 20))
    assert effects_of(run_of(y, temperature_C=heat))[0].effect == "temperature_lagged"


def test_something_comes_and_goes():
    j = np.arange(30)
    y = np.round(
        np.random.default_rng(9).normal(size=30) + 6 * np.exp(-0.5 * ((j - 14) / 2.5) ** 2)
    )
    assert effects_of(run_of(y))[0].effect == "transient"


def test_eight_readings_are_answered():
    y = np.round(np.random.default_rng(10).normal(size=8) + 4 * np.arange(8))
    assert effects_of(run_of(y))


@pytest.mark.slow
@pytest.mark.parametrize("scatter", [0.4, 2.0])
def test_the_completed_model_foretells_the_next_test(scatter):
    held = 0
    for seed in range(30):
        rng = np.random.default_rng([seed, 11])
        first, then = (
            np.round(rng.uniform(-0.5, 0.5) + scatter * rng.normal(size=30)) for _ in range(2)
        )
        if not np.ptp(first):
            continue
        foretold = diagnose(run_of(first)).repeatability.completed["X"]
        apart = np.abs(then - then.mean())
        held += foretold.interval[0] <= apart.mean() + 3 * apart.std(ddof=1) <= foretold.interval[1]
    assert held >= 25


def test_readings_of_which_nothing_is_left_tell_no_course_from_another():
    step = DialCourse(constant(8), np.ones(1), np.ones(8))
    found = log_likelihoods(np.zeros(8), np.zeros(8), constant(8), [step, scatter_alone(8)])
    assert not found.any()
