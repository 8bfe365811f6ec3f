"""The plan: cube, plane and poses, each condition checked on the result by hand."""

import csv
import itertools
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag

import scara_iso
from scara_iso.base.errors import UsageError
from scara_iso.commands import main
from scara_iso.iso9283.poses import DiagonalPlane, PoseTestConditions, Solid, _reached, make_plan
from scara_iso.robot import Model, Rated
from scara_iso.robot.arm import Arm, Elbow, Workspace
from scara_iso.testfolder import read_test

FUM = Arm(400, 300, (-130, 130), (-145, 145), (0, 200))  # split and limits are assumed
TALL = Arm(400, 300, (-130, 130), (-145, 145), (-300, 300))


@cache
def box_plan():
    return make_plan(FUM, solid=Solid.BOX, plane=DiagonalPlane.C4_C1_C6_C7)


def planned(plane, solid):
    return box_plan() if solid is Solid.BOX else make_plan(FUM, plane=plane)


def points(plan):
    return np.array([(p.x_mm, p.y_mm, p.z_mm) for p in plan.poses])


def test_a_short_stroke_limits_the_cube():
    plan = make_plan(FUM)
    assert plan.stroke_limits
    assert plan.size_mm == pytest.approx((200, 200, 200))
    assert not make_plan(TALL).stroke_limits
    assert make_plan(TALL).size_mm == pytest.approx((434.362,) * 3, abs=2e-3)


def test_a_box_takes_the_whole_stroke_and_more_room():
    box, cube = box_plan(), make_plan(FUM)
    assert box.size_mm[2] == 200
    assert math.prod(box.size_mm) > 4 * math.prod(cube.size_mm)


@pytest.mark.parametrize("solid", Solid)
def test_the_whole_solid_is_within_reach_and_stroke(solid):
    plan = planned(DiagonalPlane.C1_C2_C7_C8, solid)
    low, high = plan.corners.min(axis=0), plan.corners.max(axis=0)
    x, y = np.meshgrid(np.linspace(low[0], high[0], 150), np.linspace(low[1], high[1], 150))
    assert Workspace.of(FUM).contains(np.stack([x, y], axis=-1)).all()
    assert low[2] >= 0
    assert high[2] <= 200


@pytest.mark.parametrize(
    ("plane", "solid"),
    [(plane, Solid.CUBE) for plane in DiagonalPlane] + [(DiagonalPlane.C4_C1_C6_C7, Solid.BOX)],
)
def test_the_poses_lie_on_the_diagonals_of_the_plane(plane, solid):
    plan = planned(plane, solid)
    number = [c - 1 for c in plane.corners]
    a, b, c, d = plan.corners[number]
    assert a - b == pytest.approx(d - c)  # four corners in a plane, a rectangle
    assert (a - b) @ (b - c) == pytest.approx(0)
    centre, *others = points(plan)
    assert centre == pytest.approx((a + b + c + d) / 4, abs=1e-3)
    for pose, corner in zip(others, (a, b, c, d), strict=True):
        assert np.linalg.norm(pose - corner) == pytest.approx(plan.m_mm, abs=2e-3)
        assert np.linalg.norm(np.cross(pose - corner, centre - corner)) < 2e-3 * plan.diagonal_mm


@pytest.mark.parametrize(
    ("plane", "solid"),
    [(plane, Solid.CUBE) for plane in DiagonalPlane] + [(DiagonalPlane.C4_C1_C6_C7, Solid.BOX)],
)
def test_the_diagonal_of_the_plane_is_that_of_the_solid(plane, solid):
    """The paper's L and ISO 9283's are one number."""
    plan = planned(plane, solid)
    a, b, c, d = plan.corners[[c - 1 for c in plane.corners]]
    space = math.hypot(*plan.size_mm)
    assert np.linalg.norm(c - a) == pytest.approx(space)
    assert np.linalg.norm(d - b) == pytest.approx(space)
    assert plan.diagonal_mm == pytest.approx(space)
    assert plan.m_over_diagonal == pytest.approx(0.1)


def test_the_four_planes_are_diagonal_and_the_corners_those_of_a_box():
    corners = box_plan().corners
    x, y, z = corners[6] - corners[0]
    expected = {(sx * x, sy * y, sz * z) for sx, sy, sz in itertools.product((0, 1), repeat=3)}
    found = {tuple(np.round(c - corners[0], 9)) for c in corners}
    assert found == {tuple(np.round(e, 9)) for e in expected}
    assert corners[4:] - corners[:4] == pytest.approx(np.tile([0, 0, z], (4, 1)))
    for plane in DiagonalPlane:
        a, b, c, _ = corners[[k - 1 for k in plane.corners]]
        spans = np.count_nonzero(np.abs(np.cross(b - a, c - a)) > 1e-6)
        assert spans == 2  # parallel to one edge only: no face of the box


def test_the_joints_bring_the_tool_to_the_poses_with_one_elbow():
    for elbow in (None, *Elbow):
        plan = make_plan(FUM, elbow=elbow)
        for pose in plan.poses:
            joints = (pose.joint_1_deg, pose.joint_2_deg, pose.joint_3_mm, pose.joint_4_deg)
            expected = (pose.x_mm, pose.y_mm, pose.z_mm, 0)
            assert FUM.forward(joints) == pytest.approx(expected, abs=1e-9)
            assert np.all(FUM.excess(joints) == 0)
            assert np.sign(pose.joint_2_deg) == plan.elbow.sign
            away = min(abs(pose.joint_2_deg), 180 - abs(pose.joint_2_deg))
            assert pose.singularity_deg == pytest.approx(away)
            turn = abs(math.sin(math.radians(pose.joint_2_deg)))
            assert pose.manipulability == pytest.approx(turn)
        assert elbow in (None, plan.elbow)


def test_an_elbow_named_keeps_the_cube_in_its_own_reach():
    arm = Arm(400, 300, (-60, 100), (-145, 145), (0, 900))
    either, right = make_plan(arm), make_plan(arm, elbow=Elbow.RIGHT)
    assert right.size_mm[0] <= either.size_mm[0]
    face = right.corners[:4, :2]
    assert Workspace.of(arm, (Elbow.RIGHT,)).contains(face).all()


def test_poses_that_no_elbow_reaches_are_refused_for_each():
    arm = Arm(400, 300, (-60, 100), (-145, 145), (0, 900))
    with pytest.raises(UsageError, match=r"no elbow reaches all poses: .*; "):
        _reached(arm, np.array([[900.0, 0.0, 100.0, 0.0]]), tuple(Elbow))


def test_one_row_for_each_visit_holds_what_a_robot_needs():
    conditions = PoseTestConditions(velocity_percent=50, load_percent=10, dwell_s=1.5)
    rows = make_plan(FUM, conditions=conditions).rows()
    assert [row["pose"] for row in rows] == ["P5", "P4", "P3", "P2", "P1"]
    assert [row["visit"] for row in rows] == [1, 2, 3, 4, 5]
    assert {"x_mm", "theta_deg", "joint_1_deg", "joint_3_mm", "singularity_deg"} <= set(rows[0])
    assert {row["velocity_percent"] for row in rows} == {50}
    assert {row["dwell_s"] for row in rows} == {1.5}
    assert [row["from_pose"] for row in rows] == ["P1", "P5", "P4", "P3", "P2"]
    assert {row["path"] for row in rows} == {"linear"}
    assert {row["velocity_mm_s"] for row in rows} == {row["load_kg"] for row in rows} == {None}
    rated = make_plan(FUM, conditions=conditions, rated=Rated(2.0, 1200.0)).rows()
    assert {(row["velocity_mm_s"], row["load_kg"]) for row in rated} == {(600.0, 0.2)}


def test_31_cycles_are_run_and_30_used():
    conditions = make_plan(FUM).conditions
    assert (conditions.cycles, conditions.used) == (31, 30)


@pytest.mark.parametrize("share", [0.079, 0.121, math.nan])
def test_m_outside_equation_1_is_refused(share):
    with pytest.raises(UsageError, match="outside"):
        make_plan(FUM, m_over_diagonal=share)
    assert make_plan(FUM, m_over_diagonal=0.08).m_mm == pytest.approx(0.08 * 200 * math.sqrt(3))


@pytest.mark.parametrize(
    ("arm", "says"),
    [
        (Arm(400, 300, (-130, 130), (-145, 145)), "stroke of 0 mm"),
        (Arm(400, 300, (-130, 130), (90, 90), (0, 200)), "leave no area"),
        (Arm(400, 300, (-130, 130), (-145, 145), (0, 200), (400, 500)), "joint 4"),
    ],
)
def test_impossible_robots_are_refused(arm, says):
    with pytest.raises(UsageError, match=says):
        make_plan(arm)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"cycles": 1}, "no cycle is left"),
        ({"velocity_percent": 0}, "velocity_percent is 0"),
        ({"load_percent": 101}, "load_percent is 101"),
        ({"dwell_s": math.nan}, "dwell_s is nan"),
        ({"order": ("P1", "P7")}, "no pose 'P7'"),
        ({"order": ()}, "no pose is visited"),
    ],
)
def test_conditions_that_cannot_be_meant_are_refused(change, says):
    with pytest.raises(UsageError, match=says):
        PoseTestConditions(**change)


def test_rated_values_are_read_from_the_model_and_said(tmp_path, capsys):
    model = tmp_path / "rated.toml"
    text = (Path(__file__).parents[2] / "examples/fum_scara.toml").read_text(encoding="utf-8")
    model.write_text(f"[rated]\nload_kg = 2\nvelocity_mm_s = 1000\n{text}", encoding="utf-8")
    points = tmp_path / "points.csv"
    assert main(["plan", str(model), "--velocity", "50", "-o", str(points)]) == 0
    told = capsys.readouterr().out
    assert "(1000 mm/s)" in told
    with points.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["velocity_mm_s"] for row in rows] == ["500.0"] * 5
    assert [row["load_kg"] for row in rows] == ["2.0"] * 5
    file = tmp_path / "test.toml"
    assert main(["plan", str(model), "--velocity", "50", "-o", str(file)]) == 0
    test = read_test(tmp_path)
    assert (test.schedule.velocities, test.schedule.loads) == ((50.0,), (100.0,))
    assert test.robot.rated_velocity_mm_s == 1000
    assert [test.poses[row["pose"]].x_mm for row in rows] == [float(row["x_mm"]) for row in rows]
    written = file.read_bytes()
    assert main(["plan", str(model), "-o", str(file)]) == 73  # may hold what somebody stated
    assert file.read_bytes() == written
    capsys.readouterr()
    model.write_text(f"[rated]\nload_kg = -2\nmass = 1\n{text}", encoding="utf-8")
    assert main(["plan", str(model)]) == 65
    said = capsys.readouterr().err
    assert "rated.load_kg: must be positive" in said
    assert "rated.mass: no such key" in said


FIVE_POSES = Path(__file__).parents[2] / "examples" / "five_poses.toml"


def angles(arm, joints):
    """Return the angles in degrees between what moves all of some poses, written out."""
    (a, b), (p, q) = (arm.link_1_mm, arm.link_2_mm), np.radians(np.array(joints, dtype=float)).T
    x, y = a * np.cos(p) + b * np.cos(p + q), a * np.sin(p) + b * np.sin(p + q)
    still, all_of = np.zeros_like(x), np.ones_like(x)
    moves = {
        "joint 1": (-y, x), "joint 2": (-b * np.sin(p + q), b * np.cos(p + q)),
        "along the arm": (x, y), "X everywhere": (all_of, still), "Y everywhere": (still, all_of),
    }  # fmt: skip
    unit = {name: np.concatenate(xy) / np.linalg.norm(xy) for name, xy in moves.items()}
    return {
        (one, other): math.degrees(math.acos(min(1, abs(unit[one] @ unit[other]))))
        for one, other in itertools.combinations(unit, 2)
    }


@pytest.fixture(scope="module")
def separating():
    return scara_iso.plan_separating(FIVE_POSES)


def test_separating_poses_tell_the_joints_apart_better_than_those_of_the_model(separating):
    proposed, given = separating.apart["proposed"], separating.apart["given"]
    assert proposed.angle_deg > given.angle_deg + 10
    assert proposed.observability_index > 1.3 * given.observability_index
    assert proposed.smallest_angle_deg > given.smallest_angle_deg
    assert proposed.uncertainty < 0.7 * given.uncertainty


def test_separating_poses_are_planned_at_the_velocity_and_load_asked_for():
    asked = {"cycles": 20, "velocity": 50.0, "load": 10.0, "dwell": 3.0}
    conditions = scara_iso.plan_separating(FIVE_POSES, **asked).conditions
    assert conditions == PoseTestConditions(
        cycles=20, velocity_percent=50.0, load_percent=10.0, dwell_s=3.0
    )


def test_the_angles_of_separating_poses_are_those_of_their_movements(separating):
    joints = [(pose.joint_1_deg, pose.joint_2_deg) for pose in separating.poses]
    found, expected = separating.apart["proposed"], angles(separating.arm, joints)
    assert found.angle_deg == pytest.approx(expected["joint 1", "joint 2"])
    assert found.smallest_angle_deg == pytest.approx(min(expected.values()))
    assert expected[found.between] == pytest.approx(min(expected.values()))
    movements = np.concatenate([separating.arm.jacobian(one) for one in joints])
    assert found.observability_index == pytest.approx(1 / np.linalg.cond(movements))


def test_the_uncertainty_at_separating_poses_is_that_of_a_weighted_fit(separating):
    arm, covariances, moves = separating.arm, [], []
    for pose in separating.poses:
        joints = (pose.joint_1_deg, pose.joint_2_deg)
        jacobian = arm.jacobian(joints)
        dial = (arm.link_1_mm + arm.link_2_mm) / 5
        covariances.append(jacobian @ jacobian.T + dial**2 * np.eye(2))
        moves.append(np.column_stack([jacobian, arm.forward(joints), np.eye(2)]))
    root = np.linalg.inv(np.linalg.cholesky(block_diag(*covariances)))
    seen = root @ np.concatenate(moves)
    errors = [
        np.linalg.inv(seen[:, [joint, other]].T @ seen[:, [joint, other]])[0, 0] ** 0.5
        for joint in (0, 1)
        for other in range(5)
        if other != joint
    ]
    assert separating.apart["proposed"].uncertainty == pytest.approx(max(errors))


def test_separating_poses_are_reached_with_one_elbow_and_leave_room(separating):
    arm = separating.arm
    assert np.array([one.z_mm for one in separating.poses]) == pytest.approx(0)
    for pose in separating.poses:
        joints = (pose.joint_1_deg, pose.joint_2_deg)
        assert arm.forward(joints) == pytest.approx((pose.x_mm, pose.y_mm), abs=1e-6)
        assert np.all(arm.excess(joints) == 0)
        assert np.sign(math.sin(math.radians(joints[1]))) == separating.elbow.sign
        assert pose.singularity_deg > 19
    for one, other in itertools.combinations(points(separating), 2):
        assert np.linalg.norm(one - other) > 0.11 * (arm.link_1_mm + arm.link_2_mm)


def test_separating_poses_are_planned_from_the_shell(tmp_path, capsys):
    visits = tmp_path / "visits.csv"
    assert main(["plan", str(FIVE_POSES), "--separating", "-o", str(visits)]) == 0
    out = capsys.readouterr().out
    assert "of the model" in out
    assert "not the poses of ISO 9283" in out
    rows = list(csv.DictReader(visits.read_text(encoding="utf-8").splitlines()))
    assert [row["pose"] for row in rows] == ["P5", "P4", "P3", "P2", "P1"]
    assert {row["path"] for row in rows} == {"joint"}


@pytest.mark.parametrize(
    ("options", "said"), [(["--solid", "box"], "--solid"), (["--m", "0.11"], "--m")]
)
def test_a_cube_is_refused_beside_separating(options, said, capsys):
    assert main(["plan", str(FIVE_POSES), "--separating", *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err


@pytest.mark.parametrize("turns", [((-1, 1), (80, 90)), ((-180, 180), (-10, 10))])
def test_limits_without_room_for_five_poses_are_refused(turns):
    model = Model("", {}, arm=Arm(250, 200, *turns))
    with pytest.raises(UsageError, match="leave no"):
        scara_iso.plan_separating(model)


@pytest.mark.parametrize("option", ["--separating", "--excel-locale=de"])
def test_a_plan_that_makes_no_test_says_what_to_write(option, tmp_path, capsys):
    words = ["plan", "examples/fum_scara.toml", option, "-o", str(tmp_path / "test.toml")]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert f"{option.partition('=')[0]} makes no test.toml" in said
    assert "let the name end in .csv" in said
    assert [*tmp_path.iterdir()] == []
