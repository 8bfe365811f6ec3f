"""The largest rectangle in the workspace against a grid filled by forward kinematics alone."""

import functools
import math

import numpy as np
import pytest
from budget import examples
from hypothesis import given, strategies as st

from scara_iso.base.errors import UsageError
from scara_iso.robot.arm import Arm, Elbow
from scara_iso.robot.workspace import Workspace, largest_rectangle

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
