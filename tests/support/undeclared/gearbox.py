"""Joint 1's gear followed through time: flanks, friction, wind-up. Nothing here knows a shape."""

from __future__ import annotations

import numpy as np
from oracles.drivetrain import DriveTrain, Move, arrivals
from oracles.integration import integrate
from oracles.motion import RIGHT, Held, State, Torque, solve

from scara_iso.robot import Approach
from undeclared.dial import CYCLES, on_dial

_ARM_MM = 700.0
MOTOR, GAP = 2.65e-4, np.radians(12 / 60)
_INERTIA = {"motor_inertia": MOTOR, "load_inertia": 4.749, "ratio": 50.0}
_MOVE = Move(speed=1.0, deceleration=10.0, speed_scatter=0.02, friction_scatter=0.1)


def reversal(rng):
    """Either side by chance, the side written down; a good gear of 3 to 8 scatters at the tool."""
    side, moved = _arrived(rng, Approach.RANDOM)
    return on_dial(rng, moved, recorded={"approach": side.astype(float)})


def hidden_sides(rng):
    """The same, but nobody wrote the side down."""
    _, moved = _arrived(rng, Approach.RANDOM)
    return on_dial(rng, moved)


def changing_flank(rng):
    """The route to the pose is changed some times during the test, and with it the flank."""
    chosen = 1 - 2 * (np.cumsum(rng.random(CYCLES) < 0.15) % 2)
    _, moved = _arrived(rng, chosen)
    return on_dial(rng, moved)


def one_side(rng):
    """One side only: the load ends on one flank each time, and nothing but scatter is left."""
    _, moved = _arrived(rng, Approach.ONE_SIDE)
    return on_dial(rng, moved)


def coasting(rng):
    """Slow, medium and rated speed in random order: friction stops the load inside the gap."""
    gap = rng.uniform(0.020, 0.032) / _ARM_MM
    friction = 5.0
    crosses = np.sqrt(2 * friction * gap / _INERTIA["load_inertia"])
    speed = rng.permutation(np.resize([0.25, 0.6, 1.4], CYCLES)) * crosses
    train = DriveTrain(**_INERTIA, gap=gap, coulomb=friction)
    rest = np.empty(CYCLES)
    for v in np.unique(speed):
        at = speed == v
        move = Move(float(v), 10.0, speed_scatter=0.02, friction_scatter=0.05)
        found = arrivals(train, move, Approach.ONE_SIDE, count=int(at.sum()), rng=rng)
        rest[at] = found.load_angle
    percent = np.round(100 * speed / speed.max(), 1)
    return on_dial(rng, _at_the_tool(rng, rest), recorded={"speed": percent})


def hanging(rng):
    """A gear that yields holds payloads of three weights; each is followed until it hangs still."""
    kilograms = np.array([0.0, 2.0, 5.0])
    stiffness = rng.uniform(1.5, 2.5) * 1e5
    rest = {}
    for m in kilograms:
        train = DriveTrain(
            motor_inertia=1e-3, load_inertia=0.5, gap=1e-5, stiffness=stiffness,
            damping=2 * np.sqrt(0.5 * stiffness), load_torque=-9.81 * float(m) * 0.1,
        )  # fmt: skip
        held = integrate(train, Held((0.5,), (0.0,)), State.touching(train, RIGHT), tolerance=1e-7)
        rest[m] = float(held.load_angle[-1])
    carried = rng.permutation(np.resize(kilograms, CYCLES))
    sagged = 1000 * 0.5 * np.array([rest[m] for m in carried])
    return on_dial(rng, {"X": 0 * sagged, "Z": sagged}, recorded={"payload_kg": carried})


def _arrived(rng, approach):
    gap = rng.uniform(0.012, 0.032) / _ARM_MM
    found = arrivals(
        DriveTrain(**_INERTIA, gap=gap, coulomb=5.0), _MOVE, approach, count=CYCLES, rng=rng
    )
    return found.approach, _at_the_tool(rng, found.load_angle)


def _at_the_tool(rng, angle):
    tangent = rng.uniform(0.3, 1.2)
    return {"X": -_ARM_MM * angle * np.sin(tangent), "Y": _ARM_MM * angle * np.cos(tangent)}


def free_motor(load, *, gap=GAP, ratio=1.0):
    """Return `freely_reversed` of the paper's first joint with another load."""
    return freely_reversed(DriveTrain(MOTOR, float(load), gap, ratio=ratio))


def freely_reversed(train):
    """Return the load's deviation on a reversal from the centre of mass, from the motion itself."""
    moved = solve(train, Torque((10.0,), (-1e-3,)), State.touching(train, RIGHT))
    at = int(np.flatnonzero(moved.contact == -1)[0])
    rotor, load = train.reflected_inertia, train.load_inertia
    off = moved.load_angle - (rotor * moved.motor_angle + load * moved.load_angle) / (rotor + load)
    return float(off[0] - off[at])
