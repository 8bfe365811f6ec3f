"""A plan of the poses and a model file to a `WholeTest`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from scara_iso.acceptance.whole_test import CommandPose, Cube, RobotTested, Schedule, WholeTest
from scara_iso.iso9283 import PosePlan
from scara_iso.robot import Model

CHARACTERISTICS = ("RP", "AP")
"""What thirty cycles at five poses give."""


def plan_test(
    plan: PosePlan,
    model: Model,
    *,
    model_path: Path,
    folder: Path,
    velocities: Sequence[float],
    loads: Sequence[float],
) -> WholeTest:
    """Return the test of a plan; the model file is named as seen from ``folder``.

    Poses in the order P1 to P5. What the model does not rate is left open.
    """
    return WholeTest(
        robot=RobotTested(
            model.robot,
            model.serial_number,
            _relative(model_path, folder),
            model.rated.load_kg,
            model.rated.velocity_mm_s,
        ),
        schedule=Schedule(
            CHARACTERISTICS,
            tuple(velocities),
            tuple(loads),
            plan.conditions.cycles,
            dwell_s=plan.conditions.dwell_s,
        ),
        cube=Cube(plan.solid.value, plan.size_mm, plan.plane.value, plan.elbow.value),
        poses={
            pose.name: CommandPose(pose.x_mm, pose.y_mm, pose.z_mm, pose.theta_deg)
            for pose in plan.poses
        },
    )


def _relative(path: Path, folder: Path) -> str:
    """Return the path from the folder, with slashes; whole where no relative one leads there."""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive of Windows
        return path.resolve().as_posix()
