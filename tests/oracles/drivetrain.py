"""A drive train through time: constant accelerations from one event to the next, many runs at once.

Between events the paper's eq. 7 and 8 have constant accelerations, so that the next event is the
root of a line or a parabola. Friction and a motor held to its command keep it so.

Many arrivals at one pose, and where in the gap the load comes to rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import UsageError
from scara_iso.robot import Approach, sides
from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class DriveTrain:
    """A motor, a gap and a load on one shaft; every term beyond the first three can be left out.

    Raises `UsageError`, naming every fault, for a number outside its range.
    """

    motor_inertia: float
    """I_m, at the motor shaft [kg m²]."""
    load_inertia: float
    """I_L, at the output [kg m²]."""
    gap: float
    """2Δ, the full gap at the output [rad]."""
    ratio: float = 1.0
    """N: the rotor counts N² times at the output. 1 is the paper's single shaft."""
    coulomb: float = 0.0
    """Coulomb friction on the load, at rest and in motion [N m]."""
    viscous: float = 0.0
    """Viscous friction on the load [N m s/rad]."""
    load_torque: float = 0.0
    """Constant torque on the load [N m]."""
    stiffness: float = math.inf
    """Torsional stiffness of gear and shaft in contact [N m/rad]; infinite: plastic impacts."""
    damping: float = 0.0
    """Torsional damping in contact [N m s/rad]; of use only with a finite stiffness."""

    def __post_init__(self) -> None:
        positive = {"motor_inertia", "load_inertia", "gap", "ratio"}
        faults = []
        for name, value in ((f.name, getattr(self, f.name)) for f in fields(self)):
            match name:
                case "load_torque":
                    good, rule = math.isfinite(value), "finite"
                case "stiffness":
                    good, rule = value > 0, "positive"
                case _ if name in positive:
                    good, rule = 0 < value < math.inf, "positive and finite"
                case _:
                    good, rule = 0 <= value < math.inf, "not negative, and finite"
            faults += [] if good else [f"{name} is {value:g}, must be {rule}"]
        if faults:
            raise UsageError(f"not a possible drive train: {'; '.join(faults)}")

    @property
    def reflected_inertia(self) -> float:
        """N² I_m: inertia of the rotor seen at the output [kg m²]."""
        return self.ratio**2 * self.motor_inertia

    @property
    def rigid(self) -> bool:
        """Whether contacts are rigid, so that impacts are plastic."""
        return math.isinf(self.stiffness)


_MOST_EVENTS = 100_000


class Moving(NamedTuple):
    """State of n runs: arrays of shape (n,); ``contact`` holds -1, 0 or +1."""

    load_angle: FloatArray
    load_velocity: FloatArray
    gap_angle: FloatArray
    motor_velocity: FloatArray
    contact: IntArray


class Phase(NamedTuple):
    """What n runs do until their next events, each of shape (n,)."""

    start: FloatArray
    """Time at which each run's phase begins [s]."""
    state: Moving
    load_acceleration: FloatArray
    motor_acceleration: FloatArray
    duration: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Constants:
    """What the equations need of n trains, each a number or of shape (n,)."""

    half_gap: float | FloatArray
    motor_share: float | FloatArray
    """Motor's share of the inertia in contact: 1 where the motor follows its command."""
    load_push: float | FloatArray
    """Acceleration that the load torque gives the free load [rad/s²]."""
    friction: float | FloatArray
    """Deceleration that Coulomb friction gives the free load [rad/s²]."""


def run_events(
    train: Constants, durations: FloatArray, accelerations: FloatArray, state: Moving
) -> Iterator[Phase]:
    """Yield the phases of n runs until all pieces are over, or nothing more can happen.

    ``durations`` and ``accelerations`` (of the free motor) have shape (pieces, n); the last
    duration may be infinite.
    """
    everyone = np.arange(len(state.load_angle))
    targets = _commanded(train, durations, accelerations, state)
    piece, over = np.zeros_like(everyone), np.zeros(len(everyone), dtype=bool)
    time, left = np.zeros(len(everyone)), durations[0].copy()
    for _ in range(_MOST_EVENTS):
        state, a_load, a_motor = _settle(train, state, accelerations[piece, everyone])
        to_flank = _time_to_flank(train, state, a_motor - a_load)
        to_stop = _time_to_stop(train, state, a_load)
        step = np.minimum(np.minimum(to_flank, to_stop), left)
        step[over | np.isinf(step)] = 0.0
        phase = Phase(time, state, a_load, a_motor, step)
        yield phase
        ended = ~over & (step == left)
        over = over | (np.isinf(left) & np.isinf(to_flank) & np.isinf(to_stop))
        state = _advance(train, phase, step == to_flank, step == to_stop)
        state = _arrive(state, ended, targets[piece, everyone])
        over = over | (ended & (piece == len(durations) - 1))
        if over.all():
            return
        time, left, piece = time + step, left - step, np.where(ended & ~over, piece + 1, piece)
        left = np.where(ended & ~over, durations[piece, everyone], left)
    raise UsageError(f"more than {_MOST_EVENTS} events: shorten the drive")


def _commanded(
    train: Constants, durations: FloatArray, accelerations: FloatArray, state: Moving
) -> FloatArray:
    """Return the motor's velocity at the end of each piece if it is held to a command, else nan.

    Rounding must not leave a standing motor creeping: it would cross the gap in the end.
    """
    held = np.broadcast_to(train.motor_share, state.motor_velocity.shape) == 1.0
    velocity, ends = state.motor_velocity, []
    for duration, acceleration in zip(durations, accelerations, strict=True):
        change = acceleration * np.where(np.isinf(duration) & (acceleration == 0), 0.0, duration)
        total = velocity + change
        velocity = np.where(np.abs(total) <= 1e-15 * np.abs(velocity), 0.0, total)
        ends.append(np.where(held, velocity, np.nan))
    return np.array(ends)


def _arrive(state: Moving, ended: npt.NDArray[np.bool_], target: FloatArray) -> Moving:
    """Return the state with a held motor, and what it pushes, exactly at its command's velocity."""
    exact = ended & ~np.isnan(target)
    return state._replace(
        motor_velocity=np.where(exact, target, state.motor_velocity),
        load_velocity=np.where(exact & (state.contact != 0), target, state.load_velocity),
    )


def _settle(
    train: Constants, state: Moving, motor: FloatArray
) -> tuple[Moving, FloatArray, FloatArray]:
    """Return the state after impacts and partings, and the accelerations of load and motor."""
    side, share = state.contact, train.motor_share
    hits = side * (state.motor_velocity - state.load_velocity) > 0
    # plastic impact: common velocity, momentum kept
    common = share * state.motor_velocity + (1.0 - share) * state.load_velocity
    velocity = np.where(hits, common, state.load_velocity)
    motor_velocity = np.where(hits, common, state.motor_velocity)
    alone = _slide(np.broadcast_to(train.load_push, motor.shape), train.friction, velocity)
    # contact can only push: it lasts while the bodies, left alone, would not move apart
    stays = (side != 0) & (motor_velocity == velocity) & (side * (motor - alone) >= 0)
    push = share * motor + (1.0 - share) * train.load_push
    together = _slide(push, (1.0 - share) * train.friction, velocity)
    settled = state._replace(
        load_velocity=velocity, motor_velocity=motor_velocity, contact=np.where(stays, side, 0)
    )
    return settled, np.where(stays, together, alone), np.where(stays, together, motor)


def _slide(push: FloatArray, friction: float | FloatArray, velocity: FloatArray) -> FloatArray:
    """Return the acceleration under Coulomb friction: sticking where at rest and pushed weakly."""
    held = np.sign(push) * np.maximum(np.abs(push) - friction, 0.0)
    return np.where(velocity == 0, held, push - np.sign(velocity) * friction)


def _time_to_flank(train: Constants, state: Moving, a_gap: FloatArray) -> FloatArray:
    times = [
        _first_arrival(
            np.maximum(train.half_gap - side * state.gap_angle, 0.0),
            side * (state.motor_velocity - state.load_velocity),
            side * a_gap,
        )
        for side in (1, -1)
    ]
    return np.where(state.contact == 0, np.minimum(*times), np.inf)


def _first_arrival(
    way: FloatArray, velocity: npt.NDArray[np.float64], acceleration: npt.NDArray[np.float64]
) -> FloatArray:
    """Return the least positive time at which v t + a t²/2 = way >= 0, or infinity."""
    square = velocity**2 + 2 * acceleration * way
    root = np.sqrt(np.maximum(square, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        forward = np.where(velocity + root > 0, 2 * way / (velocity + root), np.inf)
        back = np.where(acceleration > 0, (root - velocity) / acceleration, np.inf)
    time = np.where(square < 0, np.inf, np.where(velocity < 0, back, forward))
    # parted by less than rounding shows, and coming together again
    return np.where((way == 0) & (velocity == 0) & (acceleration > 0), 0.0, time)


def _time_to_stop(train: Constants, state: Moving, a_load: FloatArray) -> FloatArray:
    opposed = np.sign(state.load_velocity) * np.sign(a_load) < 0
    slows = opposed & (np.asarray(train.friction) > 0)
    with np.errstate(over="ignore"):
        return np.where(slows, -state.load_velocity / np.where(slows, a_load, 1.0), np.inf)


def _advance(
    train: Constants, phase: Phase, flank: npt.NDArray[np.bool_], stop: npt.NDArray[np.bool_]
) -> Moving:
    """Return the state at the end of a phase: exactly on the flank, or at rest, if that ends it."""
    state, step, a_load = phase.state, phase.duration, phase.load_acceleration
    a_gap = phase.motor_acceleration - a_load
    gap_velocity = state.motor_velocity - state.load_velocity
    gap_angle = state.gap_angle + (gap_velocity + a_gap * step / 2) * step
    side = np.where(gap_angle > 0, 1, -1)
    stands = stop & (state.contact != 0)
    return Moving(
        load_angle=state.load_angle + (state.load_velocity + a_load * step / 2) * step,
        load_velocity=np.where(stop, 0.0, state.load_velocity + a_load * step),
        gap_angle=np.where(flank, side * train.half_gap, gap_angle),
        motor_velocity=np.where(
            stands, 0.0, state.motor_velocity + phase.motor_acceleration * step
        ),
        contact=np.where(flank, side, state.contact),
    )


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


def _scattered(scatter: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Return factors about 1; a factor that chance makes tiny or negative is held at a tenth."""
    return np.maximum(1.0 + scatter * rng.standard_normal(count), 0.1)
