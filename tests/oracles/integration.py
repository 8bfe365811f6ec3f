"""Numerical integration between located events: viscous friction, compliance, a finite servo.

Written apart from the closed form, so that each can be held against the other where both apply.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.run import FloatArray

from .drivetrain import DriveTrain
from .motion import Drive, Held, Servo, State, Torque, Trajectory, check_drive

_MOST_EVENTS = 10_000
_STICTION = 1e-6
"""By how much of itself friction at rest is larger, so that a creeping servo lets the load rest."""

_Function: TypeAlias = Callable[[float, FloatArray], float]


@dataclass(frozen=True, slots=True)
class _Mode:
    """What acts until the next event."""

    contact: int
    slip: int
    """Sign of the load's velocity that friction opposes; 0 without friction and where it sticks."""
    stuck: bool
    """Whether friction holds the load at rest."""


@dataclass(frozen=True, slots=True)
class _Equations:
    """Equations of motion in one piece of the drive.

    y holds load angle, load velocity, gap angle and gap velocity.
    """

    train: DriveTrain
    motor: _Function
    """Acceleration of the motor left alone [rad/s²]."""
    share: float
    """Motor's share of the inertia in contact: 1 where the motor follows its command."""
    motor_mobility: float
    """1 / reflected inertia; 0 where the motor follows its command."""

    def gear_torque(self, contact: int, y: FloatArray) -> float:
        """Torque of the compliant gear, positive where it keeps the flanks together [N m]."""
        t = self.train
        return t.stiffness * (contact * float(y[2]) - t.gap / 2) + t.damping * contact * float(y[3])

    def load_alone(self, y: FloatArray, torque: float = 0.0) -> float:
        """Acceleration of the load without Coulomb friction, under ``torque`` of the gear."""
        t = self.train
        return (t.load_torque + torque - t.viscous * float(y[1])) / t.load_inertia

    def pushed(self, mode: _Mode, time: float, y: FloatArray) -> tuple[float, float]:
        """Acceleration of what moves with the load, without Coulomb friction, and that friction."""
        friction = self.train.coulomb / self.train.load_inertia
        if not mode.contact:
            return self.load_alone(y), friction
        if not self.train.rigid:
            return self.load_alone(y, mode.contact * self.gear_torque(mode.contact, y)), friction
        alone = self.share * self.motor(time, y) + (1 - self.share) * self.load_alone(y)
        return alone, (1 - self.share) * friction

    def __call__(self, mode: _Mode, time: float, y: FloatArray) -> list[float]:
        """Return dy/dt."""
        push, friction = self.pushed(mode, time, y)
        load = 0.0 if mode.stuck else push - mode.slip * friction
        if mode.contact and self.train.rigid:
            return [float(y[1]), load, 0.0, 0.0]
        gear = mode.contact * self.gear_torque(mode.contact, y) if mode.contact else 0.0
        motor = self.motor(time, y) - gear * self.motor_mobility
        return [float(y[1]), load, float(y[3]), motor - load]


def integrate(
    train: DriveTrain, drive: Drive, start: State, *, points: int = 2, tolerance: float = 1e-10
) -> Trajectory:
    """Return what a train does under ``drive``, every term of it and any servo included.

    ``tolerance`` is the relative error of one step (scipy, DOP853). Contacts are plastic where the
    train is rigid; where it is compliant the gear pushes with stiffness and damping and never
    pulls. Phases and ``points`` as in `Trajectory`. Raises `UsageError` where the contacts chatter
    without end.
    """
    check_drive(drive)
    # friction that moves nothing by a part in 10^10 of the gap is none: it would stop and start for
    # ever what only rounding moves
    if train.coulomb * sum(drive.durations) ** 2 < 1e-10 * train.gap * train.load_inertia:
        train = replace(train, coulomb=0.0)
    y = np.array([start.load_angle, start.load_velocity, start.gap_angle, start.gap_velocity])
    return Trajectory.joined(_run(train, drive, start.contact(train), y, points, tolerance))


def _run(
    train: DriveTrain, drive: Drive, contact: int, y: FloatArray, points: int, tolerance: float
) -> Iterator[tuple[FloatArray, int, FloatArray]]:
    from scipy.integrate import solve_ivp  # noqa: PLC0415 - only what integrates pays for it

    begin, events = 0.0, 0
    for piece, duration in enumerate(drive.durations):
        equations, end = _equations(train, drive, piece, begin), begin + duration
        freed = False
        while end - begin > 1e-13 * end:  # less is rounding, in which nothing can move
            mode, y = _settle(equations, contact, freed, begin, y)
            functions = _events(equations, mode)
            solution: Any = solve_ivp(
                partial(equations, mode),
                (begin, end),
                y,
                method="DOP853",
                events=list(functions.values()),
                dense_output=True,
                rtol=tolerance,
                atol=tolerance * train.gap * 1e-3,
                max_step=(end - begin) / 20,
            )
            times = np.linspace(begin, solution.t[-1], points)
            yield times, mode.contact, solution.sol(times)
            met = [n for n, at in zip(functions, solution.t_events, strict=True) if len(at)]
            begin, y = float(solution.t[-1]), solution.y[:, -1]
            contact, freed, y = _after(train, mode, met, y)
            events += 1
            if events > _MOST_EVENTS:
                raise UsageError(f"more than {_MOST_EVENTS} contacts: the gear chatters; damp it")


def _equations(train: DriveTrain, drive: Drive, piece: int, begin: float) -> _Equations:
    """Return the equations of one piece of the drive, which starts at time ``begin``."""
    inertia = train.reflected_inertia
    share = inertia / (inertia + train.load_inertia)
    match drive:
        case Held():
            acceleration = drive.accelerations[piece]
            return _Equations(train, lambda _t, _y: acceleration, 1.0, 0.0)
        case Torque():
            acceleration = drive.torques[piece] * train.ratio / inertia
            return _Equations(train, lambda _t, _y: acceleration, share, 1 / inertia)
        case Servo():
            return _Equations(train, _servo(drive, piece, begin, inertia), share, 1 / inertia)


def _servo(drive: Servo, piece: int, begin: float, inertia: float) -> _Function:
    angle, velocity = drive.angle, drive.velocity
    for duration, a in zip(drive.durations[:piece], drive.accelerations, strict=False):
        angle += (velocity + a * duration / 2) * duration
        velocity += a * duration
    a = drive.accelerations[piece]

    def acceleration(time: float, y: FloatArray) -> float:
        t = time - begin
        error = angle + (velocity + a * t / 2) * t - float(y[0] + y[2])
        slower = velocity + a * t - float(y[1] + y[3])
        torque = drive.proportional * error + drive.derivative * slower
        return min(max(torque, -drive.limit), drive.limit) / inertia

    return acceleration


def _settle(
    equations: _Equations, contact: int, freed: bool, time: float, y: FloatArray
) -> tuple[_Mode, FloatArray]:
    """Return what acts from here, and the state after a plastic impact."""
    y = y.copy()
    if equations.train.rigid and contact:
        if contact * y[3] > 0:  # common velocity, momentum kept
            y[1], y[3] = y[1] + equations.share * y[3], 0.0
        slip = int(np.sign(y[1]))
        if contact * y[3] < 0 or _pressing(equations, contact, slip, time, y) < 0:
            contact = 0
    mode = _Mode(contact, int(np.sign(y[1])), stuck=False)
    if not equations.train.coulomb:
        return replace(mode, slip=0), y
    if mode.slip:
        return mode, y
    push, friction = equations.pushed(mode, time, y)
    stuck = not freed and abs(push) <= friction * (1 + _STICTION / 2)
    return _Mode(contact, 0 if stuck else int(np.sign(push)), stuck), y


def _pressing(equations: _Equations, contact: int, slip: int, time: float, y: FloatArray) -> float:
    """Return how much faster than each other the bodies, left alone, would gain speed [rad/s²].

    Positive where they press on each other, negative where they part. A contact without force
    lasts: what rounding alone leaves must not part it.
    """
    train = equations.train
    push, friction = equations.load_alone(y), train.coulomb / train.load_inertia
    held = math.copysign(max(abs(push) - friction, 0.0), push)
    load, motor = push - slip * friction if slip else held, equations.motor(time, y)
    return contact * (motor - load) + 1e-12 * (abs(motor) + abs(push) + friction + train.gap)


def _events(equations: _Equations, mode: _Mode) -> dict[str, _Function]:
    """Return what can end a phase, by name: functions that cross zero in their direction."""
    found = _contact_events(equations, mode)
    if mode.slip:
        found["stopped"] = _terminal(lambda _t, y: mode.slip * float(y[1]), -1)
    if mode.stuck:

        def overcome(time: float, y: FloatArray) -> float:
            push, friction = equations.pushed(mode, time, y)
            return abs(push) - friction * (1 + _STICTION)

        found["freed"] = _terminal(overcome, 1)
    return found


def _contact_events(equations: _Equations, mode: _Mode) -> dict[str, _Function]:
    train, side = equations.train, mode.contact
    if not side:
        return {
            name: _terminal(partial(_depth, equations, k), 1)
            for name, k in (("right", 1), ("left", -1))
        }
    if not train.rigid:
        deep = partial(_depth, equations, side)
        return {"parted": _terminal(lambda t, y: deep(t, y) + 1e-12 * train.gap, -1)}
    return {"parted": _terminal(partial(_pressing, equations, side, mode.slip), -1)}


def _depth(equations: _Equations, side: int, _time: float, y: FloatArray) -> float:
    """Return how deep the flanks of a side are in contact [rad]; a gear that would pull is not."""
    train = equations.train
    depth = side * float(y[2]) - train.gap / 2
    if train.rigid:
        return depth
    return min(depth, equations.gear_torque(side, y) / train.stiffness)


def _terminal(function: _Function, direction: int) -> _Function:
    """Mark a function as an event that ends the integration, in the way scipy asks for it."""
    function.terminal, function.direction = True, direction  # type: ignore[attr-defined]
    return function


def _after(
    train: DriveTrain, mode: _Mode, met: list[str], y: FloatArray
) -> tuple[int, bool, FloatArray]:
    """Return contact, whether the load was freed, and the state, exact where the event says so."""
    y, contact = y.copy(), mode.contact
    if "right" in met or "left" in met:
        contact = 1 if "right" in met else -1
        if train.rigid:
            y[2], y[3] = contact * train.gap / 2, contact * max(contact * y[3], 0.0)
    if "parted" in met:
        contact = 0
    if "stopped" in met or mode.stuck:
        y[1] = 0.0
    return contact, "freed" in met, y
