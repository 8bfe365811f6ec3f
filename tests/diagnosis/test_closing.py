"""The loop on tables that hide an effect: found, declared, gone; silent where nothing is."""

import json
from pathlib import Path

import numpy as np
import pytest

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import to_json
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.closed_loop import close_the_loop, directions_of
from scara_iso.diagnosis.engine.residual import CyclesWanted
from scara_iso.diagnosis.planning import PlannedRun, design, smallest_effects
from scara_iso.effects import Conditions, find_effects
from scara_iso.robot.model_file import read_model
from scara_iso.run import Axis, Run

ROOT = Path(__file__).parents[2]
TABLE_1 = ROOT / "examples" / "fum_scara_table1.csv"
MODEL = ROOT / "examples" / "fum_scara.toml"
KEYS = {"schema", "unit", "verdict", "effects", "error", "repeatability", "series"}


def diagnosed(call, *argv):
    code, out, err = call("diagnose", *argv, "--json")
    assert (code, err) == (0, "")
    return json.loads(out, parse_constant=pytest.fail)


def simulated(call, path, *effects, seed=1, options=()):
    words = [word for effect in effects for word in ("--effect", effect)]
    code, *_ = call("simulate", MODEL, *words, "--seed", seed, "-o", path, *options)
    assert code == 0
    return path


def test_table_1_holds_a_shift_in_y_and_nothing_else(call):
    document = diagnosed(call, TABLE_1, "--model", MODEL)
    assert set(document) >= KEYS
    assert document["verdict"] == "explained"
    (found,) = document["effects"]
    assert (found["effect"], found["axes"]) == ("step", ["Y"])
    assert found["parameters"]["at_cycle"] == 15
    assert found["parameters"]["size"]["Y"] == pytest.approx(-0.0088, abs=0.001)
    assert 0.5 < found["probability"] <= 0.9
    assert "linear_drift" in {rival["effect"] for rival in found["rivals"]}
    before, after = document["error"]["before"], document["error"]["after"]
    assert after["held_out_rms"]["Y"] < 0.7 * before["held_out_rms"]["Y"]
    assert document["repeatability"]["measured"]["XY"] == pytest.approx(0.0140566, rel=1e-4)
    assert document["series"]["cycle"] == list(range(1, 31))


@pytest.mark.parametrize("of_file", [True, False])
def test_the_library_diagnoses_the_cycles_that_count(call, of_file):
    warm_up = ROOT / "examples" / "warm_up.csv"  # 31 cycles, of which the first does not count
    run = warm_up if of_file else scara_iso.read_table(warm_up)
    assert to_json(scara_iso.diagnose(run)) == diagnosed(call, warm_up)


def test_a_step_where_the_recording_was_resumed_has_that_for_its_cause(call, tmp_path):
    table = simulated(call, tmp_path / "run.csv", "step@X:size=0.05,at_cycle=9")
    for cycle, named in ((9, True), (10, False)):
        head = f"# record_01_resumed: before cycle {cycle}\n"
        (tmp_path / "again.csv").write_text(head + table.read_text())
        (found,) = diagnosed(call, tmp_path / "again.csv")["effects"]
        assert found["cause"].startswith("the recording was resumed before cycle 9") is named


def test_library_and_command_take_the_same_options(call, tmp_path):
    table = simulated(call, tmp_path / "run.csv", "step@X:size=0.05,at_cycle=9")
    other = simulated(call, tmp_path / "other.csv", "step@X:size=0.05,at_cycle=9", seed=2)
    found = scara_iso.diagnose(table, MODEL, hold_out=other, sigma=0.004, seed=5, cycles=31)
    options = ("--model", MODEL, "--hold-out", other, "--sigma", 0.004, "--seed", 5, "--cycles", 31)
    assert to_json(found) == diagnosed(call, table, *options)


def test_the_loop_closes(call, tmp_path):
    new = tmp_path / "new.toml"
    table = simulated(call, tmp_path / "run.csv", "warm_up@X,Y:size=0.04,tau=6")
    found = diagnosed(call, table, "--model", MODEL, "--save-model", new)
    assert found["verdict"] == "explained"
    assert found["effects"][0]["effect"] == "warm_up"
    assert set(found["effects"][0]["axes"]) == {"X", "Y"}
    again = diagnosed(call, table, "--model", new)
    assert again["verdict"] == "nothing-to-explain"
    told = [one["repeatability"]["completed"]["XY"]["value"] for one in (found, again)]
    assert told[1] == pytest.approx(told[0], rel=0.15)  # what is declared comes again
    assert "Nothing besides what the model declares" in call("diagnose", table, "--model", new)[1]
    following = simulated(call, tmp_path / "next.csv", "warm_up@X,Y:size=0.04,tau=6", seed=7)
    document = diagnosed(call, following, "--model", new)
    assert document["verdict"] == "nothing-to-explain"
    assert document["error"]["before"]["rms"]["X"] < 0.6 * found["error"]["before"]["rms"]["X"]


@pytest.mark.parametrize("seed", [11, 12, 13])  # by design one table in twenty alarms, as 10 does
def test_scatter_only_has_nothing_to_explain(call, tmp_path, seed):
    table = simulated(call, tmp_path / "run.csv", seed=seed)
    document = diagnosed(call, table)
    assert document["verdict"] == "nothing-to-explain"
    assert document["effects"] == []


def test_structure_that_is_in_no_catalogue_is_unexplained(rng):
    bump = np.exp(-(((np.arange(31) - 16) / 3.0) ** 2))
    axes = {
        name: Axis(name, (0.08 * bump + rng.normal(0, 0.01, 31)).round(3), resolution=0.001)
        for name in "XY"
    }
    found = close_the_loop(Run(np.arange(1, 32), axes), None, CyclesWanted(), seed=1)
    assert found.verdict.value == "unexplained" or found.effects[0].probability < 0.9


def test_a_second_table_gives_the_held_out_error(call, tmp_path):
    first = simulated(call, tmp_path / "a.csv", "step@X:size=0.03,at_cycle=12")
    second = simulated(call, tmp_path / "b.csv", "step@X:size=0.03,at_cycle=12", seed=5)
    document = diagnosed(call, first, "--hold-out", second)
    error = document["error"]
    (found,) = document["effects"]
    assert "step" in {found["effect"], *(rival["effect"] for rival in found["rivals"])}
    assert error["after"]["held_out_rms"]["X"] < 0.6 * error["before"]["held_out_rms"]["X"]


def test_a_movement_along_joint_1_names_the_joint(call, tmp_path):
    model = read_model(MODEL)
    x, y = directions_of(model)["joint 1"].values()
    table = simulated(
        call, tmp_path / "run.csv", f"step@X:size={0.05 * x:.5f},at_cycle=16",
        f"step@Y:size={0.05 * y:.5f},at_cycle=16",
    )  # fmt: skip
    (found,) = diagnosed(call, table, "--model", MODEL)["effects"]
    assert found["joint"] == 1
    assert found["angles"]["joint 1"] < 10


def test_it_is_said_on_the_terminal_and_drawn(call, tmp_path):
    picture = tmp_path / "d.svg"
    code, out, err = call("diagnose", TABLE_1, "--full", "--plot", picture)
    assert (code, err) == (0, "")
    assert "Found: step or linear drift on Y" in out
    assert "To be sure:" in out
    assert picture.read_text(encoding="utf-8").startswith("<?xml")


def test_several_tables_give_a_summary(call, tmp_path):
    step = simulated(call, tmp_path / "step.csv", "step@X:size=0.05,at_cycle=12")
    plain = simulated(call, tmp_path / "plain.csv", seed=12)
    code, out, _ = call("diagnose", step, plain)
    assert code == 0
    assert "2 diagnosed: 1 explained, 1 nothing-to-explain" in out
    assert "stands apart" not in out
    far = tmp_path / "far.csv"
    scatter = np.random.default_rng(0).normal(0, 0.01, 31)
    rows = [f"{k},{x + 0.04 * (k == 20):.4f}" for k, x in enumerate(scatter, 1)]
    far.write_text("\n".join(["cycle,X [mm]", *rows]))
    alone, beside = call("diagnose", far)[1], call("diagnose", far, plain)[1]
    line = "X:thereadingofcycle20standsapart"
    assert f"!{line}" in "".join(alone.split())
    assert "Next: scara-iso explain outlier" in alone
    assert f"far.csv,{line}" in "".join(beside.split())
    code, out, _ = call("diagnose", step, tmp_path / "nowhere.csv", "--json")
    assert code == 66
    first, second = json.loads(out, parse_constant=pytest.fail)["tables"]
    assert first["verdict"] == "explained"
    assert "nowhere.csv" in second["error"]
    assert call("diagnose", step, plain, "--plot", "a.svg")[0] == 2


@pytest.mark.slow
def test_a_planned_test_says_what_it_will_find(call):
    document = json.loads(
        call("diagnose", "--design", "--sigma", "0.004", "--columns", "approach", "--json")[1],
        parse_constant=pytest.fail,
    )
    assert document["schema"] == "scara-iso/design/1"
    assert document["cycles"] == 30
    smallest = document["smallest"]
    assert 1.2 * 0.004 < smallest["step"] < 2.4 * 0.004
    assert "lost_motion" in smallest
    moved = {c["change"]: c["smallest"]["step"] for c in document["changes"]}
    assert moved["50 cycles"] < smallest["step"]


@pytest.mark.slow
def test_a_test_like_that_of_a_table(call):
    code, out, _ = call("diagnose", TABLE_1, "--design")
    assert code == 0
    assert "30 cycles" in out
    assert "linear drift and warm up" in out


@pytest.mark.parametrize(
    "argv", [[], ["--design", "--sigma", "0"], ["--design", "--columns", "colour"]]
)
def test_a_design_that_cannot_be_meant(call, argv):
    assert call("diagnose", *argv)[0] == 2


def test_the_poses_of_a_table_give_a_summary(call, tmp_path, rng):
    path = tmp_path / "poses.csv"
    x = rng.normal(0, 0.01, 62) + np.repeat([0, 0, 0, 0.1], [31, 12, 0, 19])
    rows = "".join(f"P{1 + k // 31},{1 + k % 31},{x[k]:.3f}\n" for k in range(62))
    path.write_text(f"# unit: mm\n# resolution: 0.001\npose,cycle,X\n{rows}", encoding="utf-8")
    code, out, _ = call("diagnose", path)
    assert code == 0
    assert "at P2 alone" in out
    assert call("diagnose", path, "--plot", tmp_path / "a.svg")[0] == 0
    assert (tmp_path / "a.svg").exists()
    assert diagnosed(call, path, "--pose", "P2")["verdict"] == "explained"


def test_poses_are_diagnosed_one_at_a_time(rng):
    cycle = np.tile(np.arange(1, 32), 2)
    run = Run(cycle, {"X": Axis("X", rng.normal(0, 0.01, 62))}, pose=np.repeat(["P1", "P2"], 31))
    with pytest.raises(DataError, match="2 poses"):
        close_the_loop(run, None, CyclesWanted(), seed=1)
    with pytest.raises(UsageError, match="no pose 'P9'"):
        close_the_loop(run, None, CyclesWanted("P9"), seed=1)
    assert len(close_the_loop(run, None, CyclesWanted("P2"), seed=1).series.cycle) == 30


def test_a_model_of_another_robot_is_said(tmp_path, rng):
    path = tmp_path / "other.toml"
    path.write_text("[indicator.Z]\n", encoding="utf-8")
    run = Run(np.arange(1, 32), {"X": Axis("X", rng.normal(0, 0.01, 31))})
    with pytest.raises(DataError, match="no indicator X"):
        close_the_loop(run, read_model(path), CyclesWanted(), seed=1)


def test_a_model_in_another_unit_is_refused(tmp_path, rng):
    path = tmp_path / "other.toml"
    path.write_text("[indicator.theta]\n[indicator.X]\n", encoding="utf-8")
    angle = Axis("theta", rng.normal(0, 0.01, 31), Dimension.ANGLE)
    with pytest.raises(DataError, match="theta is in deg, and in mm in the model"):
        close_the_loop(
            Run(np.arange(1, 32), {"theta": angle}), read_model(path), CyclesWanted(), seed=1
        )


def test_a_model_of_another_name_is_doubted(call, tmp_path):
    other = tmp_path / "other.toml"
    text = MODEL.read_text(encoding="utf-8")
    other.write_text(text.replace('name = "FUM SCARA"', 'name = "Cobra"'), encoding="utf-8")
    doubt = "the model is that of Cobra, the table is of FUM SCARA: is it the right one?"
    assert doubt in diagnosed(call, TABLE_1, "--model", other)["notes"]
    assert not any("right one" in n for n in diagnosed(call, TABLE_1, "--model", MODEL)["notes"])


def test_a_column_that_the_model_needs_is_named(call, tmp_path):
    model = tmp_path / "warm.toml"
    effect = "[[effect]]\nname='temperature'\ncolumn='temperature_C'\nsize={X=0.001}\n"
    model.write_text(f"[indicator.X]\n{effect}", encoding="utf-8")
    code, out, err = call("diagnose", TABLE_1, "--model", model)
    assert (code, out) == (2, "")
    assert "needs the column temperature_C" in err


def test_a_table_that_cannot_be_diagnosed_is_named(call, tmp_path):
    path = tmp_path / "short.csv"
    rows = "".join(f"{k},{0.5 + 0.001 * (k % 3):.3f}\n" for k in range(1, 9))
    path.write_text(f"# unit: mm\ncycle,X\n{rows}", encoding="utf-8")
    code, out, err = call("diagnose", path, "--cycles", "8")
    assert (code, out) == (65, "")
    assert "short.csv: 7 usable cycles cannot tell structure from scatter" in err


@pytest.mark.parametrize(
    ("argv", "code"),
    [
        ([TABLE_1, "--save-model", "new.toml"], 2),
        ([TABLE_1, "--model", "nowhere.toml"], 66),
        ([TABLE_1, "--hold-out", "nowhere.csv"], 66),
        ([TABLE_1, "--cycles", "8", "--first-cycle-discarded"], 65),
    ],
)
def test_errors_have_their_code(call, argv, code):
    assert call("diagnose", *argv)[0] == code


def test_a_change_of_scatter_is_declared_with_its_size(call, tmp_path):
    new = tmp_path / "new.toml"
    table = simulated(
        call, tmp_path / "run.csv", "scatter_change@X:at_cycle=14,ratio=12,scatter=0.01", seed=2
    )
    (found,) = diagnosed(call, table, "--model", MODEL, "--save-model", new)["effects"]
    assert found["effect"] == "scatter_change"
    (effect,) = read_model(new).effects
    assert effect.on_axis("X")["ratio"] == found["parameters"]["ratio"]
    assert effect.on_axis("X")["scatter"] == pytest.approx(0.0075, abs=0.003)
    code, _, err = call("simulate", new)
    assert (code, err) == (0, "")


def test_a_model_is_not_saved_over_the_one_it_is_made_of(call, tmp_path):
    table = simulated(call, tmp_path / "run.csv", "warm_up@X,Y:size=0.04,tau=6")
    own, link = tmp_path / "own.toml", tmp_path / "link.toml"
    own.write_bytes(MODEL.read_bytes())
    link.symlink_to(own)
    code, out, err = call("diagnose", table, "--model", own, "--save-model", link)
    assert (code, out) == (73, "")
    assert "an input of this command" in err
    assert own.read_bytes() == MODEL.read_bytes()


def test_a_stated_scatter_is_in_mm_and_for_one_table(call, tmp_path):
    table = simulated(call, tmp_path / "run.csv", "step@X:size=0.03,at_cycle=12")
    without, known = diagnosed(call, table), diagnosed(call, table, "--sigma", "0.005")
    assert known["p_value"] == without["p_value"]
    assert known["effects"][0]["probability"] != without["effects"][0]["probability"]
    code, _, err = call("diagnose", table, table, "--sigma", "0.005")
    assert code != 0
    assert "--sigma is for one table" in err
    code, _, err = call("diagnose", table, "--sigma", "-1")
    assert code != 0
    assert "positive" in err


def test_a_sine_through_simulate_is_named_once(call, tmp_path):
    table = simulated(call, tmp_path / "run.csv", "periodic@X:size=0.04,period=6,phase=1", seed=2)
    effects = diagnosed(call, table, "--model", MODEL)["effects"]
    assert [found["effect"] for found in effects] == ["periodic"]
    assert effects[0]["parameters"]["period"] == pytest.approx(6, rel=0.01)


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["--design", "--cycles", "8"], "7 usable cycles"),
        (["--design", "--model", MODEL], "--model does not go with --design"),
        (["--design", TABLE_1, "--columns", "approach"], "columns 'approach' name no axis"),
        ([TABLE_1, "--columns", "approach"], "columns 'approach' name no axis"),
    ],
)
def test_a_design_says_what_it_cannot_use(call, argv, said):
    code, out, err = call("diagnose", *argv)
    assert (code != 0, out) == (True, "")
    assert said in err


def test_a_design_plans_no_angles_as_lengths(call, tmp_path):
    turns = "\n".join(f"{j},{10 + 0.001 * (j % 3):.3f}" for j in range(1, 32))
    table = f"# unit: deg\n# resolution: 0.001\ncycle,theta\n{turns}\n"
    (tmp_path / "turns.csv").write_text(table, encoding="utf-8")
    code, _, err = call("diagnose", tmp_path / "turns.csv", "--design")
    assert (code, "no axis in mm" in err) == (65, True)


def test_a_long_plan_finds_less_than_the_shortest_step_of_a_short_one():
    plan = PlannedRun(Conditions(np.arange(2, 302)), 1.0, 0.0)
    found = smallest_effects(
        plan, [e for e in find_effects() if e.name == "linear_drift"], np.random.default_rng(1)
    )
    assert found["linear_drift"] == pytest.approx(0.58, rel=0.25)


def test_four_of_five_steps_of_four_fifths_of_a_division_cross_a_line_of_the_dial():
    """Where a dial stands between its lines is chance: a step of a share of its division moves the
    reading as often as the share says. Scatter helps it across, by no more than twice its size.
    """
    plan = PlannedRun(Conditions(np.arange(2, 32)), sigma=1.0, division=11.0)
    step = [effect for effect in find_effects() if effect.name == "step"]
    found = smallest_effects(plan, step, np.random.default_rng(1))
    assert 0.8 * 11 - 2 < found["step"] < 0.8 * 11


@pytest.mark.parametrize(("division", "finer"), [(0.01, True), (0.003, False)])
def test_a_finer_dial_is_advised_where_a_division_is_much_of_the_scatter(division, finer):
    drift = [one for one in find_effects() if one.name == "linear_drift"]
    found = design(PlannedRun(Conditions(np.arange(2, 14)), 0.01, division), seed=1, effects=drift)
    assert (found.changes[0].change == "a dial ten times as fine") is finer


def test_an_unexplained_course_is_not_called_scatter(call, tmp_path):
    vee = "\n".join(f"{j},{abs(j - 16) ** 2 + j % 3}" for j in range(1, 32))
    (tmp_path / "vee.csv").write_text(f"# unit: um\n# resolution: 1\ncycle,X\n{vee}\n")
    out = call("diagnose", tmp_path / "vee.csv", "--full")[1]
    assert "unexplained" in out.split("what RP is made of")[1].splitlines()[1]


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        ("contact_side@X:size=0.06,switching=0.4", ["anew in every test"]),
        ("contact_side@X,Y:size=0.06,switching=0.4", ["anew in every test; new on Y"]),
        ("contact_side@X:size=0.18,switching=0.4", ["test; size X 0.18, declared 0.06"]),
        ("contact_side@Y:size=0.06,switching=0.4", []),
    ],
)
def test_what_chance_draws_anew_is_as_declared_on_the_axes_of_the_model(
    call, tmp_path, effect, said
):
    table, model = simulated(call, tmp_path / "run.csv", effect), tmp_path / "known.toml"
    known = '\n[[effect]]\nname = "contact_side"\nswitching = 0.4\nsize = {X = 0.06}\n'
    model.write_text(MODEL.read_text() + known)
    document = diagnosed(call, table, "--model", model)
    assert [one["effect"] for one in document["effects"]] == ["contact_side"]
    notes = [note for note in document["notes"] if "as declared" in note]
    assert len(notes) == len(said)
    assert all(note.endswith(end) for note, end in zip(notes, said, strict=True))


def test_a_model_with_a_change_of_scatter_simulates_it_and_no_more(call, tmp_path):
    scatter = "scatter_change@X:ratio=8,at_cycle=16,scatter=0.006"
    table = simulated(call, tmp_path / "wide.csv", scatter, seed=1)
    new = tmp_path / "new.toml"
    code, *_ = call("diagnose", table, "--model", MODEL, "--save-model", new)
    assert code == 0
    found = read_model(new)
    (change,) = (one for one in found.effects if one.name == "scatter_change")
    assert found.indicators["X"].scatter == pytest.approx(change.on_axis("X")["scatter"], rel=0.01)
    runs = [scara_iso.simulate(new, seed=seed).axes["X"].readings for seed in range(40)]
    before, after = (np.std([run[part] for run in runs]) for part in (slice(15), slice(16, None)))
    assert before < 0.008
    assert after / before > 2
