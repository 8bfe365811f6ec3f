"""Many arrivals at one pose, and where in the gap the load comes to rest."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import Enum

import numpy as np

from scara_iso.errors import UsageError
from scara_iso.robot.drivetrain.solution import Constants, Moving, run_events
from scara_iso.robot.drivetrain.train import DriveTrain
from scara_iso.run import FloatArray, IntArray


class Approach(Enum):
    """From which side the pose is approached."""

    ONE_SIDE = "one side"
    """Always in the positive direction."""
    BOTH_SIDES = "both sides"
    """In the positive and the negative direction alternately."""
    RANDOM = "random"
    """In either direction with the same probability."""


@dataclass(frozen=True, slots=True)
class Move:
    """The end of a move: constant speed, constant deceleration, motor held at the pose."""

    speed: float
    """Joint speed before braking [rad/s]."""
    deceleration: float
    """Joint deceleration [rad/s²]."""
    speed_scatter: float = 0.0
    """Standard deviation of the speed between arrivals, as a part of the speed."""
    friction_scatter: float = 0.0
    """Standard deviation of the Coulomb friction between arrivals, as a part of it."""


@dataclass(frozen=True, eq=False, slots=True)
class Arrivals:
    """Where the load rested, in rad from the place where it would rest without a gap.

    Arrays of shape (n,), read-only, in the order of the arrivals.
    """

    approach: IntArray
    """Direction of each approach, +1 or -1."""
    load_angle: FloatArray
    """Rest position of the load, within ±Δ."""
    contact: IntArray
    """Flank on which it rests: -1 left, +1 right, 0 inside the gap."""

    def __post_init__(self) -> None:
        for field in fields(self):
            getattr(self, field.name).flags.writeable = False


def arrivals(
    train: DriveTrain,
    move: Move,
    approach: Approach | IntArray,
    *,
    count: int,
    rng: np.random.Generator,
) -> Arrivals:
    """Return where the load rests after each of ``count`` arrivals of a motor that obeys its servo.

    ``approach`` says from which side, or gives the direction of each arrival, +1 or -1.
    The motor drives the load at speed, brakes and stands; the load goes on through the gap as
    friction, load torque and the flanks let it, until it rests. The motor follows its command
    whatever the load does (`Held`), so that its own inertia plays no part. Raises `UsageError` for
    viscous friction or a compliant gear, and for a move without speed.
    """
    _check(train, move, count)
    side = sides(approach, count, rng) if isinstance(approach, Approach) else approach.copy()
    speed = move.speed * _scattered(move.speed_scatter, count, rng)
    friction = train.coulomb * _scattered(move.friction_scatter, count, rng)
    trains = Constants(
        half_gap=train.gap / 2,
        motor_share=1.0,
        load_push=train.load_torque / train.load_inertia,
        friction=friction / train.load_inertia,
    )
    braking = speed / move.deceleration
    # the motor stops at angle 0; the load begins on the flank that drives it
    start = Moving(
        load_angle=-side * (speed * braking + train.gap) / 2,
        load_velocity=side * speed,
        gap_angle=side * train.gap / 2,
        motor_velocity=side * speed,
        contact=side,
    )
    durations = np.stack([braking, np.full(count, np.inf)])
    accelerations = np.stack([-side * move.deceleration, np.zeros(count)])
    *_, last = run_events(trains, durations, accelerations, start)
    rest = last.state
    return Arrivals(side, -rest.gap_angle, rest.contact)


def _check(train: DriveTrain, move: Move, count: int) -> None:
    if train.viscous or not train.rigid:
        raise UsageError(
            "arrivals are followed in closed form, without viscous friction or compliance",
            remedy="leave them out",
        )
    numbers = (move.speed, move.deceleration)
    if count < 1 or not all(0 < v < np.inf for v in numbers):
        raise UsageError("a move needs a positive speed and deceleration, and at least one arrival")
    if not all(0 <= v < 0.3 for v in (move.speed_scatter, move.friction_scatter)):
        raise UsageError("scatter is a fraction of the value: from 0 to less than 0.3")


def sides(approach: Approach, count: int, rng: np.random.Generator) -> IntArray:
    """Return the direction of each approach, +1 or -1, shape (count,)."""
    match approach:
        case Approach.ONE_SIDE:
            return np.ones(count, dtype=np.int64)
        case Approach.BOTH_SIDES:
            return 1 - 2 * (np.arange(count, dtype=np.int64) % 2)
        case Approach.RANDOM:
            return 1 - 2 * rng.integers(2, size=count)


def _scattered(scatter: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Return factors about 1; a factor that chance makes tiny or negative is held at a tenth."""
    return np.maximum(1.0 + scatter * rng.standard_normal(count), 0.1)
