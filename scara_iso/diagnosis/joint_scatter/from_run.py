"""The scatter of a test of several poses, from its run, its model and what was found at each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from scara_iso.diagnosis.joint_scatter.poses import (
    Joints,
    ScatterAtPose,
    trace_poses,
    trace_to_joints,
)
from scara_iso.diagnosis.joint_scatter.reach import reach_map
from scara_iso.diagnosis.joint_scatter.result import JointScatter
from scara_iso.diagnosis.joint_scatter.tracing import FEWEST_POSES
from scara_iso.diagnosis.result import Diagnosis
from scara_iso.dial import step_of
from scara_iso.errors import UsageError
from scara_iso.quantities import Dimension
from scara_iso.robot import Arm, Model
from scara_iso.run import Run

_PLANE = ("X", "Y")


def joint_scatter(
    run: Run,
    model: Model,
    found: Mapping[str, Diagnosis],
    *,
    held_out: Mapping[str, Run],
    reach: bool = False,
) -> JointScatter:
    """Return the scatter of a test traced to the joints, and RP where nobody measured.

    ``run`` holds all rows that count, ``found`` the diagnosis of each of its poses but those
    ``held_out``, whose own rows these are. ``reach`` adds the map. Raises `UsageError` where the
    model gives no arm, the run not X and Y as lengths, or the model not where the joints are at two
    poses of ``found`` and at every one that is held out.
    """
    arm = _arm(run, model)
    at = {label: _joints(run, model, label) for label in (*found, *held_out)}
    unknown = [label for label, joints in at.items() if joints is None]
    measured = {
        label: _left(found[label], joints)
        for label, joints in at.items() if joints is not None and label in found
    }  # fmt: skip
    if len(measured) < FEWEST_POSES or any(label in unknown for label in held_out):
        raise UsageError(
            f"the model does not say where the joints are at {', '.join(unknown)}"
            if unknown else f"{len(measured)} pose is left, and joints need {FEWEST_POSES}",
            remedy="give [pose.P1] joint_deg and so on, as the table names its poses",
        )  # fmt: skip
    second = {
        label: ScatterAtPose(joints, np.stack([one.axes[a].readings for a in _PLANE], axis=1))
        for label, one in held_out.items() if (joints := at[label]) is not None
    }  # fmt: skip
    division = tuple(step_of(run.axes[axis]) for axis in _PLANE)
    visited = {_pose(run, label) for label in at}
    elsewhere = {pose: joints for pose, joints in model.poses.items() if pose not in visited}
    traced = trace_to_joints(measured, arm, division, elsewhere=elsewhere, held_out=second)
    if unknown:
        said = f"the model does not say where {', '.join(unknown)} is: left out of the joints"
        traced = replace(traced, notes=(*traced.notes, said))
    if reach:
        fitted = trace_poses(measured, arm, division)
        places = {label: one.joints_deg for label, one in measured.items()}
        traced = replace(traced, reach=reach_map(fitted, arm, places))
    return traced


def _arm(run: Run, model: Model) -> Arm:
    if model.arm is None:
        raise UsageError(
            "the model gives no links", remedy="state link_1_mm and link_2_mm in [robot]"
        )
    if not all(a in run.axes and run.axes[a].dimension is Dimension.LENGTH for a in _PLANE):
        raise UsageError(
            f"{', '.join(run.axes)} do not tell the joints apart",
            remedy="measure X and Y, as lengths",
        )
    return model.arm


def _pose(run: Run, label: str) -> str | None:
    """Return the pose of a label, without the direction from which it is approached."""
    return run.arrival_at(label)[0]


def _joints(run: Run, model: Model, label: str) -> Joints | None:
    return model.poses.get(_pose(run, label) or label)


def _left(found: Diagnosis, joints_deg: Joints) -> ScatterAtPose:
    series = found.series
    left = np.stack([series.measured[a] - series.predicted_after[a] for a in _PLANE], axis=1)
    moved = [axis for one in found.effects for axis in one.axes if axis in _PLANE]
    return ScatterAtPose(joints_deg, left, len(moved) / len(_PLANE))
