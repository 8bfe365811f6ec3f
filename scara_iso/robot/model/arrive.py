"""Rest positions from the drive train through time, as displacements of the dials."""

from __future__ import annotations

import math

import numpy as np

from scara_iso.errors import UsageError
from scara_iso.robot.drivetrain import Approach, DriveTrain, Move, arrivals, sides
from scara_iso.robot.model.parts import Model
from scara_iso.run import FloatArray

# The paper states no move and no friction. These are assumed: a brisk move, arrivals that differ
# by a few per cent, and friction that lets the load stop inside the gap.
_MOVE = Move(speed=1.0, deceleration=10.0, speed_scatter=0.02, friction_scatter=0.1)


def rest_positions(
    model: Model, approach: Approach, *, count: int, rng: np.random.Generator
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return the approach (+1/-1) of each arrival and what X and Y read of it, in mm, shape (n,).

    Each gearbox is followed by itself (`drivetrain.arrivals`) and moves the tool along its joint's
    column of the Jacobian; all joints turn in the direction of the approach. Raises `UsageError`
    where the model holds no arm, pose or gearbox, and for a gearbox with a stiffness.
    """
    if model.arm is None or model.joints_deg is None or not model.gearboxes:
        raise UsageError(
            "the drive train needs the arm, the pose and a gearbox",
            remedy="give [robot], [pose] and [gearbox.joint_1] in the model",
        )
    jacobian = model.arm.jacobian(model.joints_deg)
    moved = np.zeros((2, count))
    approaches = sides(approach, count, rng)
    for joint, gear in model.gearboxes.items():
        train = DriveTrain(
            motor_inertia=gear.Im,
            load_inertia=gear.IL,
            gap=math.radians(gear.arcmin / 60),
            ratio=gear.ratio or 1.0,
            coulomb=gear.friction or 0.0,
            stiffness=gear.stiffness or math.inf,
        )
        found = arrivals(train, _MOVE, approaches, count=count, rng=rng)
        moved += jacobian[:, joint - 1, np.newaxis] * found.load_angle
    return approaches.astype(np.float64), {"X": moved[0], "Y": moved[1]}
