"""From a run to a verdict: what must be found, what must stay silent, what cannot be told."""

import csv
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from scara_iso.base.errors import DataError
from scara_iso.diagnosis import Verdict
from scara_iso.diagnosis.readings import diagnose_readings as diagnose
from scara_iso.effects import Conditions, find_effects
from scara_iso.run import Axis, Run

N = 30
CYCLE = np.arange(2, N + 2)
J = np.arange(N)
FIXTURES = Path(__file__).parents[1] / "fixtures"


def make_run(columns, *, resolution=0.001, covariates=None, sigma=0.005):
    """Return a run of axes given in scatters, read on a dial."""
    axes = {
        name: Axis(name, np.round(course * sigma / resolution) * resolution, resolution=resolution)
        for name, course in columns.items()
    }
    return Run(CYCLE, axes, covariates=covariates or {})


def named(run, **known):
    """Return the diagnosis without the folds of cross-validation, which change no verdict."""
    return diagnose(run, held_out=run, **known)


COURSES = {
    "step": 5.0 * (J >= 12),
    "linear_drift": 7.0 * J / (N - 1),
    "warm_up": 9.0 * (1 - np.exp(-J / 4)),
    "periodic": 4.0 * np.sin(2 * np.pi * J / 7.3 + 0.4),
    "contact_side": 4.0 * (J % 2),
}


@pytest.mark.parametrize("name", COURSES)
def test_a_large_effect_is_found_and_named(name, rng):
    found = diagnose(make_run({"X": COURSES[name] + rng.normal(size=N), "Y": rng.normal(size=N)}))
    assert found.verdict is Verdict.EXPLAINED
    assert found.effects[0].effect == name
    assert "X" in found.effects[0].axes
    assert found.effects[0].p_value < 0.01
    assert found.error.after.held_out_rms["X"] < found.error.before.held_out_rms["X"]
    assert found.error.after.rms["X"] <= found.error.after.held_out_rms["X"]
    assert found.repeatability.with_effect_removed["X"] < found.repeatability.measured["X"]


PAIRS = {
    ("periodic", "step"): {"X": 2.5 * np.sin(2 * np.pi * J / 6) + 5.0 * (J >= 18)},
    ("step", "warm_up"): {"X": 8.0 * (1 - np.exp(-J / 4)) + 6.0 * (J >= 18)},
    ("step", "step"): {"X": 5.0 * (J >= 10), "Y": 5.0 * (J >= 20)},
}


@pytest.mark.slow
@pytest.mark.parametrize("names", PAIRS)
def test_two_effects_at_once_are_found_one_after_another(names):
    """One after another alone, they are a random course or unknown in nine of ten runs."""
    right = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        noisy = {axis: course + rng.normal(size=N) for axis, course in PAIRS[names].items()}
        found = named(make_run(noisy, resolution=0.005))
        right += sorted(one.effect for one in found.effects) == sorted(names)
    assert right >= 4


@pytest.mark.parametrize("names", [(), ("linear_drift",), ("random_walk",), ("contact_side",)])
def test_a_catalogue_may_be_short_of_shapes(names, rng):
    """A course that goes down and comes up again fits none of them."""
    catalogue = [effect for effect in find_effects() if effect.name in names]
    vee = 1.3 * np.abs(J - 14.5) + rng.normal(size=N)
    found = named(make_run({"X": vee}), effects=catalogue)
    assert found.verdict is Verdict.UNEXPLAINED


def test_parameters_are_those_of_the_data(rng):
    step = named(make_run({"X": 8.0 * (J >= 12) + rng.normal(size=N)})).effects[0]
    assert step.parameters["at_cycle"] == 14
    assert step.parameters["size"]["X"] == pytest.approx(0.04, abs=0.006)
    assert step.standard_errors["size"]["X"] == pytest.approx(0.005 * 2 / np.sqrt(N), rel=0.4)
    sine = named(make_run({"X": COURSES["periodic"] + 0.3 * rng.normal(size=N)})).effects[0]
    assert sine.parameters["period"] == pytest.approx(7.3, rel=0.05)
    assert sine.parameters["size"]["X"] == pytest.approx(0.02, rel=0.15)


@pytest.mark.parametrize(
    ("column", "name"),
    [
        ("approach", "lost_motion"),
        ("payload_kg", "compliance"),
        ("temperature_C", "temperature"),
        ("humidity", "covariate"),
    ],
)
def test_a_covariate_that_acts_is_named(column, name, rng):
    recorded = {
        "approach": rng.permutation(np.repeat([-1.0, 1.0], N // 2)),
        "payload_kg": rng.permutation(np.repeat([1.0, 2.0, 3.0], N // 3)),
        "temperature_C": 20 + rng.random(N),
        "humidity": rng.random(N),
    }
    acting = recorded[column] - recorded[column].mean()
    course = 2.5 * acting / acting.std() + rng.normal(size=N)
    found = named(make_run({"Z": course}, covariates=recorded))
    assert [effect.effect for effect in found.effects] == [name]


def test_scatter_that_doubles_is_named(rng):
    course = rng.normal(size=N) * np.where(J < 15, 1.0, 6.0)
    found = named(make_run({"X": course}))
    assert found.effects[0].effect == "scatter_change"
    assert 11 <= found.effects[0].parameters["at_cycle"] <= 22


def test_sides_in_no_order_are_found_on_the_dial(rng):
    sides = rng.permutation(np.repeat([0.0, 8.0], N // 2))
    found = named(make_run({"X": sides + rng.normal(size=N)}))
    assert found.effects[0].effect == "contact_side"
    assert found.effects[0].parameters["size"]["X"] == pytest.approx(0.04, rel=0.2)


def test_a_fold_closer_than_the_dial_rounds_holds_no_sides():
    # Readings in tenths of the stated division: beside the step, a fold spreads by 0.2 of it.
    rng = np.random.default_rng(18)
    at = rng.integers(5, 25)
    y = np.where(np.arange(30) >= at, 5, 0) + np.round(rng.normal(0, 0.05, 30), 1)
    found = named(Run(CYCLE, {"X": Axis("X", 0.01 * y, resolution=0.01)}))
    assert found.effects[0].effect == "step"


def test_a_digit_slip_is_an_outlier_and_a_smaller_one_a_flag(rng):
    slip = rng.normal(size=N)
    slip[7] += 60
    gross = named(make_run({"X": slip}))
    assert gross.effects[0].effect == "outlier"
    assert gross.effects[0].parameters["at_cycle"] == CYCLE[7]
    slip[7] -= 53
    small = named(make_run({"X": slip}))
    assert small.verdict is Verdict.NOTHING
    assert [(flag.axis, flag.cycle) for flag in small.flags] == [("X", CYCLE[7])]


def test_two_gross_readings_to_either_side_are_two_outliers_for_sure(rng):
    slips = rng.normal(size=N)
    slips[7], slips[20] = 40, -40
    found = named(make_run({"X": slips}))
    (odd,) = found.effects
    assert odd.effect == "outlier"
    assert odd.parameters["cycles"] == (CYCLE[7], CYCLE[20])
    assert odd.probability >= 0.9


def test_an_odd_reading_of_a_probe_beside_wider_scatter_is_not_a_sure_outlier():
    # Fifteen touches of a soaking probe (fixtures/probe_thermal, superpinda, 1068), in divisions.
    z = np.array([56, 56, 56, 55, 55, 56, 56, 56, 56, 56, 54, 56, 56, 56, 53.0])
    found = named(Run(np.arange(1, 16), {"Z": Axis("Z", z, resolution=1.0)}))
    (odd,) = found.effects
    assert "outlier" in {odd.effect, *(rival.effect for rival in odd.rivals)}
    assert odd.probability < 0.9


@pytest.mark.slow
def test_scatter_alone_is_silent_on_most_seeds():
    """4 alarms or more of 40 have a probability of 0.14 at 5 %; this set of seeds is fixed."""
    alarms = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        scatter = rng.normal(size=(N, 2)) if seed % 2 else rng.standard_t(5, size=(N, 2))
        run = make_run({"X": scatter[:, 0], "Y": scatter[:, 1]}, resolution=0.005)
        alarms += named(run).verdict is not Verdict.NOTHING
    assert alarms <= 4


@pytest.mark.slow
def test_a_course_in_no_catalogue_stays_unexplained():
    said = Counter()
    for seed in range(10):
        rng = np.random.default_rng(seed)
        course = 6 * np.abs(2 * J / (N - 1) - 1) ** 2 + rng.normal(size=N)
        found = named(make_run({"X": course}))
        said[found.verdict] += 1
        if found.verdict is Verdict.UNEXPLAINED:
            assert found.candidates
    assert said[Verdict.UNEXPLAINED] >= 7


@pytest.mark.parametrize("size", [6.0, 9.0])
def test_a_clean_step_has_no_side_of_contact_for_a_rival(size):
    for seed in range(4):
        rng = np.random.default_rng(seed)
        found = named(make_run({"X": rng.normal(size=N) + size * (J >= 11)}))
        first = found.effects[0]
        assert first.effect == "step"
        assert "contact_side" not in [rival.effect for rival in first.rivals]


@pytest.mark.parametrize("period", [6.0, 7.3])
def test_a_large_sine_of_any_period_is_named_once(period, rng):
    sine = 12 * np.sin(2 * np.pi * J / period + 1)
    found = named(make_run({"X": sine + rng.normal(size=N)}))
    assert [effect.effect for effect in found.effects] == ["periodic"]
    assert found.effects[0].parameters["period"] == pytest.approx(period, rel=0.01)


@pytest.mark.slow
def test_three_levels_are_two_steps_or_nothing_sure(rng):
    levels = np.repeat([0.0, 7.0, -4.0], 10)
    steps = 0
    for _ in range(6):
        found = named(make_run({"X": levels + rng.normal(size=N)}))
        assert found.verdict is not Verdict.NOTHING
        steps += [one.effect for one in found.effects] == ["step", "step"]
        for one in found.effects:
            assert one.effect == "step" or one.probability < 0.9
            if one.effect == "step":
                assert min(abs(one.parameters["at_cycle"] - at) for at in (12, 22)) <= 1
    assert steps >= 1


def test_a_known_scatter_sharpens_the_naming_and_is_checked(rng):
    run = make_run({"X": 3.0 * (J >= 12) + rng.normal(size=N)})
    without, known = named(run), named(run, sigma={"X": 0.005})
    assert known.p_value == without.p_value
    assert known.effects[0].effect == "step"
    assert known.effects[0].probability > without.effects[0].probability
    assert known.notes == without.notes
    assert "0.001 as stated" in named(run, sigma={"X": 0.001}).notes[-1]
    with pytest.raises(DataError, match="known scatter"):
        named(run, sigma={"X": -1.0})


def test_two_effects_are_found_one_after_the_other(rng):
    approach = rng.permutation(np.repeat([-1.0, 1.0], N // 2))
    course = 4 * approach + 6.0 * (J >= 14) + rng.normal(size=N)
    found = named(make_run({"X": course}, covariates={"approach": approach}))
    assert {effect.effect for effect in found.effects} == {"lost_motion", "step"}
    assert found.verdict is Verdict.EXPLAINED


def test_the_joint_is_named_by_the_direction(rng):
    course = 6.0 * (J >= 13)
    run = make_run({"X": 0.8 * course + rng.normal(size=N), "Y": 0.6 * course + rng.normal(size=N)})
    arm = {"joint 1": {"X": 0.8, "Y": 0.6}, "joint 2": {"X": -0.6, "Y": 0.8}}
    effect = named(run, directions=arm).effects[0]
    assert effect.joint == "joint 1"
    assert effect.angles["joint 1"] < 10
    assert effect.angles["joint 2"] > 70


def test_shift_scale_and_order_of_axes_change_nothing(rng):
    columns = {"X": COURSES["warm_up"] + rng.normal(size=N), "Y": rng.normal(size=N)}
    one = diagnose(make_run(columns))
    moved = Run(CYCLE, {
        name: Axis(name, 1000 * axis.readings + 7, resolution=1000 * axis.resolution)
        for name, axis in make_run(columns).axes.items()
    })  # fmt: skip
    other = diagnose(moved)
    assert other.effects[0].effect == one.effects[0].effect
    assert other.p_value == one.p_value
    assert other.effects[0].probability == pytest.approx(one.effects[0].probability, rel=1e-6)
    assert other.error.after.held_out_rms["X"] == pytest.approx(
        1000 * one.error.after.held_out_rms["X"]
    )


@pytest.mark.parametrize("name", [*sorted(COURSES.keys() - {"contact_side"}), "temperature"])
def test_found_parameters_give_the_course_back(name, rng):
    recorded = {"humidity": rng.random(N), "temperature_C": 20 + rng.random(N)}
    course = COURSES.get(name, 12 * (recorded["temperature_C"] - 20))
    run = make_run({"X": course + rng.normal(size=N)}, covariates=recorded)
    found = diagnose(run)
    assert [e.effect for e in found.effects] == [name]
    effect = next(e for e in find_effects() if e.name == name)
    conditions = Conditions(run.cycle, recorded)
    given = {
        k: v["X"] if isinstance(v, dict) else v for k, v in found.effects[0].parameters.items()
    }
    series = effect.series(conditions, given, rng)
    predicted = found.series.predicted_after["X"]
    np.testing.assert_allclose(series - series.mean(), predicted - predicted.mean(), atol=1e-9)


def test_same_input_same_result(rng):
    run = make_run({"X": COURSES["step"] + rng.normal(size=N)})
    assert repr(diagnose(run).effects) == repr(diagnose(run).effects)


def test_a_model_that_holds_the_effect_leaves_nothing(rng):
    course = COURSES["warm_up"] + rng.normal(size=N)
    run = make_run({"X": course})
    predicted = {"X": COURSES["warm_up"] * 0.005}
    found = diagnose(run, predicted)
    assert found.verdict is Verdict.NOTHING
    assert found.series.predicted_before["X"].std() == pytest.approx(
        np.std(predicted["X"]), rel=1e-9
    )
    assert found.error.before.rms["X"] < 0.5 * diagnose(run).error.before.rms["X"]


def test_a_second_run_measures_the_held_out_error(rng):
    first, second = (make_run({"X": COURSES["linear_drift"] + rng.normal(size=N)}) for _ in "ab")
    found = diagnose(first, held_out=second)
    course = second.axes["X"].readings - second.axes["X"].readings.mean()
    assert found.error.before.held_out_rms["X"] == pytest.approx(np.sqrt((course**2).mean()))
    assert found.error.after.held_out_rms["X"] == pytest.approx(0.005, rel=0.5)
    with pytest.raises(DataError, match="lacks X"):
        diagnose(first, held_out=make_run({"Y": course / 0.005}))


def test_published_table_holds_one_shift_in_y():
    Y = [81] * 14 + [80] * 16
    Y[19] = Y[25] = 81
    X = [11, 9, 10, 9, 9, 9, 10, 11, 9, 10, 10, 10, 10, 9, 10, 10, 10, 10, 10, 10, 9, 9, 10, 10,
         9, 10, 10, 10, 10, 9]  # fmt: skip
    run = Run(np.arange(1, 31), {
        name: Axis(name, np.array(values) / 100, resolution=0.01)
        for name, values in (("X", X), ("Y", Y))
    })  # fmt: skip
    found = diagnose(run)
    assert [(e.effect, e.axes) for e in found.effects] == [("step", ("Y",))]
    assert found.effects[0].parameters["at_cycle"] == 15
    assert 0.5 < found.effects[0].probability <= 0.9
    assert "linear_drift" in {rival.effect for rival in found.effects[0].rivals}
    assert found.repeatability.measured["Y"] == pytest.approx(0.0059926, abs=1e-6)
    assert found.repeatability.measured["XY"] == pytest.approx(0.0140566, abs=1e-6)


def probe_window(name):
    with (FIXTURES / "probe_thermal" / "windows.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["window"] == name][1:]
    z, time = (np.array([float(row[k]) for row in rows]) for k in ("Z", "time_s"))
    return Run(CYCLE, {"Z": Axis("Z", z, resolution=0.00125)}, covariates={"time_s": time})


def test_a_real_probe_is_silent_while_cold():
    assert diagnose(probe_window("cold")).verdict is Verdict.NOTHING


@pytest.mark.parametrize("window", ["heating", "soak"])
def test_a_real_probe_drifts_while_its_bed_heats(window):
    found = diagnose(probe_window(window), held_out=probe_window("heating_next"))
    assert found.verdict is Verdict.EXPLAINED
    assert found.effects[0].effect in {"linear_drift", "warm_up"}
    assert found.error.after.rms["Z"] < 0.5 * found.error.before.rms["Z"]
    assert found.error.after.held_out_rms["Z"] < found.error.before.held_out_rms["Z"]


@pytest.mark.parametrize(("size", "noise", "copied"), [(1e5, 1e-3, True), (1e-2, 1e-6, False)])
def test_a_copy_differs_by_its_last_digits_whatever_its_size(size, noise, copied, rng):
    x = size * rng.normal(size=N)
    y = 3 * x + noise * rng.normal(size=N)
    found = diagnose(Run(CYCLE, {"X": Axis("X", x), "Y": Axis("Y", y)}))
    assert ("Y is an exact function of X and adds nothing to it" in found.notes) is copied


def test_two_axes_of_one_large_effect_are_no_copies(rng):
    """A reversal of two hundred scatters: the axes correlate at 0.9999 and more, and differ."""
    side = rng.choice([-1.0, 1.0], N)
    columns = {"X": -120 * side + rng.normal(size=N), "Y": 160 * side + rng.normal(size=N)}
    arm = {"joint 1": {"X": -0.6, "Y": 0.8}, "joint 2": {"X": -1.0, "Y": 0.0}}
    found = named(make_run(columns, covariates={"approach": side}), directions=arm)
    assert not any("exact function" in note for note in found.notes)
    assert found.effects[0].axes == ("X", "Y")
    assert found.effects[0].joint == "joint 1"


def test_a_movement_along_two_directions_at_once_names_none():
    rng = np.random.default_rng(1)
    run = make_run({"X": 6.0 * (J >= 13) + rng.normal(size=N), "Z": rng.normal(size=N)})
    arm = {"joint 1": {"X": -0.6, "Y": 0.8}, "joint 2": {"X": -1.0, "Y": 0.0}}
    found = named(run, directions=arm).effects[0]
    assert max(found.angles.values()) < 1
    assert found.joint is None


def test_a_second_run_may_stand_still(rng):
    first = make_run({"X": COURSES["step"] + rng.normal(size=N)})
    still = Run(CYCLE, {"X": Axis("X", np.full(N, 0.3), resolution=0.001)})
    found = diagnose(first, held_out=still)
    assert found.error.before.held_out_rms["X"] == pytest.approx(0.0, abs=1e-12)
    assert found.error.after.held_out_rms["X"] > 0.005


def test_two_divisions_do_not_tell_a_size(rng):
    shows = np.where(J < 14, 0.02, 0.01)
    shows[[20, 25]] = 0.02
    coarse = Run(CYCLE, {"X": Axis("X", shows, resolution=0.01)})
    assert any("only two neighbouring divisions in X" in line
               for line in named(coarse).effects[0].unidentified)  # fmt: skip
    fine = named(make_run({"X": COURSES["step"] + rng.normal(size=N)}))
    assert not any("neighbouring" in line for line in fine.effects[0].unidentified)


def test_too_few_cycles_are_refused():
    run = Run(np.arange(7), {"X": Axis("X", np.arange(7.0))})
    with pytest.raises(DataError, match="7 usable cycles"):
        diagnose(run)


def test_stuck_axes_are_left_out_or_refused(rng):
    flat = np.zeros(N)
    with pytest.raises(DataError, match="no axis moves"):
        diagnose(make_run({"X": flat}))
    found = diagnose(make_run({"X": flat, "Y": rng.normal(size=N)}))
    assert any(note.startswith("X never moves") for note in found.notes)
    assert found.repeatability.measured["X"] == 0
    assert set(found.error.before.rms) == {"Y"}


def test_columns_that_say_nothing_are_named(rng):
    course = rng.normal(size=N)
    covariates = {
        "speed": np.full(N, 0.5),
        "counter": 3.0 * CYCLE + 1,
        "temperature_C": course,
        "temperature_F": 32 + 1.8 * course,
    }
    run = make_run({"X": rng.normal(size=N)}, covariates=covariates)
    doubled = Run(CYCLE, {**run.axes, "Y": Axis("Y", 2 * run.axes["X"].readings)},
                  covariates=covariates)  # fmt: skip
    notes = " / ".join(diagnose(doubled).notes)
    assert "speed is constant" in notes
    assert "counter only copies the cycle number" in notes
    assert "temperature_F and temperature_C are exact functions of each other" in notes
    assert "Y is an exact function of X" in notes


def test_a_model_of_another_robot_is_refused(rng):
    run = make_run({"X": rng.normal(size=N)})
    with pytest.raises(DataError, match="predicts Z"):
        diagnose(run, {"Z": np.zeros(N)})
    with pytest.raises(DataError, match="not one prediction"):
        diagnose(run, {"X": np.zeros(N - 1)})


def test_several_poses_are_no_single_diagnosis(rng):
    run = Run(
        np.tile(CYCLE, 2), {"X": Axis("X", rng.normal(size=2 * N))}, pose=np.repeat(["P1", "P2"], N)
    )
    with pytest.raises(DataError, match="several poses"):
        diagnose(run)


def test_an_axis_that_is_largely_rounding_says_so(rng):
    found = diagnose(make_run({"X": rng.normal(size=N)}, sigma=0.0005))
    assert any(note.startswith("X: ") and "rounding" in note for note in found.notes)
    assert found.shares["X"].resolution + found.shares["X"].unexplained == pytest.approx(1.0)


@pytest.mark.parametrize(
    "course",
    [6 * (1 - np.exp(-J / 7.1)), 3 * np.sin(2 * np.pi * J / 7.7 + 0.5)],
    ids=["warm_up", "periodic"],
)
def test_a_second_run_is_met_by_parameters_between_those_of_the_grid(course, rng):
    first, second = (make_run({"X": course + rng.normal(size=N)}) for _ in "ab")
    found = diagnose(first, held_out=second)
    left = second.axes["X"].readings - found.series.predicted_after["X"]
    assert found.error.after.held_out_rms["X"] == pytest.approx(left.std(), rel=1e-6)
    assert found.error.after.held_out_rms["X"] < 0.75 * found.error.before.held_out_rms["X"]


def test_a_second_run_without_the_column_that_acts_is_refused(rng):
    warm = {"temperature_C": 20 + rng.normal(size=N)}
    first = make_run({"X": 5 * warm["temperature_C"] + rng.normal(size=N)}, covariates=warm)
    with pytest.raises(DataError, match="second table lacks temperature_C"):
        diagnose(first, held_out=make_run({"X": rng.normal(size=N)}))


def test_an_axis_that_copies_another_has_its_effects(rng):
    course = COURSES["step"] * 2 + rng.normal(size=N)
    found = diagnose(make_run({"X": course, "Y": course}))
    RP = found.repeatability
    assert RP.with_effect_removed["Y"] == pytest.approx(RP.with_effect_removed["X"])
    assert RP.model_after["Y"] == pytest.approx(RP.model_after["X"])


def test_scatter_changes_on_the_axes_where_it_does(rng):
    after = np.where(J < 15, 1.0, 5.0)
    axes = {name: rng.normal(size=N) * after for name in "XY"} | {"Z": rng.normal(size=N)}
    (found,) = diagnose(make_run(axes)).effects
    assert (found.effect, found.axes) == ("scatter_change", ("X", "Y"))
