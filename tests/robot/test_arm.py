"""SCARA geometry against homogeneous transforms, finite differences and round trips."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from scara_iso.base.errors import UsageError
from scara_iso.robot.arm import Arm, Elbow

FUM = Arm(400, 300, (-130, 130), (-145, 145), (0, 200))  # the split of 0.7 m is assumed
angles = st.floats(-179, 179)
lengths = st.floats(50, 1000)


def denavit_hartenberg(arm, q):
    """Tool frame as a product of four homogeneous transforms: the independent oracle."""

    def link(theta, d, a):
        c, s = math.cos(math.radians(theta)), math.sin(math.radians(theta))
        return np.array([[c, -s, 0, a * c], [s, c, 0, a * s], [0, 0, 1, d], [0, 0, 0, 1]])

    return (
        link(q[0], 0, arm.link_1_mm)
        @ link(q[1], 0, arm.link_2_mm)
        @ link(0, q[2], 0)
        @ link(q[3], 0, 0)
    )


@given(lengths, lengths, angles, angles, st.floats(-300, 300), angles)
def test_forward_is_the_product_of_its_transforms(l_1, l_2, q_1, q_2, q_3, q_4):
    arm = Arm(l_1, l_2)
    frame = denavit_hartenberg(arm, (q_1, q_2, q_3, q_4))
    x, y, z, theta = arm.forward((q_1, q_2, q_3, q_4))
    assert [x, y, z] == pytest.approx(frame[:3, 3], abs=1e-9)
    turn = complex(frame[0, 0], frame[1, 0])
    assert abs(turn - np.exp(1j * math.radians(theta))) < 1e-12


@given(lengths, lengths, angles, st.floats(0.01, 179.9), st.floats(0, 200), angles)
def test_inverse_undoes_forward_for_both_elbows(l_1, l_2, q_1, q_2, q_3, q_4):
    arm = Arm(l_1, l_2, quill_mm=(0, 200), joint_4_deg=(-720, 720))
    for elbow in Elbow:
        joints = np.array([q_1, elbow.sign * q_2, q_3, q_4])
        pose = arm.forward(joints)
        again = arm.inverse(pose, elbow=elbow)
        assert arm.forward(again)[:3] == pytest.approx(pose[:3], abs=1e-6)
        assert math.remainder(arm.forward(again)[3] - pose[3], 360) == pytest.approx(0, abs=1e-9)
        if np.hypot(pose[0], pose[1]) > 1e-3:
            assert again[:2] == pytest.approx(joints[:2], abs=1e-4)


def test_inverse_and_forward_take_many_poses_at_once():
    joints = np.random.default_rng(1).uniform((-130, 1, 0, -90), (130, 145, 200, 90), (5, 7, 4))
    again = FUM.inverse(FUM.forward(joints), elbow=Elbow.RIGHT)
    assert again == pytest.approx(joints, abs=1e-8)
    planar = FUM.inverse(FUM.forward(joints[..., :2]), elbow=Elbow.RIGHT)
    assert planar == pytest.approx(joints[..., :2], abs=1e-8)


@given(lengths, lengths, angles, angles, angles)
def test_jacobian_is_the_slope_of_forward(l_1, l_2, q_1, q_2, q_4):
    arm, joints, step = Arm(l_1, l_2), np.array([q_1, q_2, 10.0, q_4]), 1e-3
    per_unit = np.array([180 / math.pi, 180 / math.pi, 1, 180 / math.pi])
    rows = np.array([1, 1, 1, math.pi / 180])
    slopes = [
        (arm.forward(joints + step * e) - arm.forward(joints - step * e)) / (2 * step)
        for e in np.eye(4)
    ]
    expected = np.array(slopes).T * per_unit * rows[:, None]
    assert arm.jacobian(joints) == pytest.approx(expected, abs=1e-5 * (l_1 + l_2))
    assert arm.jacobian(joints[:2]) == pytest.approx(expected[:2, :2], abs=1e-5 * (l_1 + l_2))


@given(st.floats(-350, 350), st.floats(0, 350), lengths, lengths)
def test_reach_is_that_of_every_joint_2_between_its_limits(low, width, l_1, l_2):
    arm = Arm(l_1, l_2, joint_2_deg=(low, low + width))
    q_2 = np.linspace(low, low + width, 4001)
    radii = np.abs(l_1 + l_2 * np.exp(1j * np.radians(q_2)))
    inner, outer = arm.reach()
    assert inner <= radii.min() + 1e-9
    assert outer >= radii.max() - 1e-9
    step = l_2 * math.radians(width / 4000)
    assert inner >= radii.min() - step - 1e-9
    assert outer <= radii.max() + step + 1e-9


@pytest.mark.parametrize(
    ("pose", "says"),
    [
        ((700.5, 0), "0.5 mm beyond the reach of 700 mm"),
        ((60, 0), "40 mm inside the hole of 100 mm"),
        ((0, float("nan")), "not a place"),
        ((-600, 1), "joint 1 would be 153.52 deg, 23.5 deg outside -130 to 130"),
        ((500, 0, 230, 0), "joint 3 would be 230 mm, 30 mm outside 0 to 200"),
    ],
)
def test_a_pose_that_cannot_be_had_says_by_how_much(pose, says):
    with pytest.raises(UsageError, match=says):
        FUM.inverse(pose, elbow=Elbow.RIGHT)


def test_the_excess_of_a_limit_is_the_angle_missing():
    pose = FUM.forward((150.0, 60.0))
    with pytest.raises(UsageError, match=r"joint 1 would be 150 deg, 20 deg outside -130 to 130"):
        FUM.inverse(pose, elbow=Elbow.RIGHT)


def test_an_error_names_few_of_many_poses():
    with pytest.raises(UsageError, match="and 97 more poses") as caught:
        FUM.inverse(np.full((100, 2), 900.0), elbow=Elbow.LEFT)
    assert len(str(caught.value)) < 400


def test_both_ends_of_the_reach_are_reached():
    free = Arm(400, 300)
    for q_2 in (0.0, 180.0):
        pose = free.forward((30.0, q_2))
        assert abs(free.inverse(pose, elbow=Elbow.RIGHT)[1]) == pytest.approx(q_2, abs=1e-4)


def test_an_angle_is_given_in_the_turn_its_limits_hold():
    arm = Arm(400, 300, joint_1_deg=(100, 350), joint_2_deg=(-225, -10))
    joints = np.array([[340.0, -30.0], [200.0, -200.0]])
    pose = arm.forward(joints)
    assert arm.inverse(pose[0], elbow=Elbow.LEFT) == pytest.approx(joints[0])
    assert arm.inverse(pose[1], elbow=Elbow.RIGHT) == pytest.approx(joints[1])


def test_joints_and_warm_links_move_the_tool_as_it_goes():
    joints, tiny = np.array([20.0, 70.0]), 1e-5
    moves = FUM.movements(joints)
    for k, step in enumerate(np.eye(2) * tiny):
        moved = FUM.forward(joints + step) - FUM.forward(joints - step)
        assert moves[:, k] == pytest.approx(moved / np.radians(2 * tiny), abs=1e-4)
    grown = Arm(400 * (1 + tiny), 300 * (1 + tiny)).forward(joints) - FUM.forward(joints)
    assert moves[:, 2] == pytest.approx(grown / tiny, abs=1e-4)


def test_singularities_are_straight_and_folded():
    q = [(0, v) for v in (0, 10, 90, 170, 180, -175, 190)]
    assert FUM.singularity_deg(q) == pytest.approx([0, 10, 90, 10, 0, 5, 10])


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"link_1_mm": 0}, "link_1_mm is 0"),
        ({"link_2_mm": float("nan")}, "link_2_mm is nan"),
        ({"joint_1_deg": (10, -10)}, "joint 1 goes from 10 to -10"),
        ({"quill_mm": (0, float("inf"))}, "joint 3 goes from 0 to inf"),
    ],
)
def test_an_arm_that_cannot_be_is_refused(change, says):
    with pytest.raises(UsageError, match=says):
        Arm(**{"link_1_mm": 400, "link_2_mm": 300, **change})
