"""A test's diagnosis with its scatter traced to the joints: what the command and library call."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.all_poses import whole_cycles
from scara_iso.diagnosis.closed_loop import CyclesWanted
from scara_iso.diagnosis.joint_scatter.poses import (
    PLANE,
    Joints,
    ScatterAtPose,
    trace_poses,
    trace_to_joints,
)
from scara_iso.diagnosis.joint_scatter.recorded import (
    FOLLOWED,
    MeasuredPoses,
    followed_in_joints,
)
from scara_iso.diagnosis.joint_scatter.tracing import FEWEST_POSES, Traced, patterns_of, rp_at
from scara_iso.diagnosis.poses_result import (
    DiagnosisOfPoses,
    FollowedInJoints,
    JointScatter,
    ReachMap,
)
from scara_iso.diagnosis.result import Diagnosis, FoundAtPoses
from scara_iso.diagnosis.saving import declared_in_arm
from scara_iso.effects import Conditions
from scara_iso.robot import Arm, Elbow, Model, Workspace, predict
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
        note = f"the model does not say where {', '.join(unknown)} is: left out of the joints"
        traced = replace(traced, notes=(*traced.notes, note))
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
