"""What a planned test of several poses tells of the joints, and what would help it."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag

from scara_iso.commands import main
from scara_iso.commands.diagnose import _of_poses
from scara_iso.diagnosis import CyclesWanted, design_of_poses, like_test, whole_cycles
from scara_iso.diagnosis.planning import PlannedPosesTest, other_tests
from scara_iso.effects import Conditions, find_effects
from scara_iso.robot import Arm, read_model
from scara_iso.tables import read_table

EXAMPLES = Path(__file__).parents[2] / "examples"
MODEL = EXAMPLES / "five_poses.toml"
ARM = Arm(250, 200, (-120, 120), (-145, 145))
STEP = [effect for effect in find_effects() if effect.name in ("step", "temperature")]


def planned(*joints, variances=(1e-10, 2e-10, 4e-6, 0), division=0.001):
    poses = {f"P{k}": pair for k, pair in enumerate(joints, 1)}
    cycles = Conditions(np.arange(2, 32), {})
    return PlannedPosesTest(cycles, ARM, poses, np.array(variances), (division, division))


def test_all_poses_show_a_joint_as_the_weighted_fit_of_one_number_does():
    plan = planned((10, 80), (-30, 110), (45, 60))
    pairs = list(plan.joints_deg.values())
    jacobians = [ARM.jacobian(pair) for pair in pairs]
    own = (4e-6 + 1e-6 / 12) * np.eye(2)
    covariance = block_diag(*(j @ np.diag([1e-10, 2e-10]) @ j.T + own for j in jacobians))
    for k, joint in enumerate(("joint 1", "joint 2")):
        column = np.concatenate([j[:, k] for j in jacobians])
        expected = (column @ np.linalg.inv(covariance) @ column) ** -0.5
        assert plan.sigma[joint] == pytest.approx(expected, rel=1e-6)


@pytest.fixture(scope="module")
def straight():
    return design_of_poses(planned((10, 3), (40, 4), (-40, 5)), effects=STEP)


def test_only_effects_that_are_asked_for_are_planned_for(straight):
    assert {name for travels in straight.smallest.values() for name in travels} == {"step"}


def test_other_poses_help_most_where_the_arm_is_straight(straight):
    assert straight.apart.angle_deg < 45
    first = straight.changes[0]
    assert "separating" in first.change
    assert first.apart.angle_deg > straight.apart.angle_deg + 30
    assert max(first.size_needed.values()) < 0.9


def test_what_is_logged_is_told_besides_and_longer_tests_find_less(straight):
    changes = {one.change: one for one in straight.changes}
    assert changes["the temperature logged"].adds == ("temperature",)
    assert max(changes["50 cycles"].size_needed.values()) < 0.9
    assert all(needed == pytest.approx(1, abs=0.2) for needed in changes[
        "the temperature logged"].size_needed.values())  # fmt: skip


def test_the_plan_of_a_table_has_the_scatter_of_its_joints():
    run, model = read_table(EXAMPLES / "five_poses.csv"), read_model(MODEL)
    used = CyclesWanted(None).used(run)
    rows = {str(pose): own for pose, own in zip(used.poses, used.rows, strict=True)}
    test = whole_cycles(run, rows)
    plan = like_test(test, model.arm, {pose: model.poses[pose] for pose in test.parts})
    assert plan.sources["joint 1"].value == pytest.approx(10e-6, rel=0.3)  # as simulated
    assert plan.sources["joint 2"].value == pytest.approx(15e-6, rel=0.3)
    assert plan.division == (0.001, 0.001)


def test_poses_approached_from_two_directions_are_planned_with_both(tmp_path):
    lines = (EXAMPLES / "five_poses.csv").read_text().splitlines()
    arrivals = [f"{way},{row}" for row in lines[6:] for way in ("+x", "-x")]
    both = tmp_path / "both.csv"
    both.write_text("\n".join([*lines[:5], f"approach,{lines[5]}", *arrivals]))
    once, twice = (
        _of_poses(read_model(MODEL), read_table(table), {}, CyclesWanted(None), None)
        for table in (EXAMPLES / "five_poses.csv", both)
    )
    assert [*twice.joints_deg][:2] == ["P1 from +x", "P1 from -x"]
    assert twice.joints_deg["P1 from -x"] == once.joints_deg["P1"]
    for joint, sigma in once.sigma.items():
        assert twice.sigma[joint] == pytest.approx(sigma / 2**0.5, rel=0.02)
    changes = [one.change for one in design_of_poses(twice, effects=STEP).changes]
    assert not any("approach" in words for words in changes), "it is there already"
    (proposed,) = (one for words, one in other_tests(twice) if "separating" in words)
    assert len(proposed.joints_deg) == len(twice.joints_deg)


@pytest.mark.parametrize(
    ("argv", "code", "said"),
    [
        (["--model", EXAMPLES / "fum_scara.toml"], 2, "several poses"),
        (["--model", MODEL, EXAMPLES / "fum_scara_table1.csv"], 2, "several poses"),
        (["--model", MODEL, "--cycles", "7"], 65, "usable cycles"),
        (["--model", MODEL, "--sigma", "-1"], 2, "not a positive"),
        (["--model", EXAMPLES / "none.toml"], 66, "none.toml"),
    ],
)
def test_a_design_of_poses_that_cannot_be_is_refused(capsys, argv, code, said):
    assert main(["diagnose", "--design", *map(str, argv)]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
