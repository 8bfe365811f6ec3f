"""Reversals in readings, from the drive train through time, against a model's gears."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles.drivetrain import DriveTrain, Move, arrivals
from undeclared.gearbox import freely_reversed

from scara_iso.base.errors import UsageError
from scara_iso.commands import main
from scara_iso.diagnosis import Verdict, gears
from scara_iso.diagnosis.closed_loop import close_the_loop, declarations
from scara_iso.diagnosis.engine.residual import CyclesWanted
from scara_iso.diagnosis.gears import diagnose_reversals, diagnose_run_reversals
from scara_iso.effects import Conditions
from scara_iso.reporting.backlash import reversals_section
from scara_iso.reporting.shared.blocks import Text
from scara_iso.robot.model import DeclaredEffect
from scara_iso.robot.model_file import read_model
from scara_iso.robot.prediction import predict
from scara_iso.run import Axis, Run
from scara_iso.tables import read_table, write_table

ROOT = Path(__file__).parents[2]
MODEL = """
[robot]
name = "two links"
link_1_mm = 400
link_2_mm = 300

[pose]
joint_deg = [0, 90]

[gearbox.joint_1]
Im = 2.65e-4
IL = 4.749
arcmin = 12
payload_kg = 2

[indicator.X]
resolution = 0.001

[indicator.Y]
resolution = 0.001
"""
LEVER = {"X": -300.0, "Y": 400.0}
"""mm that the tool at (400, 300) moves for each radian of joint 1, and its distance 0.5 m."""
PAYLOADS = (0.0, 4.0, 8.0, 16.0)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.fixture
def model_file(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text(MODEL, encoding="utf-8")
    return path


@pytest.fixture
def model(model_file):
    return read_model(model_file)


def load_inertia(payload):
    return 4.749 + (payload - 2) * 0.5**2


def train(payload, **changes):
    return DriveTrain(**{
        "motor_inertia": 2.65e-4, "load_inertia": load_inertia(payload),
        "gap": np.radians(12 / 60), **changes,
    })  # fmt: skip


def free_motor(payload, **changes):
    return freely_reversed(train(payload, **changes))


def held_motor(payload, rng, *, count=4, **changes):
    """Half of what lies between the rests after either approach, with the motor held."""
    move = Move(speed=0.2, deceleration=10.0)
    side = np.resize([1, -1], count)
    rest = arrivals(train(payload, **changes), move, side, count=count, rng=rng).load_angle
    return float(rest[side > 0].mean() - rest[side < 0].mean())


def table(width, rng, *, scatter=0.003, payloads=PAYLOADS, cycles=32, common=0.0):
    """Readings whose reversal is ``width(payload)`` rad wide at joint 1."""
    payload = np.repeat(payloads, cycles // len(payloads))
    side = np.concatenate([rng.permutation(np.resize([1.0, -1.0], cycles // len(payloads)))
                           for _ in payloads])  # fmt: skip
    wide = {p: width(p) for p in payloads}
    wobble = rng.normal(0, common, cycles) if common else np.zeros(cycles)
    half = side * [wide[p] / 2 for p in payload] + wobble
    axes = {
        name: Axis(
            name, np.round(lever * half + rng.normal(0, scatter, cycles), 3), resolution=0.001
        )
        for name, lever in LEVER.items()
    }
    cycle = np.arange(2, cycles + 2)
    return Run(cycle, axes, covariates={"approach": side, "payload_kg": payload})


def test_the_rotor_seen_through_the_gear_is_found_per_payload(model, rng):
    found = diagnose_run_reversals(table(lambda p: free_motor(p, ratio=50), rng), model, seed=1)
    (effect,) = found.gear.effects
    assert (effect.effect, effect.joint) == ("reflected_inertia", 1)
    low, high = effect.intervals["N"]
    assert low < 50 < high < 1.2 * low
    assert found.gear.error.after.held_out_rms < 0.1 * found.gear.error.before.held_out_rms
    assert not found.mirrored
    assert [one.payload_kg for one in found.reversals if one.axis == "X"] == list(PAYLOADS)
    for one in found.reversals:
        truth = LEVER[one.axis] / 2 * free_motor(one.payload_kg, ratio=50)
        assert one.predicted_after_mm == pytest.approx(truth, rel=0.05)
        assert abs(one.half_width_mm - truth) < 5 * one.uncertainty_mm


def test_payloads_that_were_approached_from_one_side_each_have_no_reversal(model, rng):
    run = table(free_motor, rng)
    side = np.where(run.covariates["payload_kg"] < 6, 1.0, -1.0)
    run = replace(run, covariates={**run.covariates, "approach": side})
    assert not diagnose_run_reversals(run, model, seed=1).reversals


def test_a_motor_held_with_friction_leaves_the_load_on_the_driving_flank(model, rng):
    found = diagnose_run_reversals(
        table(lambda p: held_motor(p, rng, coulomb=300.0), rng), model, seed=1
    )
    assert {e.effect for e in found.gear.effects} == {"held_motor"}
    assert not found.mirrored


def test_without_friction_the_load_rests_ahead_and_sizes_are_compared(model, rng):
    found = diagnose_run_reversals(table(lambda p: held_motor(p, rng), rng), model, seed=1)
    assert {e.effect for e in found.gear.effects} == {"held_motor"}
    assert found.mirrored
    assert "ahead" in " ".join(found.notes)
    for one in found.reversals:
        assert one.predicted_after_mm == pytest.approx(one.half_width_mm, abs=0.01)


def test_two_effects_are_told_apart_by_the_payloads(model, rng):
    wide = table(
        lambda p: free_motor(p, ratio=50, gap=np.radians(19 / 60)), rng,
        payloads=(0.0, 8.0, 24.0, 60.0), cycles=64, scatter=0.001,
    )  # fmt: skip
    found = diagnose_run_reversals(wide, model, seed=1)
    assert {e.effect for e in found.gear.effects} == {"reflected_inertia", "gap"}
    values = {k: v for e in found.gear.effects for k, v in e.parameters.items()}
    assert values["N"] == pytest.approx(50, rel=0.1)
    assert values["factor"] == pytest.approx(19 / 12, rel=0.15)


def test_a_shape_that_no_effect_gives_is_unexplained(model, rng):
    widths = dict(zip(PAYLOADS, (1e-4, 9e-4, 1e-4, 9e-4), strict=True))
    found = diagnose_run_reversals(table(lambda p: -widths[p], rng), model, seed=1)
    assert found.gear.verdict is Verdict.UNEXPLAINED
    assert found.gear.effects == ()
    assert found.gear.candidates


@pytest.mark.slow
@pytest.mark.parametrize("common", [0.0, 3e-5])
def test_scatter_alone_is_silent(common, model):
    """Also where it comes from the joint, and X and Y scatter together."""
    alarms = 0
    for seed in range(100):
        run = table(free_motor, np.random.default_rng(seed), common=common)
        alarms += diagnose_run_reversals(run, model, seed=1).gear.verdict is not Verdict.NOTHING
    assert alarms <= 10


def test_one_payload_cannot_separate_and_says_what_would(model, rng):
    run = table(lambda p: 1.9 * free_motor(p, ratio=50), rng, payloads=(2.0,))
    found = diagnose_run_reversals(run, model, seed=1)
    assert found.gear.error.after.held_out_rms is None
    assert "vary the inertia of the payload" in " ".join(found.notes)
    # a gap is no rival here: no catalogue is wrong by three orders of magnitude
    assert {e.effect for e in found.gear.effects} == {"reflected_inertia"}


def test_the_saved_effect_explains_the_next_table(model_file, tmp_path, capsys, rng):
    for name in ("first", "second"):
        run = table(lambda p: free_motor(p, ratio=50), rng)
        (tmp_path / f"{name}.csv").write_text(write_table(run), encoding="utf-8")
    new = tmp_path / "new.toml"
    first = ["diagnose", str(tmp_path / "first.csv"), "--model", str(model_file)]
    options = ["--cycles", "32", "--first-cycle-discarded", "--json"]
    assert main([*first, *options, "--save-model", str(new)]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert found["gear"]["effects"][0]["effect"] == "reflected_inertia"
    assert [e["effect"] for e in found["effects"]] == ["lost_motion"]
    assert [e.name for e in read_model(new).effects] == ["reflected_inertia"]
    assert main(["diagnose", str(tmp_path / "second.csv"), "--model", str(new), *options]) == 0
    again = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert again["verdict"] == again["gear"]["verdict"] == "nothing-to-explain"


def said(found):
    blocks = reversals_section(found).blocks
    return "\n".join(block.text if isinstance(block, Text) else str(block) for block in blocks)


def test_it_is_said_in_words(model, rng):
    run = table(lambda p: free_motor(p, ratio=50), rng)
    text = said(diagnose_run_reversals(run, model, seed=1))
    assert "reflected inertia at joint 1: probability" in text
    assert "each payload predicted without it" in text
    gear = replace(model.gearboxes[1], payload_kg=None)
    lacking = said(diagnose_run_reversals(run, replace(model, gearboxes={1: gear}), seed=1))
    assert "the model lacks gearbox.joint_1.payload_kg" in lacking


def test_what_the_model_lacks_is_named(model, rng):
    run = table(free_motor, rng)
    bare = replace(model, arm=None, joints_deg=None, gearboxes={})
    found = diagnose_run_reversals(run, bare, seed=1)
    assert found.gear is None
    assert found.missing == (
        "robot.link_1_mm", "robot.link_2_mm", "pose.joint_deg", "gearbox.joint_1",
    )  # fmt: skip
    assert len(found.reversals) == 8
    without = replace(run, covariates={"approach": run.covariates["approach"]})
    assert diagnose_run_reversals(without, model, seed=1) is None


def test_scatter_of_two_axes_wants_three_degrees_of_freedom(model, rng):
    run = table(lambda p: free_motor(p, ratio=50), rng, payloads=(2.0,))
    up, down = (np.flatnonzero(run.covariates["approach"] == side) for side in (1, -1))
    enough = run.take(np.sort([*up[:3], *down[:2]]))
    assert diagnose_run_reversals(enough, model, seed=1).gear is not None
    few = diagnose_run_reversals(run.take(np.sort([*up[:2], *down[:2]])), model, seed=1)
    assert few.gear is None
    assert "no scatter can be told" in few.notes[0]


def test_a_load_on_either_side_doubles_the_chance(model, monkeypatch):
    run = table(lambda p: 1.02 * free_motor(p), np.random.default_rng(4))
    found = diagnose_run_reversals(run, model, seed=1)

    def on_one_side(data, *, seed, sides):
        assert sides == 2
        return diagnose_reversals(data, seed=seed, sides=1)

    monkeypatch.setattr(gears, "diagnose_reversals", on_one_side)
    once = diagnose_run_reversals(run, model, seed=1)
    assert found.gear.p_value == pytest.approx(min(1.0, 2 * once.gear.p_value))


def test_a_payload_approached_from_one_side_is_left_out(model, rng):
    run = table(free_motor, rng)
    side = np.where(run.covariates["payload_kg"] == 4, 1.0, run.covariates["approach"])
    found = diagnose_run_reversals(
        replace(run, covariates={**run.covariates, "approach": side}), model, seed=1
    )
    assert {one.payload_kg for one in found.reversals} == {0.0, 8.0, 16.0}
    assert "payload 4 kg" in found.notes[0]


def test_what_the_model_declares_is_no_part_of_a_reversal(model, rng):
    """A step amid the approaches of one payload, which come in no order."""
    run = table(lambda _: 1e-4, rng, scatter=1e-4)
    declared = DeclaredEffect("step", {"size": {"X": 0.5}, "at_cycle": 14.0})
    moved = run.axes["X"].readings + 0.5 * (run.cycle >= 14)
    axes = {**run.axes, "X": replace(run.axes["X"], readings=moved)}
    known = replace(model, effects=(declared,))
    found = diagnose_run_reversals(replace(run, axes=axes), known, seed=1)
    plain = diagnose_run_reversals(run, model, seed=1)
    for one, other in zip(found.reversals, plain.reversals, strict=True):
        assert one.half_width_mm == pytest.approx(other.half_width_mm, abs=1e-9)


def test_the_predicted_reversal_follows_the_payload(model):
    payload, side = np.array(PAYLOADS), np.array([1.0, -1.0, 1.0, -1.0])
    run = predict(model, Conditions(np.arange(1, 5), {"payload_kg": payload, "approach": side}))
    for name, lever in LEVER.items():
        expected = [s * lever / 2 * free_motor(p) for p, s in zip(payload, side, strict=True)]
        np.testing.assert_allclose(run.axes[name].readings, expected, rtol=1e-9)


def test_a_payload_that_the_load_s_inertia_cannot_hold_is_refused(model):
    gear = replace(model.gearboxes[1], IL=0.4)
    procedure = Conditions(np.arange(1, 3), {"payload_kg": np.zeros(2), "approach": np.ones(2)})
    with pytest.raises(UsageError, match=r"gearbox\.joint_1: without its payload of 2 kg"):
        predict(replace(model, gearboxes={1: gear}), procedure)


def test_the_reversal_of_each_payload_is_no_course_over_the_cycles(tmp_path):
    text = (
        (ROOT / "examples" / "fum_scara.toml")
        .read_text(encoding="utf-8")
        .replace("ratio = 50 ", "payload_kg = 0\nratio = 50 ")
    )
    (tmp_path / "m.toml").write_text(text, encoding="utf-8")
    true = text + '\n[[effect]]\nname = "reflected_inertia"\njoint = 1\nN = 50\n'
    (tmp_path / "t.toml").write_text(true, encoding="utf-8")
    words = ["--approach", "both", "--payload", "0,2,5", "--seed", "2"]
    table = tmp_path / "a.csv"
    assert main(["simulate", str(tmp_path / "t.toml"), *words, "-o", str(table)]) == 0
    found = close_the_loop(
        read_table(table), read_model(tmp_path / "m.toml"), CyclesWanted(), seed=9283
    )
    assert "periodic" in {one.effect for one in found.effects}
    assert "periodic" in found.reversals.accounts_for
    assert {one.name for one in declarations(found)} == {"reflected_inertia"}


def test_a_course_that_is_the_gear_s_is_called_so_and_not_saved_beside_it(tmp_path, capsys):
    (tmp_path / "m.toml").write_text(
        "[robot]\nlink_1_mm = 400\nlink_2_mm = 300\n[gearbox.joint_1]\nIm = 2.65e-4\n"
        "IL = 4.749\narcmin = 12\nratio = 50\npayload_kg = 2\n[pose]\njoint_deg = [20, 60]\n"
        "[indicator.X]\nscatter = 0.003\nresolution = 0.001\n"
        "[indicator.Y]\nscatter = 0.003\nresolution = 0.001\n",
        encoding="utf-8",
    )
    effect = '[[effect]]\nname = "reflected_inertia"\njoint = 1\nN = 50\n'
    true = (tmp_path / "m.toml").read_text(encoding="utf-8") + effect
    (tmp_path / "t.toml").write_text(true, encoding="utf-8")
    table, saved = str(tmp_path / "a.csv"), str(tmp_path / "s.toml")
    words = ["--approach", "both", "--payload", "0,2,5", "--seed", "3", "-o", table]
    assert main(["simulate", str(tmp_path / "t.toml"), *words]) == 0
    assert (
        main(["diagnose", table, "--model", str(tmp_path / "m.toml"), "--save-model", saved]) == 0
    )
    assert "the effects on the gear account for" in capsys.readouterr().out
    assert "learned" not in Path(saved).read_text(encoding="utf-8")
    assert main(["diagnose", table, "--model", saved]) == 0
    assert "Nothing besides what the model declares" in capsys.readouterr().out
