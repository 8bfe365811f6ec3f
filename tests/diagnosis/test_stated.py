"""What is stated of a name: sure is only one that leaves scatter alone."""

import numpy as np
import pytest

from scara_iso.diagnosis import UNKNOWN
from scara_iso.diagnosis.engine.fit import HeldOut, Term, fit, problem_of
from scara_iso.diagnosis.engine.search import chosen
from scara_iso.diagnosis.findings import UNSURE
from scara_iso.diagnosis.held_out import without_gain
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.effects import Shape, find_effects
from scara_iso.run import Axis, Run

J = np.arange(30)
CHIRP = 3 * np.sin(2 * np.pi * (J / 30 + 2.5 * (J / 30) ** 2))


@pytest.fixture
def stated(rng):
    """Return what is found in a course along X, and one along Y."""
    scatter = rng.normal(0, 2, (2, 30))

    def of(*courses, **columns):
        axes = {
            name: Axis(name, np.rint(scatter[k] + course), resolution=1.0)
            for k, (name, course) in enumerate(zip("XY", courses, strict=False))
        }
        found = diagnose_readings(Run(J + 2, axes, covariates=columns))
        return {one.effect: one.probability for one in found.effects}

    return of


STEP, DRIFT = 40 * (J > 11), 1.5 * J


def test_a_name_is_sure_where_it_leaves_scatter(stated):
    assert stated(STEP)["step"] > 0.9
    assert stated(DRIFT)["linear_drift"] > 0.9


def test_courses_that_share_an_axis_may_be_one_of_no_name(stated):
    found = stated(STEP + 2 * DRIFT)
    assert len(found) == 2
    assert max(found.values()) == UNSURE


def test_courses_of_different_axes_are_sure(stated):
    found = stated(STEP, 10 * np.sin(2 * J))
    assert found.keys() == {"step", "periodic"}
    assert min(found.values()) > 0.9


def test_odd_readings_and_recorded_columns_leave_a_course_sure(stated):
    assert stated(STEP + 200 * (J == 20))["step"] > 0.9
    load = J % 3.0
    found = stated(2 * DRIFT + 20 * load, payload_kg=load)
    assert found.keys() == {"linear_drift", "compliance"}
    assert min(found.values()) > 0.9


def test_what_turns_back_at_each_cycle_has_no_sure_name(stated):
    """An alternation from mid-run on, and a memory of the other sign, are no correction."""
    turns, innovations = (-1.0) ** J, 5 * np.random.default_rng(7).standard_normal(30)
    memory = np.array([innovations[: k + 1] @ (-0.9) ** np.arange(k, -1, -1.0) for k in range(30)])
    for course in (7 * turns * (J > 14), memory):
        found = stated(course)
        assert found
        assert max(found.values()) <= UNSURE


def test_a_misfit_leaves_no_slow_course_sure(stated):
    assert stated(300 * (1 - np.exp(-J / 8)) + 40 * np.exp(-J / 2))["warm_up"] <= UNSURE


@pytest.mark.parametrize("seed", [4, 76])
def test_a_sine_that_quickens_has_no_sure_name(seed):
    scatter = np.random.default_rng(seed).normal(size=30)
    run = Run(J + 2, {"Z": Axis("Z", np.round(CHIRP + scatter), resolution=1.0)})
    problem = problem_of(run, directions={}, effects=find_effects())
    choice = chosen(problem, (), np.random.default_rng(1))[0].choice
    assert choice.probability[choice.best] < 0.9
    assert UNKNOWN in {choice.best, *(rival.effect for rival in choice.rivals)}


def test_a_column_that_changes_once_has_a_step_as_rival(stated):
    load = np.where(J > 14, 5.0, 2.0)
    assert stated(20 * (load == 5), payload_kg=load) == {"compliance": UNSURE}
    turns = np.where(J % 7 > 3, 5.0, 2.0)
    assert stated(20 * (turns == 5), payload_kg=turns)["compliance"] > 0.9


def test_two_speeds_do_not_tell_where_a_gap_is_crossed():
    scatter = np.random.default_rng(4).normal(0, 5, 30)
    speed = np.where(J > 14, 100.0, 50.0)
    axis = Axis("X", np.rint(scatter + 15 * (J > 14)), resolution=1.0)
    (found,) = diagnose_readings(Run(J + 2, {"X": axis}, covariates={"speed": speed})).effects
    assert found.effect == "coast_in_gap"
    assert found.parameters["full_at"] == 100
    assert found.parameters["size"]["X"] < 30


def of_three(seed, course):
    """Return what is found in a course along X beside two axes of scatter, sigma 5 divisions."""
    readings = np.random.default_rng(seed).normal(0, 5, (3, 30))
    readings[0] += course
    axes = {n: Axis(n, np.rint(x), resolution=1.0) for n, x in zip("XYZ", readings, strict=True)}
    return Run(J + 2, axes)


@pytest.mark.parametrize("seed", range(1, 7))
def test_a_drift_that_a_step_takes_back_is_found_on_its_axis(seed):
    found = diagnose_readings(of_three(seed, 3.6 * np.where(J < 18, J, J - 18)))
    assert {axis for one in found.effects for axis in one.axes} == {"X"}
    assert found.error.after.held_out_rms["X"] < 0.9 * found.error.before.held_out_rms["X"]


@pytest.mark.parametrize("seed", range(1, 4))
def test_what_one_dial_shows_along_a_joint_is_no_sure_contact(seed):
    along = {"joint 1": {"X": 1.0, "Y": 0.05}, "joint 2": {"X": 0.1, "Y": 1.0}}
    hat = of_three(seed, 25 * ((J > 7) & (J < 20)))
    found = diagnose_readings(hat, directions=along)
    assert all(one.probability <= UNSURE for one in found.effects if one.effect == "contact_side")


def test_an_axis_on_which_no_unseen_error_falls_is_left_out():
    problem = problem_of(of_three(1, 30 * (J > 11)), None, directions={}, effects=find_effects())
    step = Term("step", Shape((J > 11).astype(float)[:, np.newaxis]), np.array([True, True, False]))
    fitted = fit([step], problem.residual.values, problem.rows, 30)
    falls = HeldOut(np.array([2.0, 2.0, 2.0]), np.array([1.0, 2.0, 2.0]))
    assert without_gain(problem, fitted, falls)[0].moves.tolist() == [True, False, False]
    assert without_gain(problem, fitted, HeldOut(falls.before, falls.before))[0].moves[0]
    rises = HeldOut(np.ones(3), np.array([2.0, 0.5, 2.0]))
    assert without_gain(problem, fitted, rises)[0].moves.tolist() == [True, True, False]


def of_courses(seed, scatter, division, *courses):
    """Return what is found of the effects in courses along X, Y, Z [mm], by effect and axes."""
    readings = np.random.default_rng(seed).normal(0, scatter, (31, 3))
    for k, course in enumerate(courses):
        readings[:, k] += course
    shown = np.rint(readings[1:] / division) * division
    axes = {n: Axis(n, shown[:, k], resolution=division) for k, n in enumerate("XYZ")}
    return {
        (one.effect, one.axes): one.probability
        for one in diagnose_readings(Run(J + 2, axes)).effects
    }


C = np.arange(1, 32)


@pytest.mark.parametrize("seed", range(900, 904))
def test_two_courses_of_one_kind_on_two_axes_are_named_one_by_one(seed):
    found = of_courses(
        seed, 0.003, 0.001, 0.02 * np.sin(2 * np.pi * C / 6), 0, 0.02 * np.sin(2 * np.pi * C / 11)
    )
    assert found.keys() == {("periodic", ("X",)), ("periodic", ("Z",))}


@pytest.mark.parametrize("seed", [100, 102, 103])
def test_a_step_on_a_coarse_dial_hides_no_swing_of_another_axis(seed):
    found = of_courses(seed, 0.002, 0.01, 0.02 * (C >= 16), 0, 0.02 * np.sin(2 * np.pi * C / 6 + 1))
    assert {("step", ("X",)), ("periodic", ("Z",))} <= found.keys()


def test_one_division_is_no_sure_odd_reading():
    rng = np.random.default_rng(309)
    readings = rng.normal(0, 0.003, (31, 3))
    readings[:, 0] += np.cumsum(rng.normal(0, 0.004, 31))
    shown = np.rint((readings[1:] + np.array([0.5, 0.8, 0.3])) / 0.01) * 0.01
    axes = {n: Axis(n, shown[:, k], resolution=0.01) for k, n in enumerate("XYZ")}
    found = diagnose_readings(Run(J + 2, axes)).effects
    assert all(one.probability <= UNSURE for one in found if one.effect == "outlier")


@pytest.mark.parametrize("seed", [77001, 77007, 77008, 77011])
def test_a_name_of_several_axes_is_unsure_where_another_fits_one_of_them_better(seed):
    rng, k = np.random.default_rng(seed), np.arange(31)
    readings = {name: rng.normal(0, 4, 31) for name in "XYZ"}
    temperature = 22 + 3 * np.sin(k / 5) + rng.normal(0, 0.3, 31)
    readings["X"] += 3 * (temperature - temperature.mean())
    readings["Y"] += 20 * (k >= 12)
    axes = {name: Axis(name, np.rint(values)[1:], resolution=1.0)
            for name, values in readings.items()}  # fmt: skip
    found = diagnose_readings(Run(k[1:], axes, covariates={"temperature_C": temperature[1:]}))
    for one in found.effects:
        wrong = one.effect == "step" and "X" in one.axes
        assert not (wrong and one.probability > UNSURE)
        assert not wrong or "temperature" in {rival.effect for rival in one.rivals}


@pytest.mark.parametrize("seed", range(6))
def test_a_known_scatter_makes_no_name_of_two_axes_unsure(seed):
    rng = np.random.default_rng(seed)
    axes = {
        name: Axis(name, np.rint(rng.normal(0, 5, 30) + 40 * (J > 11)), resolution=1.0)
        for name in "XY"
    }
    (found,) = diagnose_readings(Run(J + 2, axes), sigma={"X": 5.0, "Y": 5.0}).effects
    assert found.effect == "step"
    assert found.probability > 0.9
