"""The model file, what the model predicts, and what a dial would have shown of it."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomlkit

import scara_iso
from scara_iso.base.errors import CannotCreateError, DataError, NoInputError, UsageError
from scara_iso.commands import main
from scara_iso.effects import Conditions
from scara_iso.robot.model import DeclaredEffect
from scara_iso.robot.model_file import _why_no_knots, declare, parse_effect, read_model
from scara_iso.robot.prediction import (
    Approach,
    predict,
    rest_positions,
    simulate,
    sweep_of,
)
from scara_iso.tables import read_table, write_table

EXAMPLE = Path(__file__).parents[2] / "examples" / "fum_scara.toml"
CYCLES = Conditions(np.arange(1, 32))
BOTH = Conditions(np.arange(1, 32), {"approach": np.resize([1.0, -1.0], 31)})


@pytest.fixture
def fum():
    return read_model(EXAMPLE)


def model_from(tmp_path, text):
    path = tmp_path / "model.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_example_holds_the_paper_s_robot(fum):
    assert fum.robot == "FUM SCARA"
    assert fum.arm.link_1_mm + fum.arm.link_2_mm == 700
    gear = fum.gearboxes[1]
    assert (gear.Im, gear.IL, gear.arcmin, gear.ratio) == (2.65e-4, 4.749, 12, 50)
    assert list(fum.indicators) == ["X", "Y", "Z", "theta"]
    assert sweep_of(fum, 1).deviation[0] == pytest.approx(-1.947721e-7, rel=1e-6)


def test_without_an_approach_the_prediction_is_a_constant_pose(fum):
    run = predict(fum, CYCLES)
    for name, axis in run.axes.items():
        assert axis.readings.tolist() == [fum.indicators[name].level] * 31
        assert axis.resolution == fum.indicators[name].resolution


def test_the_reversal_is_eq_16_times_the_lever(fum):
    x, y = predict(fum, BOTH).axes["X"].readings, predict(fum, BOTH).axes["Y"].readings
    width = math.hypot(x[0] - x[1], y[0] - y[1])
    lever = math.hypot(*fum.arm.forward(fum.joints_deg))
    assert width == pytest.approx(lever * 1.947721e-7, rel=1e-6)


def test_a_declared_gear_effect_changes_the_reversal(tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8")
    path = model_from(
        tmp_path, f'{text}\n[[effect]]\nname = "reflected_inertia"\njoint = 1\nN = 50\n'
    )
    assert sweep_of(read_model(path), 1).deviation[0] == pytest.approx(-4.273420e-4, rel=1e-6)


def test_a_declared_effect_moves_its_axes_and_no_other(tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8")
    path = model_from(
        tmp_path, f'{text}\n[[effect]]\nname = "step"\nat_cycle = 15\nsize = {{ Y = -0.0098 }}\n'
    )
    run = predict(read_model(path), CYCLES)
    y = run.axes["Y"].readings
    assert np.ptp(run.axes["X"].readings) == 0
    assert y[13] - y[0] == 0
    assert y[14] - y[13] == pytest.approx(-0.0098)


def test_an_effect_of_chance_moves_the_expectation_by_nothing(tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8")
    chance = '\n[[effect]]\nname = "contact_side"\nswitching = 0.2\nsize = { X = 0.05 }\n'
    model = read_model(model_from(tmp_path, text + chance))
    assert np.ptp(predict(model, CYCLES).axes["X"].readings) == 0
    seen = simulate(model, CYCLES, rng=np.random.default_rng(3)).axes["X"].readings
    assert np.ptp(seen) > 0.04


def test_declare_adds_the_effect_and_keeps_every_comment(tmp_path):
    found = DeclaredEffect("warm_up", {"tau": 8.0, "size": {"X": 0.03}})
    copy = tmp_path / "new.toml"
    declare(EXAMPLE, (found,), copy)
    before, after = EXAMPLE.read_text(encoding="utf-8"), copy.read_text(encoding="utf-8")
    assert after.startswith(f"# written by scara-iso\n{before.rstrip()}")
    assert read_model(copy).effects == (found,)
    declare(copy, (found,), copy)
    assert read_model(copy).effects == (found, found)
    assert tomlkit.parse(copy.read_text(encoding="utf-8"))["effect"][1]["tau"] == 8.0
    with pytest.raises(CannotCreateError):
        declare(EXAMPLE, (found,), tmp_path / "nowhere" / "new.toml")


def test_declared_numbers_have_the_digits_in_which_all_processors_agree(tmp_path):
    sizes = {"X": 4.334011938783707e-05, "Y": 4.3340119387837075e-05}
    declare(EXAMPLE, (DeclaredEffect("step", {"at_cycle": 16, "size": sizes}),), tmp_path / "new")
    (step,) = read_model(tmp_path / "new").effects
    assert step.parameters == {"at_cycle": 16, "size": dict.fromkeys(sizes, 4.33401193878e-05)}


def test_every_fault_is_named_by_its_key(tmp_path):
    path = model_from(
        tmp_path,
        """
        [robot]
        link_1_mm = "long"
        colour = "red"
        [gearbox.joint_1]
        Im = -1
        IL = 2
        arcmin = 3
        [gearbox.joint_9]
        [indicator.X]
        unit = "furlong"
        [indicator.Q]
        [indicator.Y]
        resolution = nan
        [pose]
        x_mm = 3
        [[effect]]
        name = "magic"
        [[effect]]
        name = "step"
        at = 3
        size = { X = 1, theta = "a" }
        [extra]
        """,
    )
    with pytest.raises(DataError) as caught:
        read_model(path)
    said = "\n".join(str(fault) for fault in caught.value.faults)
    for key in (
        "robot.link_1_mm", "robot.link_2_mm", "robot.colour", "gearbox.joint_1", "gearbox.joint_9",
        "indicator.X.unit", "indicator.Q", "indicator.Y.resolution", "pose", "effect 1",
        "effect 2.at", "effect 2.at_cycle", "effect 2.size.theta", "extra",
    ):  # fmt: skip
        assert key in said


@pytest.mark.parametrize("text", ["= broken", "indicator = 3", "", "effect = 3\n[indicator.X]"])
def test_what_is_no_model_is_refused(tmp_path, text):
    with pytest.raises(DataError):
        read_model(model_from(tmp_path, text))


@pytest.mark.parametrize(
    "start",
    [
        "",
        "effect = [] # none yet\n",
        "effect = [{ name = 'step', at_cycle = 3, size = { X = 1 } }] # one\n",
        "[[effect]]\nname = 'step'\nat_cycle = 3\n[effect.size] # one\nX = 1\n",
    ],
)
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_declare_keeps_every_line_however_the_file_is_written(tmp_path, start, line_end):
    path, copy = tmp_path / "model.toml", tmp_path / "new.toml"
    text = f"{start}[indicator.X] # the dial\nresolution = 0.01\n".replace("\n", line_end)
    path.write_bytes(text.encode())
    found = DeclaredEffect("warm_up", {"tau": 8.0, "size": {"X": 0.03}})
    declare(path, (found, found), copy)
    assert read_model(copy).effects == (*read_model(path).effects, found, found)
    written = copy.read_bytes()
    for comment in (line for line in text.split(line_end) if "#" in line):
        assert comment.partition("#")[2].encode() in written
    assert f"resolution = 0.01{line_end}".encode() in written


HEAD = """
[robot]
link_1_mm = 400
link_2_mm = 300
joint_2_deg = [-145, 145]
[indicator.X]
resolution = 0.01
[indicator.Y]
[gearbox.joint_1]
Im = 1e-3
IL = 2
arcmin = 6
"""


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[[effect]]\nname = [1]", "effect 1: name one of"),
        ("[[effect]]\nname = 'step'\nsize = { X = 1 }", "effect 1.at_cycle: missing"),
        ("[[effect]]\nname = 'step'\nat_cycle = 3\nsize = 0.5", "effect 1.size: give a value"),
        ("[[effect]]\nname = 'step'\nat_cycle = 3\nsize = 'big'", "effect 1.size: give a value"),
        ("[[effect]]\nname = 'step'\nat_cycle = 3\nsize = {}", "effect 1.size: give a value"),
        ("[[effect]]\nname = 'step'\nat_cycle = true\nsize = { X = 1 }", "effect 1.at_cycle: True"),
        (f"[[effect]]\nname = 'step'\nat_cycle = 1{'0' * 400}\nsize = {{ X = 1 }}", "cycle: 10"),
        ("[[effect]]\nname = 'warm_up'\ntau = 0\nsize = { X = 1 }", "effect 1.tau: 0 must"),
        ("[[effect]]\nname = 'warm_up'\ntau = { Y = 1 }\nsize = { X = 1 }", "for the same axes"),
        ("[[effect]]\nname = 'covariate'\ncolumn = 3\nsize = { X = 1 }", "not the name"),
        ("[[effect]]\nname = 'friction_hold'\njoint = 1\nheld = 1.5", "above 0 and at most 1"),
        ("[[effect]]\nname = 'held_motor'", "effect 1.joint: give"),
        ("[[effect]]\nname = 'held_motor'\njoint = 2", "effect 1.joint: give"),
        ("[[effect]]\nname = 'held_motor'\njoint = [1]", "effect 1.joint: give"),
        ("[[effect]]\nname='step'\nat_cycle=3\njoint='one'\nsize={ X = 1 }", "joint: 1 or 2"),
        ("[pose]\njoint_deg = [0, 150]", "joint 2 is 5 deg outside its limits"),
        ("[pose]\njoint_deg = [0, 90]\nx_mm = 3", "give either joint_deg"),
        ("[pose]\nx_mm = 300\ny_mm = 300\nelbow = 'up'", "pose.elbow: 'up'"),
        ("[pose.P2]\njoint_deg = [0, 150]", "pose.P2.joint_deg: joint 2 is 5 deg outside"),
        ("[pose.P2]\njoint_deg = [0]", "pose.P2.joint_deg: [0] is not a pair"),
        ("[pose.P2]\n[pose.P3]\nx = 1", "pose.P2: give joint_deg, or x_mm and y_mm"),
        ("[pose.P3]\njoint_deg = [0, 9]\nx = 1", "pose.P3.x: no such key"),
        ("[gearbox.joint_2]\nIm = 1\nIL = 1\narcmin = 1\nstiffness = -3\nfriction = -1", "must be"),
        ("a = " + "[" * 50_000, "nested deeper"),
    ],
)  # fmt: skip
def test_a_model_that_cannot_be_meant_is_refused(tmp_path, text, said):
    with pytest.raises(DataError) as caught:
        read_model(model_from(tmp_path, f"{HEAD}{text}\n"))
    assert said in "\n".join([caught.value.what, *map(str, caught.value.faults)])


def test_a_rating_has_its_own_section(tmp_path):
    with pytest.raises(DataError) as caught:
        read_model(model_from(tmp_path, "[robot]\nload_kg = 2\n[indicator.X]\n"))
    (fault,) = caught.value.faults
    assert "robot.load_kg: no such key" in str(fault)


def test_no_such_file(tmp_path):
    with pytest.raises(NoInputError):
        read_model(tmp_path / "nowhere.toml")


def test_the_poses_of_a_test_stand_beside_that_of_a_single_table(tmp_path):
    text = (
        "[robot]\nlink_1_mm = 250\nlink_2_mm = 200\n[indicator.X]\n[pose]\njoint_deg = [1, 2]\n"
        "[pose.P1]\njoint_deg = [0, 90]\n[pose.'at the jig']\nx_mm = 250\ny_mm = -200\n"
        "elbow = 'left'\n"
    )
    model = read_model(model_from(tmp_path, text))
    assert model.joints_deg == (1, 2)
    assert model.poses["P1"] == (0, 90)
    assert model.poses["at the jig"] == pytest.approx((0, -90))
    assert model.at("P1").joints_deg == (0, 90)
    assert model.at("P9").joints_deg is None
    assert model.at(None) is model


def test_a_pose_that_the_arm_cannot_reach_is_refused(tmp_path):
    text = "[robot]\nlink_1_mm = 100\nlink_2_mm = 100\n[pose]\nx_mm = 300\ny_mm = 0\n[indicator.X]"
    with pytest.raises(DataError) as caught:
        read_model(model_from(tmp_path, text))
    assert "out of reach" in str(caught.value.faults[0])


def test_simulated_readings_are_multiples_of_the_resolution_and_survive_the_table(fum):
    run = simulate(fum, BOTH, rng=np.random.default_rng(1))
    for name, axis in run.axes.items():
        steps = axis.readings / fum.indicators[name].resolution
        assert np.allclose(steps, np.round(steps), atol=1e-9)
    back = read_table(write_table(run).encode())
    for name, axis in run.axes.items():
        assert np.array_equal(back.axes[name].readings, axis.readings)


def test_an_undeclared_effect_acts_and_is_written_nowhere(fum):
    effect = parse_effect("warm_up@X:size=0.5,tau=8", fum)
    plain = simulate(fum, CYCLES, rng=np.random.default_rng(1))
    moved = simulate(fum, CYCLES, rng=np.random.default_rng(1), undeclared=[effect])
    course = moved.axes["X"].readings - plain.axes["X"].readings
    assert course[-1] == pytest.approx(0.5 * (1 - math.exp(-30 / 8)), abs=0.011)
    assert np.array_equal(moved.axes["Y"].readings, plain.axes["Y"].readings)
    assert "warm" not in write_table(moved)


@pytest.mark.parametrize("effect", ["step:size=1,at_cycle=50", "outlier:size=1,at_cycle=50",
                                    "scatter_change:at_cycle=50,ratio=3,scatter=1"])  # fmt: skip
def test_an_effect_that_begins_behind_the_last_cycle_is_refused(fum, effect):
    with pytest.raises(UsageError, match="begins at cycle 50, and the last is 31"):
        simulate(fum, CYCLES, rng=np.random.default_rng(1), undeclared=[parse_effect(effect, fum)])


def test_an_effect_of_chance_that_happens_to_move_nothing_is_none_of_these(fum):
    side = parse_effect("contact_side:size=0.03,switching=0.1", fum)
    for seed in range(8):  # in two cycles both may come to rest on one side
        rng = np.random.default_rng(seed)
        assert len(simulate(fum, Conditions(np.arange(1, 3)), rng=rng, undeclared=[side])) == 2


def test_a_table_of_a_model_of_several_poses_says_that_it_is_of_none(capsys):
    poses = EXAMPLE.with_name("five_poses.toml")
    assert main(["simulate", str(poses)]) == 0
    assert "names 6 poses; this is one table, and of none" in capsys.readouterr().err
    (note,) = scara_iso.simulate(poses).origin.notes
    assert note.startswith("the model names 6 poses")
    assert scara_iso.simulate(EXAMPLE).origin.notes == ()


def test_effects_as_they_are_typed(fum):
    step = parse_effect("step@X,Y:size=0.02,at_cycle=15", fum)
    assert step == DeclaredEffect("step", {"size": {"X": 0.02, "Y": 0.02}, "at_cycle": 15.0})
    assert parse_effect("linear_drift:size=1", fum).axes == ("X", "Y", "Z", "theta")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("magic:size=1", "unknown effect"),
        ("warm_up:size=1", "warm_up.tau: missing"),
        ("warm_up:size=1,tau=2,rho=3", "warm_up.rho: no such key"),
        ("warm_up:size=one,tau=2", "size.X: 'one' is not a finite number"),
        ("warm_up:size=nan,tau=2", "not a finite number"),
        ("warm_up:size=1e400,tau=2", "not a finite number"),
        ("warm_up:size=1_0,tau=2", "not a finite number"),
        ("warm_up:size=1,tau=0", "above 0"),
        ("warm_up:size=1,tau=2,tau=3", "given twice"),
        ("contact_side:size=1,switching=7", "at most 1"),
        ("scatter_change:at_cycle=10,ratio=-2,scatter=1", "above 0"),
    ],
)
def test_effects_that_cannot_be_meant(fum, text, said):
    with pytest.raises(UsageError, match=said):
        parse_effect(text, fum)


def test_an_effect_on_an_indicator_that_is_not_there(fum):
    effect = DeclaredEffect("step", {"size": {"Q": 1.0}, "at_cycle": 3.0})
    with pytest.raises(UsageError, match="no indicator Q"):
        simulate(fum, CYCLES, rng=np.random.default_rng(1), undeclared=[effect])


def test_an_effect_that_lacks_its_column(fum):
    effect = parse_effect("compliance:size=1", fum)
    with pytest.raises(UsageError, match="needs the column payload_kg"):
        simulate(fum, CYCLES, rng=np.random.default_rng(1), undeclared=[effect])


def test_rest_positions_lie_along_joint_1(fum):
    sides, moved = rest_positions(fum, Approach.BOTH_SIDES, count=40, rng=np.random.default_rng(2))
    gap_mm = math.radians(12 / 60) * math.hypot(*fum.arm.forward(fum.joints_deg))
    direction = fum.arm.jacobian(fum.joints_deg)[:, 0]
    direction = direction / np.linalg.norm(direction)
    along = moved["X"] * direction[0] + moved["Y"] * direction[1]
    across = moved["X"] * direction[1] - moved["Y"] * direction[0]
    assert set(sides) == {1.0, -1.0}
    assert np.allclose(across, 0, atol=1e-12)
    assert np.max(np.abs(along)) <= gap_mm / 2 * (1 + 1e-9)


def test_the_drive_train_needs_an_arm(tmp_path):
    model = read_model(model_from(tmp_path, "[indicator.X]"))
    with pytest.raises(UsageError, match="needs the arm"):
        rest_positions(model, Approach.RANDOM, count=3, rng=np.random.default_rng(1))


def test_chance_draws_one_course_for_all_axes_of_a_common_cause(fum):
    still = replace(fum, indicators={n: replace(i, scatter=0.0) for n, i in fum.indicators.items()})
    side = parse_effect("contact_side@X,Y:size=0.5,switching=0.3", still)
    run = simulate(still, CYCLES, rng=np.random.default_rng(1), undeclared=[side])
    x, y = (run.axes[name].readings - fum.indicators[name].level for name in ("X", "Y"))
    assert np.ptp(x) == pytest.approx(0.5)
    assert y == pytest.approx(x, abs=0.011)
    rounding = parse_effect("resolution@X,Y:division=0.5", still)
    run = simulate(still, CYCLES, rng=np.random.default_rng(1), undeclared=[rounding])
    assert abs(np.corrcoef(run.axes["X"].readings, run.axes["Y"].readings)[0, 1]) < 0.6


def test_an_effect_both_declared_and_not_acts_twice(fum):
    step = DeclaredEffect("step", {"at_cycle": 9.0, "size": {"X": 0.5}})
    model = replace(fum, effects=(step,))
    run = simulate(model, CYCLES, rng=np.random.default_rng(1), undeclared=[step])
    assert np.ptp(run.axes["X"].readings) == pytest.approx(1.0, abs=0.03)


def test_alternating_sides_are_expected(fum):
    sides = DeclaredEffect("contact_side", {"switching": 1.0, "size": {"X": 0.5}})
    readings = predict(replace(fum, effects=(sides,)), CYCLES).axes["X"].readings
    assert readings - 0.1 == pytest.approx(np.resize([0.5, 0.0], 31))


def geared(model, **changes):
    """The model with its gearbox changed, and another at joint 2."""
    one = replace(model.gearboxes[1], **changes)
    return replace(model, gearboxes={1: one, 2: one})


def test_one_approach_holds_for_all_joints(fum):
    model = geared(fum)
    sides, moved = rest_positions(model, Approach.RANDOM, count=40, rng=np.random.default_rng(2))
    # without friction the load crosses the gap: half of it beyond the pose, in every joint
    half = math.radians(12 / 60) / 2
    whole = model.arm.jacobian(model.joints_deg) @ [half, half]
    assert len(set(sides)) == 2
    assert moved["X"] == pytest.approx(sides * whole[0])
    assert moved["Y"] == pytest.approx(sides * whole[1])


def test_what_friction_holds_on_the_driving_flank_is_the_closed_form_of_a_held_motor(fum):
    held = replace(fum, effects=(DeclaredEffect("held_motor", {}, 1),))
    rubbing = replace(held, gearboxes={1: replace(fum.gearboxes[1], friction=200.0)})
    sides, moved = rest_positions(
        rubbing, Approach.BOTH_SIDES, count=31, rng=np.random.default_rng(2)
    )
    assert sides.tolist() == BOTH.covariates["approach"].tolist()
    expected = predict(held, BOTH).axes
    for name in ("X", "Y"):
        assert moved[name] == pytest.approx(expected[name].readings - fum.indicators[name].level)


def test_the_drive_train_takes_the_place_of_the_closed_form(fum):
    held = replace(
        fum,
        effects=(DeclaredEffect("held_motor", {}, 1),),
        indicators={n: replace(i, scatter=0.0, resolution=None) for n, i in fum.indicators.items()},
    )
    moved = {"X": np.linspace(0, 1, 31)}
    run = simulate(held, BOTH, rng=np.random.default_rng(1), displacement=moved)
    assert run.axes["X"].readings - 0.1 == pytest.approx(moved["X"])


def test_a_stiffness_is_not_left_out_in_silence(fum):
    with pytest.raises(UsageError, match="without viscous friction or compliance"):
        rest_positions(
            geared(fum, stiffness=1e4), Approach.RANDOM, count=3, rng=np.random.default_rng(1)
        )


def run_command(capsys, *argv):
    code = main(["simulate", *map(str, argv)])
    return code, *capsys.readouterr()


def test_simulate_as_json(capsys, tmp_path):
    table = tmp_path / "run.csv"
    words = (EXAMPLE, "--seed", "3", "--effect", "step@Y:size=0.1,at_cycle=9", "--approach", "both")
    code, out, err = run_command(capsys, *words, "--json", "-o", table)
    document = json.loads(out, parse_constant=pytest.fail)
    assert (code, err) == (0, "")
    assert document["schema"] == "scara-iso/simulate/1"
    run = read_table(table)
    assert document["cycle"] == run.cycle.tolist()
    assert document["covariates"] == {"approach": run.covariates["approach"].tolist()}
    for name, axis in document["axes"].items():
        assert axis["readings"] == run.axes[name].readings.tolist()
        assert axis["resolution"] == run.axes[name].resolution
    assert "step" not in out + table.read_text(encoding="utf-8")
    assert run_command(capsys, *words) == (0, table.read_text(encoding="utf-8"), "")


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--temperature", "20"], 2),
        (["--temperature", "nan:3"], 2),
        (["--payload", "1,inf"], 2),
        (["--payload", ""], 2),
        (["--cycles", "1"], 2),
        (["--effect", "step@Q:size=1,at_cycle=3"], 2),
        (["--effect", "compliance:size=1"], 2),
        (["--effect", "held_motor:"], 2),
        (["-o", "/nowhere/run.csv"], 73),
    ],
)
def test_simulate_refuses(capsys, words, code):
    found, out, err = run_command(capsys, EXAMPLE, *words)
    assert (found, out) == (code, "")
    assert 1 <= len(err.splitlines()) <= 3


@pytest.mark.parametrize(
    ("knots", "said"),
    [
        ([[1, 2], [0.1, -0.2], [0, 0.1]], ""),
        ([[1], [0.1], [0.0]], ""),
        ([[1, 2], [0.1], [0.1, 0.1]], "lists of one length"),
        ([[], [], []], "lists of one length"),
        ([[1, 2], [0.1, 0.2], None], "lists of one length"),
        ([[1, 2], [0.1, "a"], [0, 0]], "a finite number"),
        ([[2, 2], [0.1, 0.2], [0, 0]], "must increase"),
        ([[1, 2], [0.1, 0.2], [0, -1e-9]], "no u is negative"),
    ],
)
def test_a_learned_course_has_knots_in_their_order_each_with_its_u(knots, said):
    found = _why_no_knots(knots)
    assert said in found
    assert bool(said) == bool(found)
