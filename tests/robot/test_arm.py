"""SCARA geometry against homogeneous transforms, finite differences and round trips.

The largest rectangle in the workspace against a grid filled by forward kinematics alone.
"""

import functools
import math

import numpy as np
import pytest
from budget import examples
from hypothesis import given, strategies as st

from scara_iso.base.errors import UsageError
from scara_iso.robot.arm import Arm, Elbow, Workspace, largest_rectangle

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


ARMS = {
    "typical": Arm(400, 300, (-130, 130), (-145, 145)),
    "asymmetric": Arm(225, 375, (-60, 160), (-30, 150)),
    "big hole": Arm(500, 200, (-180, 180), (-120, 120)),
    "one elbow": Arm(400, 300, (-90, 90), (10, 150)),
    "whole disc": Arm(300, 300),
    "beyond a turn of joint 2": Arm(400, 300, (-130, 130), (-225, 225)),
    "backwards": Arm(300, 250, (0, 270), (-140, 20)),
}
SOME = ("typical", "whole disc")
ALL = [*SOME, *(pytest.param(n, marks=pytest.mark.slow) for n in ARMS if n not in SOME)]
STEP = 5.0


@functools.cache
def largest(name, square):
    return largest_rectangle(Workspace.of(ARMS[name]), square=square)


def reached_cells(arm, elbows):
    """Cells of STEP mm that forward kinematics hits: no inverse, no arcs."""
    fine = math.degrees(STEP / 3.5 / (arm.link_1_mm + arm.link_2_mm))
    q_1 = np.arange(*arm.joint_1_deg, fine)
    q_2 = np.arange(*arm.joint_2_deg, fine)
    sides = np.sign(np.sin(np.radians(q_2)))
    q_2 = q_2[np.isin(sides, [0, *(e.sign for e in elbows)])]
    a, b = np.radians(q_1)[:, None], np.radians(q_1[:, None] + q_2)
    x = arm.link_1_mm * np.cos(a) + arm.link_2_mm * np.cos(b)
    y = arm.link_1_mm * np.sin(a) + arm.link_2_mm * np.sin(b)
    n = math.ceil((arm.link_1_mm + arm.link_2_mm) / STEP) + 1
    hit = np.zeros((2 * n, 2 * n), dtype=bool)
    hit[np.floor(x / STEP).astype(int) + n, np.floor(y / STEP).astype(int) + n] = True
    return hit


def largest_square_of_cells(hit):
    """Side in cells: dynamic programming over rows."""
    above, best = np.zeros(hit.shape[1] + 1, dtype=int), 0
    for row in hit:
        here = np.zeros_like(above)
        for k in np.flatnonzero(row):
            here[k + 1] = 1 + min(above[k], above[k + 1], here[k])
        above, best = here, max(best, here.max())
    return best


def largest_rectangle_of_cells(hit):
    """Area in cells: the largest rectangle under a histogram, row by row."""
    height, best = np.zeros(hit.shape[1] + 1, dtype=int), 0
    for row in hit:
        height[:-1] = np.where(row, height[:-1] + 1, 0)
        stack = []
        for k, h in enumerate(height.tolist()):
            first = k
            while stack and stack[-1][1] >= h:
                first, tall = stack.pop()
                best = max(best, tall * (k - first))
            stack.append((first, h))
    return best


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_no_square_or_rectangle_of_a_grid_is_larger(name):
    no_grid_has_a_larger_one(name, tuple(Elbow))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "elbow"), [("typical", Elbow.RIGHT), ("backwards", Elbow.LEFT)])
def test_nor_is_one_of_a_grid_of_one_elbow(name, elbow):
    no_grid_has_a_larger_one(name, (elbow,))


def no_grid_has_a_larger_one(name, elbows):
    arm = ARMS[name]
    workspace, hit = Workspace.of(arm, elbows), reached_cells(arm, elbows)
    either = len(elbows) == 2
    square = largest(name, True) if either else largest_rectangle(workspace, square=True)
    assert square.width == square.depth
    cells = largest_square_of_cells(hit) * STEP
    # cells touched at the border stick out by less than a cell on each side
    assert cells - 2 * STEP <= square.width <= cells + 2 * STEP
    box = largest(name, False) if either else largest_rectangle(workspace, square=False)
    area = largest_rectangle_of_cells(hit) * STEP**2
    half_way_round = box.width + box.depth
    assert area - 2 * STEP * half_way_round <= box.width * box.depth
    assert box.width * box.depth <= area + 2 * STEP * half_way_round
    assert box.width * box.depth >= square.width**2 * (1 - 1e-6)


@pytest.mark.parametrize("name", ALL)
def test_every_point_of_the_rectangle_is_reached(name):
    workspace = Workspace.of(ARMS[name])
    for square in (True, False):
        r = largest(name, square)
        across = np.linspace(-0.5, 0.5, 201) * (1 - 1e-9)
        x, y = np.meshgrid(r.x + across * r.width, r.y + across * r.depth)
        assert workspace.contains(np.stack([x, y], axis=-1)).all()


def test_the_square_of_a_disc_and_of_a_ring_are_those_of_geometry():
    disc = largest_rectangle(Workspace.of(Arm(300, 300)), square=True)
    assert disc.width == pytest.approx(600 * math.sqrt(2), abs=1e-4)
    assert (disc.x, disc.y) == pytest.approx((0, 0), abs=1e-4)
    ring = largest_rectangle(Workspace.of(Arm(400, 300)), square=True)
    # from the hole's tangent x = 100 to the corners on the rim: (100 + s)^2 + (s/2)^2 = 700^2
    side = (-200 + math.sqrt(200**2 + 5 * (700**2 - 100**2))) / 2.5
    assert ring.width == pytest.approx(side, abs=1e-4)
    assert ring.x == pytest.approx(100 + side / 2, abs=1e-4)


@pytest.mark.slow
def test_the_box_of_a_ring_is_that_of_calculus():
    box = largest_rectangle(Workspace.of(Arm(400, 300)), square=False)
    widths = np.linspace(300, 550, 250_001)  # between the hole's tangent and the rim
    areas = widths * 2 * np.sqrt(700**2 - (100 + widths) ** 2)
    assert box.width * box.depth == pytest.approx(areas.max(), rel=1e-6)
    assert box.width == pytest.approx(widths[areas.argmax()], abs=0.3)


def test_equal_places_are_decided_for_the_foremost():
    square = largest("typical", True)
    assert square.x > 0
    assert abs(square.y) < 1e-3
    box = largest("typical", False)
    assert box.x > 300  # the same box stands at the sides, turned by a quarter


@given(
    st.floats(100, 500),
    st.floats(100, 500),
    st.floats(-170, 0),
    st.floats(5, 170),
    st.floats(-150, 0),
    st.floats(5, 150),
)
@examples(10)
def test_clearance_is_the_distance_to_the_nearest_place_out_of_reach(l_1, l_2, a, da, b, db):
    workspace = Workspace.of(Arm(l_1, l_2, (a, a + da), (b, b + db)))
    rng = np.random.default_rng(1)
    joints = rng.uniform((a, b), (a + da, b + db), (20, 2))
    centres = workspace.arm.forward(joints)
    size = workspace.clearance(centres, np.zeros(20))
    assert np.all(size >= 0)
    around = rng.uniform(-1, 1, (20, 400, 2)) * size[:, None, None] * (1 - 1e-6)
    assert workspace.contains(centres[:, None] + around).all()
    rim = 1.001 * size[:, None, None] + 1e-3
    edge = np.linspace(-1, 1, 4001)
    ring = np.concatenate([
        np.stack(pair, axis=-1)
        for pair in ((edge, 0 * edge + 1), (edge, 0 * edge - 1), (0 * edge + 1, edge),
                     (0 * edge - 1, edge))
    ])  # fmt: skip
    outside = ~workspace.contains(centres[:, None] + rim * ring)
    touched = outside.any(axis=1)
    # a boundary met edge-on by less than the ring resolves may be missed now and then
    assert touched.mean() > 0.8


def test_the_outline_lies_on_the_border():
    workspace = Workspace.of(ARMS["asymmetric"])
    for line in workspace.outline(points=20):
        for point in line[1:-1]:
            near = point + 0.01 * np.exp(1j * np.linspace(0, math.tau, 40)).view(float).reshape(
                -1, 2
            )
            inside = workspace.contains(near)
            assert inside.any()
            assert not inside.all()


@pytest.mark.parametrize(
    "arm",
    [Arm(400, 300, (10, 10), (-90, 90)), Arm(400, 300, (-90, 90), (45, 45))],
    ids=["joint 1 fixed", "joint 2 fixed"],
)
def test_limits_that_leave_no_area_are_refused(arm):
    with pytest.raises(UsageError, match="leave no area"):
        largest_rectangle(Workspace.of(arm), square=True)


def test_an_elbow_that_the_limits_exclude_is_refused():
    with pytest.raises(UsageError, match="never has its elbow on the right"):
        Workspace.of(Arm(400, 300, (-90, 90), (-120, -30)), (Elbow.RIGHT,))


@pytest.mark.slow
def test_a_rectangle_that_can_slide_is_found_and_fits():
    arm = Arm(453.8, 167.3, (-154.3, -100.7), (57.8, 303.0))
    workspace = Workspace.of(arm)
    box = largest_rectangle(workspace, square=False)
    assert box.width * box.depth == pytest.approx(52450, rel=1e-3)
    assert largest_rectangle(workspace, square=True).width ** 2 <= box.width * box.depth
