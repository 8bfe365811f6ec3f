"""What a drive train is, how it is driven, where it starts and where it went."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Literal, TypeAlias, cast

import numpy as np

from scara_iso.errors import UsageError
from scara_iso.run import FloatArray, IntArray

Contact: TypeAlias = Literal[-1, 0, 1]
LEFT: Contact = -1
NO_CONTACT: Contact = 0
RIGHT: Contact = 1
"""The paper's three states (Fig. 4). In right contact the motor is ahead of the load by half the
gap (eq. 14) and pushes it in the positive direction."""


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
            raise UsageError(f"no such drive train: {'; '.join(faults)}")

    @property
    def reflected_inertia(self) -> float:
        """N² I_m: inertia of the rotor seen at the output [kg m²]."""
        return self.ratio**2 * self.motor_inertia

    @property
    def rigid(self) -> bool:
        """Whether contacts are rigid, so that impacts are plastic."""
        return math.isinf(self.stiffness)


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
