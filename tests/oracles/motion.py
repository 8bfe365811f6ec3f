"""One drive train through time, sampled, as `drivetrain` follows it from event to event."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Literal, TypeAlias, cast

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.run import FloatArray, IntArray

from .drivetrain import Constants, DriveTrain, Moving, Phase, run_events

Contact: TypeAlias = Literal[-1, 0, 1]
LEFT: Contact = -1
NO_CONTACT: Contact = 0
RIGHT: Contact = 1
"""The paper's three states (Fig. 4). In right contact the motor is ahead of the load by half the
gap (eq. 14) and pushes it in the positive direction."""


@dataclass(frozen=True, slots=True)
class Torque:
    """A motor driven by a torque that is constant over each of some pieces of time."""

    durations: tuple[float, ...]
    """How long each piece lasts [s]."""
    torques: tuple[float, ...]
    """T_m of each piece, at the motor shaft [N m]."""


@dataclass(frozen=True, slots=True)
class Held:
    """A motor that follows its command whatever the load does: a servo without limit."""

    durations: tuple[float, ...]
    """How long each piece lasts [s]."""
    accelerations: tuple[float, ...]
    """Commanded acceleration in each piece, at the output [rad/s²]."""


@dataclass(frozen=True, slots=True)
class Servo:
    """A motor held to its command by a proportional-derivative servo, all at the output.

    The command starts at ``angle`` and ``velocity``.
    """

    durations: tuple[float, ...]
    accelerations: tuple[float, ...]
    """Commanded acceleration in each piece [rad/s²]."""
    proportional: float
    """Torque for each radian of error [N m/rad]."""
    derivative: float
    """Torque for each rad/s of error [N m s/rad]."""
    limit: float = math.inf
    """Largest torque the servo gives [N m]."""
    angle: float = 0.0
    velocity: float = 0.0


Drive: TypeAlias = Torque | Held | Servo


@dataclass(frozen=True, slots=True)
class State:
    """Where load and gap are: angles in rad, velocities in rad/s.

    ``gap_angle`` is motor minus load, from -Δ (left contact) to +Δ (right contact).
    """

    load_angle: float = 0.0
    load_velocity: float = 0.0
    gap_angle: float = 0.0
    gap_velocity: float = 0.0

    @classmethod
    def touching(cls, train: DriveTrain, side: Contact, *, velocity: float = 0.0) -> State:
        """Return load at angle 0 and motor in contact on ``side``, both moving at ``velocity``."""
        return cls(0.0, velocity, side * train.gap / 2)

    def contact(self, train: DriveTrain) -> Contact:
        """Return the flank that touches, for a gap angle at an end of the gap or past it."""
        half = train.gap / 2
        touches = abs(self.gap_angle) >= half * (1 - 1e-12)
        return cast(Contact, int(math.copysign(1, self.gap_angle))) if touches else NO_CONTACT


@dataclass(frozen=True, eq=False, slots=True)
class Trajectory:
    """What happened, sampled: arrays of shape (k,), read-only.

    Each phase between two events gives the same number of points, its first and last instant among
    them: an event is there twice, before and after. SI units.
    """

    time: FloatArray
    contact: IntArray
    """-1 left contact, 0 no contact, +1 right contact."""
    load_angle: FloatArray
    load_velocity: FloatArray
    gap_angle: FloatArray
    gap_velocity: FloatArray

    def __post_init__(self) -> None:
        for field in fields(self):
            getattr(self, field.name).flags.writeable = False

    @property
    def motor_angle(self) -> FloatArray:
        """Motor angle at the output [rad]."""
        return self.load_angle + self.gap_angle

    @property
    def motor_velocity(self) -> FloatArray:
        """Motor velocity at the output [rad/s]."""
        return self.load_velocity + self.gap_velocity

    @classmethod
    def joined(cls, phases: Iterable[tuple[FloatArray, int, FloatArray]]) -> Trajectory:
        """Join phases of (time (k,), contact, states (4, k) in the order of `State`)."""
        times, contacts, states = zip(*phases, strict=True)
        sides = [np.full(len(t), c, dtype=np.int64) for t, c in zip(times, contacts, strict=True)]
        return cls(np.concatenate(times), np.concatenate(sides), *np.concatenate(states, axis=1))


def check_drive(drive: Drive) -> None:
    """Raise `UsageError` unless the drive's pieces are as many as their durations, and finite."""
    values = drive.torques if isinstance(drive, Torque) else drive.accelerations
    good = len(values) == len(drive.durations) > 0 and all(map(math.isfinite, values))
    if not good or not all(0 < d < math.inf for d in drive.durations):
        raise UsageError(
            "a drive needs one finite value and one positive duration for each of its pieces",
            where=type(drive).__name__,
        )


def solve(train: DriveTrain, drive: Drive, start: State, *, points: int = 2) -> Trajectory:
    """Return what a rigid train does under ``drive``, exact to rounding.

    ``points`` is the number of samples in each phase between two events (Trajectory). Source: eq.
    7-9 with plastic impacts; Coulomb friction and load torque are added to the load's equation.
    Raises `UsageError` for viscous friction, compliance or a servo of finite gain, which have no
    closed form here, and for a state outside the gap.
    """
    check_drive(drive)
    if isinstance(drive, Servo) or train.viscous or not train.rigid:
        raise UsageError(
            "no closed form for viscous friction, a compliant gear or a servo of finite gain",
            remedy="use integrate, or leave them out",
        )
    if abs(start.gap_angle) > train.gap / 2 * (1 + 1e-12):
        raise UsageError(f"start lies outside the gap: {start.gap_angle:g} rad")
    accelerations = np.array(motor_accelerations(train, drive))[:, None]
    state = Moving(
        load_angle=np.array([start.load_angle]),
        load_velocity=np.array([start.load_velocity]),
        gap_angle=np.array([start.gap_angle]),
        motor_velocity=np.array([start.load_velocity + start.gap_velocity]),
        contact=np.array([start.contact(train)]),
    )
    durations = np.array(drive.durations)[:, None]
    phases = run_events(constants(train, drive), durations, accelerations, state)
    return Trajectory.joined(_sample(phase, points) for phase in phases if phase.duration[0] > 0)


def constants(train: DriveTrain, drive: Drive) -> Constants:
    """Return the numbers that the equations of motion of ``train`` need."""
    total = train.reflected_inertia + train.load_inertia
    return Constants(
        half_gap=train.gap / 2,
        motor_share=1.0 if isinstance(drive, Held) else train.reflected_inertia / total,
        load_push=train.load_torque / train.load_inertia,
        friction=train.coulomb / train.load_inertia,
    )


def motor_accelerations(train: DriveTrain, drive: Torque | Held) -> tuple[float, ...]:
    """Return the free motor's acceleration in each piece, at the output [rad/s²].

    A torque T_m at the motor shaft is N T_m at the output, where the rotor is N² I_m.
    """
    match drive:
        case Held():
            return drive.accelerations
        case Torque():
            return tuple(t * train.ratio / train.reflected_inertia for t in drive.torques)


def _sample(phase: Phase, points: int) -> tuple[FloatArray, int, FloatArray]:
    t = np.linspace(0.0, phase.duration[0], points)
    angle, velocity, gap, motor, contact = (values[0] for values in phase.state)
    a_load = phase.load_acceleration[0]
    a_gap, gap_velocity = phase.motor_acceleration[0] - a_load, motor - velocity
    states = np.array([
        angle + (velocity + a_load * t / 2) * t,
        velocity + a_load * t,
        gap + (gap_velocity + a_gap * t / 2) * t,
        gap_velocity + a_gap * t,
    ])  # fmt: skip
    return phase.start[0] + t, int(contact), states
