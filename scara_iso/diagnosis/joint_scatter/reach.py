"""Predicted RP over the whole reach: where the robot repeats best, and where worst."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scara_iso.diagnosis.joint_scatter.tracing import Traced, patterns_of, rp_at
from scara_iso.diagnosis.poses_result import ReachMap
from scara_iso.robot import Arm, Elbow, Workspace

CELLS = 81


def reach_map(
    traced: Traced,
    arm: Arm,
    poses: Mapping[str, tuple[float, float]],
    cells: int = CELLS,
    limit: float | None = None,
) -> ReachMap:
    """Return RP over the workspace, ``cells`` along its longer side, and where ``poses`` are.

    ``limit`` is the RP that is wanted, in mm.

    Where both elbows reach a place, the right one is taken: the left one's scatter is its mirror
    image, of the same RP.
    """
    low, high = Workspace.of(arm).extent()
    step = float((high - low).max()) / cells
    x, y = (np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True))
    places = np.stack(np.meshgrid(x, y), axis=-1)
    joints = np.full(places.shape, np.nan)
    for elbow in (Elbow.LEFT, Elbow.RIGHT):
        solved = arm.solve(places, elbow)
        reached = np.all(arm.excess(solved) == 0, axis=-1)
        joints[reached] = solved[reached]
    inside = ~np.isnan(joints[..., 0])
    found = rp_at(traced, patterns_of(arm, joints[inside]), traced.given.known[0])
    maps = np.full((3, *inside.shape), np.nan)
    maps[:, inside] = found
    marked = {pose: tuple(arm.forward(joints).tolist()) for pose, joints in poses.items()}
    return ReachMap(x, y, maps[0], maps[1], maps[2], marked, limit)
