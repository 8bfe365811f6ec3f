"""The test of ISO 9283 and of the paper's section II: cube, diagonal plane, poses P1 to P5.

What follows from the geometry of the arm is computed and checked; velocity, load, dwell and the
order of visits are the conditions of the test, carried along so that one table holds all that a
robot program needs. Sources: Mousavi et al., section II, eq. 1, Fig. 1 and 2; ISO 9283, 6.8, as
known in the trade.
"""

from __future__ import annotations

import math

import numpy as np

from scara_iso.errors import UsageError
from scara_iso.iso9283.by_name import Poses
from scara_iso.iso9283.pose_plan import (
    POSES,
    UNRATED,
    DiagonalPlane,
    PlannedPose,
    PosePlan,
    PoseTestConditions,
    Solid,
)
from scara_iso.robot import SMALLEST_MM, Arm, Elbow, Rated, Rectangle, Workspace, largest_rectangle
from scara_iso.run import FloatArray

_TOLERANCE = (0.08, 0.12)
"""m = (0.1 ± 0.02) L, eq. 1; ISO 9283 asks the same of the ends of the plane's diagonals."""


def make_plan(
    arm: Arm,
    *,
    solid: Solid = Solid.CUBE,
    plane: DiagonalPlane = DiagonalPlane.C1_C2_C7_C8,
    elbow: Elbow | None = None,
    m_over_diagonal: float = 0.1,
    theta_deg: float = 0.0,
    conditions: PoseTestConditions | None = None,
    rated: Rated = UNRATED,
) -> PosePlan:
    """Return the test for ``arm``, every pose within reach and limits.

    With ``elbow`` the cube lies in what that elbow reaches; without, in what either reaches, and
    the elbow that keeps all poses furthest from singularities is taken. Raises `UsageError` for an
    m outside eq. 1, an arm without stroke or area, and poses that one elbow does not reach.
    """
    _check(arm, m_over_diagonal)
    workspace = Workspace.of(arm, tuple(Elbow) if elbow is None else (elbow,))
    area = largest_rectangle(workspace, square=solid is Solid.CUBE)
    corners = _corners(area, arm, solid)
    places, diagonal = _places(corners[[c - 1 for c in plane.corners]], m_over_diagonal)
    poses = np.column_stack([places, np.full(len(places), theta_deg)])
    side, joints = _reached(arm, poses, tuple(Elbow) if elbow is None else (elbow,))
    return PosePlan(
        solid=solid,
        corners=corners,
        plane=plane,
        elbow=side,
        poses=Poses(planned_poses(arm, poses, joints)),
        diagonal_mm=diagonal,
        m_mm=m_over_diagonal * diagonal,
        stroke_limits=solid is Solid.CUBE and area.width > arm.stroke_mm,
        conditions=PoseTestConditions() if conditions is None else conditions,
        arm=arm,
        rated=rated,
    )


def _check(arm: Arm, m_over_diagonal: float) -> None:
    low, high = _TOLERANCE
    if not low - 1e-12 <= m_over_diagonal <= high + 1e-12:
        raise UsageError(
            f"m = {m_over_diagonal:g} L is outside (0.1 ± 0.02) L",
            remedy=f"choose it from {low:g} to {high:g}",
        )
    if arm.stroke_mm < SMALLEST_MM:
        raise UsageError(
            f"a stroke of {arm.stroke_mm:g} mm leaves no room for a cube",
            remedy="give the model's quill its lowest and highest z: [robot] quill_mm = [0, 200]",
        )


def _corners(area: Rectangle, arm: Arm, solid: Solid) -> FloatArray:
    """Return C1 to C8 of the solid over ``area``, in the middle of the stroke, shape (8, 3).

    The centre is rounded to whole micrometres, as a controller takes them, and the edges give way.
    """
    x, y = (math.floor(side * 1000 - 1) / 1000 for side in (area.width, area.depth))
    z = arm.stroke_mm
    if solid is Solid.CUBE:
        x = y = z = min(x, y, z)
    middle = np.array([round(area.x, 3), round(area.y, 3), sum(arm.quill_mm) / 2]) + 0.0
    around = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    signs = [(*xy, up) for up in (-1, 1) for xy in around]
    return np.asarray(middle + np.array(signs) * (x, y, z) / 2)


def _places(corners: FloatArray, m_over_diagonal: float) -> tuple[FloatArray, float]:
    """Return P1 to P5, shape (5, 3), in the plane of four corners, and the plane's diagonal."""
    centre = corners.mean(axis=0)
    diagonal = float(np.linalg.norm(corners[2] - corners[0]))
    inner = corners + 2 * m_over_diagonal * (centre - corners)
    return np.round(np.vstack([centre, inner]), 3), diagonal


def _reached(arm: Arm, poses: FloatArray, elbows: tuple[Elbow, ...]) -> tuple[Elbow, FloatArray]:
    """Return the elbow that reaches all poses furthest from singularities, and the joints."""
    found: list[tuple[float, Elbow, FloatArray]] = []
    faults = []
    for elbow in elbows:
        try:
            joints = arm.inverse(poses, elbow=elbow)
            found.append((float(arm.singularity_deg(joints).min()), elbow, joints))
        except UsageError as error:
            faults.append(str(error))
    if not found:
        raise UsageError(
            f"no elbow reaches all poses: {'; '.join(faults)}",
            remedy="name an elbow: the cube is then laid into what that elbow reaches",
        )
    # rounding must not choose between mirrored elbows
    _, elbow, joints = max(found, key=lambda f: round(f[0], 6))
    return elbow, joints


def planned_poses(arm: Arm, poses: FloatArray, joints: FloatArray) -> tuple[PlannedPose, ...]:
    """Return P1 and so on at ``poses`` (n, 4), reached by ``joints`` (n, 4), in mm and degrees."""
    apart, turn = arm.singularity_deg(joints), np.abs(np.sin(np.radians(joints[:, 1])))
    table = np.column_stack([poses, joints, apart, turn]).tolist()
    return tuple(PlannedPose(name, *row) for name, row in zip(POSES, table, strict=True))
