"""The scatter of a test of several poses, from its run, its model and what was found at each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.joint_scatter.poses import (
    PLANE,
    Joints,
    ScatterAtPose,
    trace_poses,
    trace_to_joints,
)
from scara_iso.diagnosis.joint_scatter.reach import reach_map
from scara_iso.diagnosis.joint_scatter.tracing import FEWEST_POSES
from scara_iso.diagnosis.poses_result import JointScatter
from scara_iso.diagnosis.result import Diagnosis, FoundAtPoses
from scara_iso.robot import Arm, Model
from scara_iso.run import FloatArray, Run, step_of

Left = tuple[FloatArray, FloatArray]
"""X and Y (n, 2) at a pose that was held out: as read, and less the model with the effects."""


def joint_scatter(
    run: Run,
    model: Model,
    found: Mapping[str, Diagnosis],
    *,
    held_out: Mapping[str, Left],
    reach: bool = False,
    limit: float | None = None,
) -> JointScatter:
    """Return the scatter of a test traced to the joints, and RP where nobody measured.

    ``run`` holds all rows that count, ``found`` the diagnosis of each of its poses but those
    ``held_out``. ``reach`` adds the map, with the ``limit`` of RP in mm. Raises `UsageError` where
    the model gives no arm, the run not X and Y as lengths, or the model not where the joints are at
    two poses of ``found`` and at every one that is held out.
    """
    arm = _arm(run, model)
    at = {label: model.poses.get(_pose(run, label)) for label in (*found, *held_out)}
    unknown = [label for label, joints in at.items() if joints is None]
    known = {label: joints for label, joints in at.items() if joints is not None}
    measured = {
        label: _left(found[label], joints, len(found))
        for label, joints in known.items()
        if label in found
    }
    if len(measured) < FEWEST_POSES or not set(held_out) <= set(known):
        raise UsageError(
            f"the model does not say where the joints are at {', '.join(unknown)}",
            remedy="give [pose.P1] joint_deg and so on, as the table names its poses",
        )
    second = {
        label: ScatterAtPose(known[label], left, read) for label, (read, left) in held_out.items()
    }
    division = tuple(step_of(run.axes[axis]) for axis in PLANE)
    visited = {_pose(run, label) for label in at}
    elsewhere = {pose: joints for pose, joints in model.poses.items() if pose not in visited}
    traced = trace_to_joints(measured, arm, division, elsewhere=elsewhere, held_out=second)
    if unknown:
        said = f"the model does not say where {', '.join(unknown)} is: left out of the joints"
        traced = replace(traced, notes=(*traced.notes, said))
    if not reach:
        return traced
    places = {label: one.joints_deg for label, one in measured.items()}
    seen = reach_map(trace_poses(measured, arm, division), arm, places, limit=limit)
    return replace(traced, reach=seen)


def _arm(run: Run, model: Model) -> Arm:
    if model.arm is None:
        raise UsageError(
            "the model gives no links", remedy="state link_1_mm and link_2_mm in [robot]"
        )
    if not all(a in run.axes and run.axes[a].dimension is Dimension.LENGTH for a in PLANE):
        raise UsageError(
            f"{', '.join(run.axes)} do not tell the joints apart",
            remedy="measure X and Y, as lengths",
        )
    return model.arm


def _pose(run: Run, label: str) -> str:
    """Return the pose of a label, without the direction from which it is approached."""
    return run.arrival_at(label)[0] or label


def _left(found: Diagnosis, joints_deg: Joints, poses: int) -> ScatterAtPose:
    """Return what is left at one of the poses; they share the sizes of effects in the joints."""
    series = found.series
    read = np.stack([series.measured[a] for a in PLANE], axis=1)
    left = read - np.stack([series.predicted_after[a] for a in PLANE], axis=1)
    numbers = [
        1 / poses
        if isinstance(one, FoundAtPoses) and one.at_joint
        else float(len({*one.axes} & {*PLANE}))
        for one in found.effects
    ]
    return ScatterAtPose(joints_deg, left, read, sum(numbers) / len(PLANE))
