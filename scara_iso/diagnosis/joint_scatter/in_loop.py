"""A test's diagnosis with its scatter traced to the joints: what the command and library call."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.diagnosis.all_poses import whole_cycles
from scara_iso.diagnosis.closed_loop import CyclesWanted
from scara_iso.diagnosis.joint_scatter.from_run import Left, joint_scatter
from scara_iso.diagnosis.joint_scatter.poses import PLANE
from scara_iso.diagnosis.joint_scatter.recorded import (
    FOLLOWED,
    MeasuredPoses,
    followed_in_joints,
)
from scara_iso.diagnosis.poses_result import DiagnosisOfPoses, FollowedInJoints
from scara_iso.diagnosis.saving import declared_in_arm
from scara_iso.effects import Conditions
from scara_iso.robot import Model, predict
from scara_iso.run import Run, step_of


def with_joint_scatter(
    found: DiagnosisOfPoses,
    run: Run,
    model: Model,
    wanted: CyclesWanted,
    *,
    held_out: str | None = None,
    reach: bool = False,
    limit: float | None = None,
) -> DiagnosisOfPoses:
    """Return a test's diagnosis with its scatter traced to the joints, or a note why it is not.

    ``run`` holds all poses, ``held_out`` names one that ``found`` has not seen. Raises as
    `joint_scatter` where that pose, or the map (``reach``, with the ``limit`` of RP in mm), was
    asked for and cannot be given.
    """
    run = run.unwrapped()
    used = run.take(np.concatenate(wanted.used(run).rows))
    in_arm = [declared_in_arm(one) for one in found.effects]
    known = replace(model, effects=(*model.effects, *(one for one in in_arm if one is not None)))
    unseen = {
        str(label): _read_and_left(used.take(rows), known.at(used.arrival_at(label)[0]))
        for label, rows in used.rows_by_pose()
        if label == held_out
    }
    try:
        traced = joint_scatter(used, model, found.poses, held_out=unseen, reach=reach, limit=limit)
    except UsageError as error:
        if held_out is not None or reach:
            raise
        said = f"scatter is not traced to the joints: {error.what}; {error.remedy}"
        return replace(found, notes=(*found.notes, said))
    found = replace(found, joint_scatter=traced, notes=(*found.notes, *traced.notes))
    return replace(found, followed=_followed(found, used, model))


def _followed(found: DiagnosisOfPoses, used: Run, model: Model) -> tuple[FollowedInJoints, ...]:
    """Return what follows the recorded columns, beside the other effects that were found."""
    at = {label: model.poses.get(used.arrival_at(label)[0] or label) for label in found.poses}
    joints = [pair for pair in at.values() if pair is not None]
    if model.arm is None or len(joints) < len(at):
        return ()
    rows = {str(label): rows for label, rows in used.rows_by_pose() if str(label) in at}
    test = whole_cycles(used, rows).run
    readings = [
        [one.series.measured[axis] - one.series.predicted_before[axis] for axis in PLANE]
        for one in found.poses.values()
    ]
    division = np.array([step_of(used.axes[axis]) for axis in PLANE])
    measured = MeasuredPoses(np.moveaxis(np.array(readings), -1, 0), joints, division)
    beside = [
        course
        for one, course in zip(found.effects, found.courses, strict=True)
        if not {*FOLLOWED, "temperature_lagged"} & {one.effect}
    ]
    return followed_in_joints(measured, model.arm, Conditions(test.cycle, test.covariates), beside)


def _read_and_left(run: Run, model: Model) -> Left:
    """Return X and Y at a pose, as far as they are there, and what the model leaves of them."""
    axes = [axis for axis in PLANE if axis in run.axes] or list(run.axes)
    expected = predict(model, Conditions(run.cycle, run.covariates)).axes
    read = np.stack([run.axes[axis].readings for axis in axes], axis=1)
    still = np.zeros(len(run))
    moved = [expected[axis].readings if axis in expected else still for axis in axes]
    return read, read - np.stack(moved, axis=1)
