"""What is on no list: structure without a name, odd readings, and names that are too sure.

Readings of fixed seeds. `--hold-out` names the table itself: it spares the folds of
cross-validation, which change no verdict.
"""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from asked import ask, given, names

from scara_iso import diagnose
from scara_iso.commands import main
from scara_iso.diagnosis import Verdict
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.run import Axis, Run

EXAMPLES = Path(__file__).parents[2] / "examples"
J = np.arange(31)
U = J / 30
DIVISION = 0.001
SIGMA = 0.005


def chirp(phase):
    """Return a sine whose period shrinks from 12 to 3 cycles."""
    return np.sin(2 * np.pi * (31 / 12 * U + (31 / 3 - 31 / 12) * U**2 / 2) + phase)


VEE = 2 * np.abs(2 * U - 1) - 1
TWO_BUMPS = 2 * (np.exp(-(((J - 8) / 2) ** 2) / 2) + np.exp(-(((J - 22) / 2) ** 2) / 2)) - 1
UNEVEN_SQUARE = np.where((J < 4) | ((J >= 10) & (J < 13)) | ((J >= 20) & (J < 28)), 1, -1)
GROWING_SINE = 1.6 * U * np.sin(2 * np.pi * J / 6)
BEAT = np.sin(2 * np.pi * J / 4.3) * np.cos(2 * np.pi * J / 24)


def scattered(seed, course):
    """Return readings of a course in units of the scatter."""
    return 0.5 + SIGMA * (course + np.random.default_rng(seed).normal(size=len(J)))


def readings(path, columns, head=("# unit: mm", f"# resolution: {DIVISION}")):
    """Write columns on the dial, numbered from 1."""
    rows = zip(*columns.values(), strict=True)
    lines = [f"{k},{','.join(f'{v:.3f}' for v in row)}" for k, row in enumerate(rows, 1)]
    path.write_text("\n".join([*head, ",".join(["cycle", *columns]), *lines]) + "\n")
    return path


@pytest.fixture
def path(folder):
    return folder / "run.csv"


def diagnosed(path, *options):
    """Return what `diagnose` says, as an object."""
    answer = ask("diagnose", path, "--json", "--hold-out", path, *options)
    given(answer.code == 0)
    return answer.document


def sure(found, *effects, at_least=0.9):
    """Return the names, of these effects or of all, that are this probable."""
    return [
        effect["effect"]
        for effect in found["effects"]
        if effect["probability"] >= at_least and (not effects or effect["effect"] in effects)
    ]


# ---- structure that passes for scatter

PHASES = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)


@pytest.mark.parametrize("seed", range(6))
def test_a_chirp_is_not_scatter(seed, path):
    readings(path, {"X": scattered(seed, 3.5 * chirp(PHASES[seed]))})
    assert diagnosed(path)["verdict"] != "nothing-to-explain"


def test_a_chirp_is_surely_no_contact_side(path):
    readings(path, {"X": scattered(18, 5 * chirp(4))})
    assert not sure(diagnosed(path))


@pytest.mark.slow
def test_a_beat_is_seldom_scatter(path):
    scatter = np.random.default_rng(1).normal(size=(20, 31))
    runs = [
        Run(J + 1, {"X": Axis("X", np.round(SIGMA * (4.2 * BEAT + one), 3), resolution=DIVISION)})
        for one in scatter
    ]
    found = [diagnose_readings(run) for run in runs]
    assert sum(one.verdict is not Verdict.NOTHING for one in found) >= 14


LEVELS = np.random.default_rng(8).permuted(np.tile(np.linspace(0, 7, 8), (10, 1)), axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("recurring", "least"),
    [([[7, 0, 0, 0, 0]], 9), ([[7, 0, 0, 0, 0, 0]], 7), (LEVELS[:, 1:], 9), (LEVELS, 9)],
)
def test_a_course_that_comes_round_is_seldom_scatter_and_is_learned(recurring, least):
    scatter = np.random.default_rng(5).normal(size=(10, 30))
    courses = np.tile(recurring, (10 // len(recurring), 8))[:, :30]
    found = [
        diagnose_readings(
            Run(J[1:] + 1, {"X": Axis("X", np.round(SIGMA * x, 3), resolution=DIVISION)})
        )
        for x in courses + scatter
    ]
    assert sum(one.verdict is not Verdict.NOTHING for one in found) >= least
    errors = [one.error for one in found if one.learned]
    assert len(errors) >= 3
    for error in errors:
        assert error.after.held_out_rms["X"] < 0.75 * error.before.held_out_rms["X"]


@pytest.mark.parametrize("seed", range(3))
def test_a_vee_is_not_scatter_and_has_no_sure_name(seed, path):
    readings(path, {"X": scattered(seed, 3.5 * VEE)})
    found = diagnosed(path)
    assert found["verdict"] != "nothing-to-explain"
    assert not sure(found)


@pytest.mark.parametrize(
    ("course", "seed"),
    [(UNEVEN_SQUARE, 0), (TWO_BUMPS, 0), (GROWING_SINE, 1)],
    ids=["square of uneven lengths", "two bumps", "growing sine"],
)
def test_a_course_of_no_list_has_no_sure_name(course, seed, path):
    readings(path, {"X": scattered(seed, 3 * course)})
    assert not sure(diagnosed(path))


# ---- the loop closes on the unknown


@pytest.mark.parametrize("seed", [0, 4])
def test_an_unexplained_course_is_learned(seed, path):
    readings(path, {"X": scattered(seed, 3.5 * VEE)})
    found = diagnosed(path)
    given(found["verdict"] == "unexplained")
    assert "learned" in found
    assert found["error"]["after"]["rms"]["X"] < 0.7 * found["error"]["before"]["rms"]["X"]
    course = found["learned"]["axes"]["X"]
    assert len(course["value"]) == len(course["band"]) == len(course["cycle"])


@pytest.mark.parametrize("key", ["model_after", "with_effect_removed"])
def test_rp_of_the_completed_model_holds_the_learned_course(key, path):
    readings(path, {"X": scattered(0, 3.5 * VEE)})
    found = diagnosed(path)
    given(found["verdict"] == "unexplained")
    without = {"model_after": "model_before", "with_effect_removed": "measured"}[key]
    assert found["repeatability"][key]["X"] != found["repeatability"][without]["X"]


def test_the_model_file_takes_the_learned_course(path):
    readings(path, {"X": scattered(0, 3.5 * VEE)})
    model = path.with_suffix(".toml")
    into = ("--model", EXAMPLES / "fum_scara.toml", "--save-model", model)
    given(diagnosed(path, *into)["verdict"] == "unexplained")
    given(model.exists())
    assert "[[learned]]" in model.read_text(encoding="utf-8")


# ---- odd readings


def odd_readings(seed):
    """Return two axes; two readings of X lie 8 to 15 sigma off."""
    rng = np.random.default_rng(seed)
    x, y = 0.596 + 0.003 * rng.normal(size=31), 0.8 + 0.003 * rng.normal(size=31)
    x[[6, 16]] += (0.046, -0.041)
    return {"X": x, "Y": y}


@pytest.mark.parametrize("seed", range(4))
def test_odd_readings_are_found_with_their_cycles(seed, path):
    readings(path, odd_readings(seed))
    found = diagnosed(path)["effects"]
    outliers = [effect["parameters"] for effect in found if effect["effect"] == "outlier"]
    assert [sorted(parameters.get("cycles", ())) for parameters in outliers] == [[7, 17]]


@pytest.mark.parametrize("seed", range(4))
def test_analyze_and_diagnose_do_not_contradict_each_other(seed, path):
    readings(path, odd_readings(seed))
    given(names(ask("analyze", path), "a reading lies far off"))
    assert diagnosed(path)["verdict"] != "nothing-to-explain"


# ---- names that are too sure

NEGIZ4 = """
1.597 8.303 11.41 4.214 4.705 10.593 4.705 7.322 13.537 15.663 11.574 14.355 5.195 6.34 4.05
2.251 11.574 12.392 12.392 5.522 6.177 15.827 12.228 10.92 2.906 6.504 3.233 13.7 3.887 3.723
"""  # NIST's NEGIZ4: scatter, flat and with one hump
SENSOR_STEPS = """
30.656 30.633 30.738 30.652 30.645 30.656 30.652 30.723 30.629 30.652 30.645 30.641 30.645 30.66
30.645 30.652 30.66 30.672 30.652 30.656 30.66 30.66 30.746 30.656 30.727 30.738 30.656 30.656
30.734 30.75
"""  # a sensor's own steps of 0.085, coarser than the 0.001 that is stated
SETTLES = """
50.9 50.9 50.8 50.9 51.0 50.9 50.9 50.8 50.9 50.9 51.0 50.9 49.9 48.2 47.8 47.2 46.9 46.7 46.6
46.4 46.2 46.0 45.9 45.7 45.5 45.3 45.2 45.0 44.8 44.7 44.5
"""  # settles from cycle 13


def series(path, text, resolution=0.001):
    head = ["# unit: mm", f"# resolution: {resolution}", "# first_cycle: counts"]
    path.write_text("\n".join([*head, "X", *text.split()]) + "\n")
    return path


@pytest.mark.parametrize(
    "text", [pytest.param(NEGIZ4, id="NEGIZ4"), pytest.param(SENSOR_STEPS, id="sensor steps")]
)
def test_two_levels_alone_are_surely_no_contact_side(text, path):
    assert not sure(diagnosed(series(path, text)), "contact_side")


def test_what_settles_in_mid_run_is_no_sure_step(path):
    assert not sure(diagnosed(series(path, SETTLES, 0.1)), "step", "onset", "linear_drift")


@pytest.mark.parametrize("seed", range(2))
def test_a_sine_wants_two_periods(seed, path):
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi)
    readings(path, {"X": scattered(seed, 3.5 * np.sin(2 * np.pi * J / 17.5 + phase))})
    found = diagnosed(path)
    given(any(e["parameters"].get("period", 0) > 15 for e in found["effects"]))
    assert not sure(found, "periodic")


# ---- several poses, words and warnings


@pytest.fixture
def noise_at_five_poses(folder):
    """Return five poses of nothing but scatter, in which something is found: one in twenty."""
    rng = np.random.default_rng(22)
    for pose in range(1, 6):
        text = "\n".join(f"{value:.3f}" for value in 0.5 + 0.004 * rng.normal(size=12))
        series(folder / f"P{pose}.csv", text)
    return folder


def test_noise_at_several_poses_is_no_fact(noise_at_five_poses):
    said = ask("diagnose", noise_at_five_poses, "--cycles", "12").out
    first = said.partition("Next:")[0]
    given("Nothing" not in first)
    assert re.search(r"p (=|<=) 0\.\d|suspected", first)


def test_noise_at_several_poses_is_no_fact_on_page_1(noise_at_five_poses):
    page = noise_at_five_poses / "report.md"
    given(ask("report", noise_at_five_poses, "--cycles", "12", "-o", page).code == 0)
    said = re.sub(r"\s+", " ", page.read_text(encoding="utf-8"))
    given("the readings show" in said)
    sentence = said.partition("the readings show")[2][:200]
    assert re.search(r"p (=|<=) 0\.\d|suspected", sentence)


def test_readings_that_fall_are_never_said_to_rise(path):
    falls = -10 * (np.clip((U - 0.15) / 0.2, 0, 1) + np.clip((U - 0.65) / 0.15, 0, 1))
    rng = np.random.default_rng(0)
    readings(path, {"Z": 0.9 + SIGMA * (falls + 0.4 * rng.normal(size=31))})
    courses = diagnosed(path)["courses"]
    given(courses)
    assert not any("rises" in course["words"] for course in courses)


def test_no_warning_of_numpy_reaches_the_user(path):
    rng = np.random.default_rng(0)
    moved = 0.02 * (np.arange(30) > 12)
    quiet = np.full(30, 0.5)
    quiet[7] += DIVISION
    columns = {
        "P1_X": 0.5 + moved + 0.003 * rng.normal(size=30), "P1_Y": quiet,
        "P2_X": 0.5 + 0.003 * rng.normal(size=30), "P2_Y": quiet,
    }  # fmt: skip
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(f"{v:.3f}" for v in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answer = ask("diagnose", path, "--unit", "mm", "--all-count")
    given(answer.code == 0)
    assert not caught
    assert "invalid value" not in answer.err


# ---- two levels along a direction that no axis shows alone


@pytest.mark.parametrize("seed", range(3))
def test_two_levels_along_a_slanting_direction_are_found(seed, path):
    """Six scatters apart along 45 degrees: four on each axis, which shows too little alone."""
    rng = np.random.default_rng(seed)
    side = 4.2 * (rng.random(31) < 0.4)
    columns = {axis: scattered(seed * 10 + k, side) for k, axis in enumerate("XY")}
    columns = {"X [mm]": columns["X"], "Y [mm]": columns["Y"]}
    assert names(ask("diagnose", readings(path, columns)), "two levels")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_two_levels_that_all_poses_share_are_found(seed, path):
    """Five scatters apart along a direction that turns from pose to pose, in no order."""
    rng = np.random.default_rng(seed)
    side, rows = 5 * (rng.random(31) < 0.4), []
    for pose, angle in enumerate(np.radians([-60, -10, 60, 120, 200]), 1):
        x = scattered(100 * seed + 2 * pose, side * np.cos(angle))
        y = scattered(100 * seed + 2 * pose + 1, side * np.sin(angle))
        rows += [
            f"P{pose},{k},{a:.3f},{b:.3f}" for k, (a, b) in enumerate(zip(x, y, strict=True), 1)
        ]
    head = ["# unit: mm", f"# resolution: {DIVISION}", "pose,cycle,X,Y"]
    path.write_text("\n".join([*head, *rows]) + "\n")
    assert names(ask("diagnose", path), "two levels")


def test_a_cycle_that_is_odd_at_all_poses_is_found(path):
    """Six scatters off along a direction that turns from pose to pose, at most six on an axis."""
    rng, rows = np.random.default_rng(4), []
    for pose, angle in enumerate(np.radians([-60, -10, 60, 120, 200]), 1):
        hit = 6 * (J == 17)
        x, y = (
            scattered(rng.integers(2**32), hit * part) for part in (np.cos(angle), np.sin(angle))
        )
        rows += [
            f"P{pose},{k},{a:.3f},{b:.3f}" for k, (a, b) in enumerate(zip(x, y, strict=True), 1)
        ]
    head = ["# unit: mm", f"# resolution: {DIVISION}", "pose,cycle,X,Y"]
    path.write_text("\n".join([*head, *rows]) + "\n")
    answer = ask("diagnose", path)
    assert names(answer, "odd reading")
    assert names(answer, "cycle 18")


@pytest.mark.parametrize("seed", range(3))
def test_three_levels_in_no_order_are_unexplained(seed, path):
    """Twelve scatters apart: neither two levels nor a course over the cycles."""
    rng = np.random.default_rng(seed)
    columns = {"X": scattered(seed, 12 * rng.integers(0, 3, 31)), "Y": scattered(seed + 50, 0)}
    answer = ask("diagnose", readings(path, columns))
    assert answer.out.strip().startswith("Unexplained")
    assert names(answer, "X lies on three levels in no order")
    assert not names(answer, "first 1")  # words of a course


@pytest.mark.slow
def test_three_levels_that_all_poses_share_name_no_axis(path):
    rng = np.random.default_rng(2)
    level, rows = 7 * rng.integers(0, 3, 31), []
    for pose, angle in enumerate(np.radians([-60, -10, 60, 120, 200]), 1):
        x, y = (scattered(rng.integers(2**32), level * of(angle)) for of in (np.cos, np.sin))
        rows += [
            f"P{pose},{k},{a:.3f},{b:.3f}" for k, (a, b) in enumerate(zip(x, y, strict=True), 1)
        ]
    head = ["# unit: mm", f"# resolution: {DIVISION}", "pose,cycle,X,Y"]
    path.write_text("\n".join([*head, *rows]) + "\n")
    answer = ask("diagnose", path)
    assert answer.out.strip().startswith("Unexplained")
    assert names(answer, "on three levels in no order")


@pytest.mark.slow
@pytest.mark.parametrize("course", [J * 0.0008, np.where(J % 3 == 2, 0.016, 0)])
def test_an_axis_at_rest_on_a_coarse_dial_hides_no_other(course):
    found = 0
    for seed in range(10):
        rng = np.random.default_rng(1000 + seed)
        at = [0.5 + moved + 0.004 * rng.normal(size=31) for moved in (course, 0, 0)]
        axes = {
            name: Axis(name, np.rint(readings / 0.01) * 0.01, resolution=0.01)
            for name, readings in zip("XYZ", at, strict=True)
        }
        found += diagnose_readings(Run(np.arange(1, 32), axes)).verdict is not Verdict.NOTHING
    assert found >= 8  # before: 4 and 3


def test_an_alternation_that_dies_away_is_surely_no_change_of_scatter():
    fading = 0.02 * np.exp(-J / 8) * (-1.0) ** J
    for seed in (1, 3, 5):
        rng = np.random.default_rng(seed)
        at = [0.5 + part * fading + 0.004 * rng.normal(size=31) for part in (1, 0.6)]
        axes = {n: Axis(n, v.round(3)[1:], resolution=0.001) for n, v in zip("XY", at, strict=True)}
        found = diagnose_readings(Run(np.arange(1, 31), axes)).effects
        assert all(one.probability <= 0.89 for one in found if one.effect == "scatter_change")


def test_a_trend_that_analyze_sees_is_said_where_nothing_is_found():
    rng = np.random.default_rng(65)
    at = [
        0.5 + part * np.linspace(0, 0.0096, 30) + 0.004 * rng.normal(size=30) for part in (1, 0, 0)
    ]
    axes = {
        n: Axis(n, np.rint(v / 0.01) * 0.01, resolution=0.01)
        for n, v in zip("XYZ", at, strict=True)
    }
    found = diagnose_readings(Run(np.arange(1, 31), axes))
    assert found.verdict is not Verdict.NOTHING or "X alone moves" in " ".join(found.notes)


@pytest.mark.parametrize("seed", range(4))
def test_a_far_reading_of_one_of_five_poses_stands_in_the_first_line(seed, path, capsys):
    rng = np.random.default_rng(seed)
    rows = 0.003 * rng.normal(size=(5, 31, 2))
    rows[3, 15] += (0.03, 0.02)
    lines = ["# unit: mm", "# resolution: 0.001", "pose,cycle,X,Y"]
    lines += [f"P{p},{k},{x:.3f},{y:.3f}" for p, one in enumerate(rows, 1)
              for k, (x, y) in enumerate(one, 1)]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")
    main(["analyze", str(path)])
    given("a reading lies far off" in capsys.readouterr().out)
    main(["diagnose", str(path)])
    first = " ".join(capsys.readouterr().out.strip().split("\n\n")[0].split())
    assert not first.startswith("Nothing")
    assert "odd reading" in first.lower()
    assert "cycle 16" in first
    assert "P4" in first


def at_five_poses(seed, course, size=8.0):
    """Return a table of five poses: X and Y take a course, each in a size and sign of its own."""
    rng = np.random.default_rng(seed)
    free = (course - course.mean()) / np.ptp(course)
    at = {
        (p, a): rng.normal(size=30) + size * rng.uniform(0.3, 1) * rng.choice([-1, 1]) * free
        for p in range(5)
        for a in "XY"
    }
    axes = {
        a: Axis(a, np.ravel([at[p, a] for p in range(5)], "F").round(2) * 0.004, resolution=4e-5)
        for a in "XY"
    }
    pose = np.tile([f"P{p}" for p in range(1, 6)], 30)
    return Run(np.repeat(np.arange(1, 31), 5), axes, pose=pose)


T = np.linspace(0, 1, 30)


@pytest.mark.slow
@pytest.mark.parametrize(
    "course",
    [np.abs(T - 0.5), np.clip(np.minimum(5 * T, 5 * (1 - T)), 0, 1),
     np.exp(-(((T - 0.25) / 0.06) ** 2)) + 0.7 * np.exp(-(((T - 0.7) / 0.1) ** 2)),
     np.interp(T, [0, 0.3, 0.6, 1], [0, 1, 0.2, 0.8])],
    ids=["vee", "trapezoid", "two bumps", "kinks"],
)  # fmt: skip
def test_a_course_of_no_list_at_five_poses_is_unexplained(course):
    found = [diagnose(at_five_poses(seed, course), all_count=True) for seed in range(3)]
    assert sum(one.verdict is Verdict.UNEXPLAINED for one in found) >= 2


@pytest.mark.slow
def test_a_sine_that_five_poses_share_keeps_its_name():
    for seed in range(3):
        found = diagnose(at_five_poses(seed, np.sin(8 * np.pi * T)), all_count=True)
        assert [one.effect for one in found.effects] == ["periodic"]
        assert found.effects[0].probability > 0.9


@pytest.mark.parametrize(("levels", "said"), [(4, "four"), (5, "five")])
def test_more_levels_than_three_in_no_order_are_unexplained_and_counted(levels, said):
    rng = np.random.default_rng(levels)
    at = SIGMA * (10 * rng.permutation(np.resize(np.arange(levels), 30)) + rng.normal(size=30))
    found = diagnose_readings(
        Run(np.arange(1, 31), {"X": Axis("X", at.round(3), resolution=0.001)})
    )
    assert found.verdict is Verdict.UNEXPLAINED
    assert f"X lies on {said} levels in no order" in " ".join(found.notes)


def run_of_poses(rng, course):
    """Return five poses, X and Y, ``course(pose)`` of each in scatters, on a fine dial."""
    at = {p: course(p)[:, np.newaxis] * [1.0, 0.8] + rng.normal(size=(30, 2)) for p in range(5)}
    axes = {
        a: Axis(a, np.ravel([at[p][:, k] for p in range(5)], "F") * 0.004, resolution=1e-5)
        for k, a in enumerate("XY")
    }
    pose = np.tile([f"P{p}" for p in range(1, 6)], 30)
    return Run(np.repeat(np.arange(1, 31), 5), axes, pose=pose)


@pytest.mark.slow
def test_a_step_at_its_own_cycle_at_each_pose_is_named_at_each():
    cycles = [6, 11, 15, 19, 23]
    for seed in range(2):
        rng = np.random.default_rng(seed)
        run = run_of_poses(rng, lambda p: 8.0 * (-1) ** p * (np.arange(1, 31) >= cycles[p]))
        found = diagnose(run, all_count=True).effects
        at = {(one.poses, one.parameters["at_cycle"]) for one in found if one.effect == "step"}
        assert len(at & {((f"P{p + 1}",), cycle) for p, cycle in enumerate(cycles)}) == 5


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_walk_of_every_pose_stays_a_walk_and_small_steps_are_surely_none(seed):
    rng = np.random.default_rng([seed, 1])
    walk = diagnose(run_of_poses(rng, lambda _: rng.normal(size=30).cumsum()), all_count=True)
    assert [one.effect for one in walk.effects] == ["random_walk"]
    assert walk.effects[0].probability > 0.89
    small = run_of_poses(rng, lambda p: 4.0 * (np.arange(1, 31) >= (6, 11, 15, 19, 23)[p]))
    found = diagnose(small, all_count=True).effects
    assert all(one.probability <= 0.89 for one in found if one.effect == "random_walk")
