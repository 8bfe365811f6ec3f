"""Compute tables and picture of benchmarks/results/model.md; print or, with --write, write them.

``python -m benchmarks.drivetrain [--write]``. Every number in the document comes from here.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.page import DOCS, RESULTS, run
from scara_iso.render.plots import save_figure
from scara_iso.robot import Approach
from tests.oracles.drivetrain import DriveTrain, Move, arrivals
from tests.oracles.integration import integrate
from tests.oracles.motion import (
    LEFT,
    RIGHT,
    Drive,
    Held,
    Servo,
    State,
    Torque,
    Trajectory,
    solve,
)

CONTACT = {1: "#cfe8d5", 0: "#f2f2f2", -1: "#f6d9d0"}
ARM_M = 0.7  # eq. 21
MEASURED_MM = 0.0141  # radial RP of Table I in the plane, recomputed
PAPER = DriveTrain(2.65e-4, 4.749, math.radians(12 / 60))  # eq. 17, 18
GEARED = replace(PAPER, ratio=50.0)

# what the paper does not give: assumed
FRICTION = 5.0  # N m
STIFFNESS = 20.0 * 60 * 180 / math.pi  # 20 N m/arcmin in N m/rad
GEAR_DAMPING = 0.1  # of critical, with the load
VISCOUS = 5.0  # N m s/rad
BANDWIDTHS = (5.0, 10.0, 20.0)  # Hz, of the servo, critically damped
FAST, SLOW = Move(1.0, 10.0, 0.01, 0.05), Move(0.05, 10.0, 0.01, 0.05)
ARRIVALS, SETS = 30, 5000


def repeatability(readings: np.ndarray) -> np.ndarray:
    """Return RP by eq. 2-6 over the last axis."""
    away = np.abs(readings - readings.mean(axis=-1, keepdims=True))
    return away.mean(axis=-1) + 3 * away.std(axis=-1, ddof=1)


def reversal(train: DriveTrain) -> float:
    """Return the load deviation from right to left contact, by following the motion [rad]."""
    j, i = train.reflected_inertia, train.load_inertia
    crossing = math.sqrt(2 * train.gap * j)
    run = solve(train, Torque((1.2 * crossing,), (-1 / train.ratio,)), State.touching(train, RIGHT))
    if run.contact[-1] != LEFT:
        raise SystemExit("the reversal did not reach left contact")
    start = j / (j + i) * run.gap_angle[0]
    end = start - run.time[-1] ** 2 / (2 * (j + i))  # eq. 11
    return float((run.load_angle[0] - start) - (run.load_angle[-1] - end))


def equation_16_table() -> Iterator[str]:
    """Yield eq. 16 against the simulator: the paper's joint, and the worst of 18 others."""
    rng = np.random.default_rng(16)
    drawn = [
        DriveTrain(
            float(f"{10 ** rng.uniform(-5, -2):.3g}"),
            float(f"{10 ** rng.uniform(-3, 1):.3g}"),
            math.radians(rng.integers(1, 61) / 60),
            float(rng.choice([1, 10, 50, 100])),
        )
        for _ in range(18)
    ]
    yield "| joint 1 of the paper | eq. 16 [rad] | simulator [rad] | relative difference |"
    yield "|---|---|---|---|"
    for name, train in (("N = 1", PAPER), ("N = 50", GEARED)):
        closed, followed = equation_16(train), reversal(train)
        yield f"| {name} | {closed:.9e} | {followed:.9e} | {abs(followed / closed - 1):.0e} |"
    worst = max(abs(reversal(train) / equation_16(train) - 1) for train in drawn)
    yield f"| {len(drawn)} drive trains drawn at random | | | at most {worst:.0e} |"


def equation_16(train: DriveTrain) -> float:
    """Return the load deviation in closed form [rad]."""
    return -train.gap / (1 + train.load_inertia / train.reflected_inertia)


@dataclass(frozen=True)
class Case:
    """One row of the table of effects."""

    name: str
    shift: float
    """By how much a reversal, or the other approach, moves the load [rad]."""
    one_side: np.ndarray
    """Rest positions of arrivals from one side [rad], shape (sets, 30)."""


def free(name: str, train: DriveTrain) -> Case:
    """Return the paper's argument for a motor that nothing holds: no scatter from one side."""
    shift = abs(reversal(train))
    return Case(name, shift, np.full((SETS, ARRIVALS), shift / 2))


def held(name: str, train: DriveTrain, move: Move) -> Case:
    """Return arrivals of a motor that obeys its servo, in closed form."""
    rng = np.random.default_rng(1)
    found = arrivals(train, move, Approach.ONE_SIDE, count=SETS * ARRIVALS, rng=rng)
    still = replace(move, speed_scatter=0.0, friction_scatter=0.0)
    both = arrivals(train, still, Approach.BOTH_SIDES, count=2, rng=rng)
    return Case(name, abs(float(np.ptp(both.load_angle))), found.load_angle.reshape(SETS, -1))


def integrated(name: str, train: DriveTrain, move: Move, servo: tuple[float, float] | None) -> Case:
    """Return arrivals followed numerically, each from one side, with the scatter of ``move``."""
    rng, rests = np.random.default_rng(1), []
    for k in range(ARRIVALS + 1):
        v = move.speed * (1 + move.speed_scatter * rng.standard_normal() * (k > 0))
        f = train.coulomb * (1 + move.friction_scatter * rng.standard_normal() * (k > 0))
        pieces = ((v / move.deceleration, 1.5), (-move.deceleration, 0.0))
        drive: Drive = Held(*pieces)
        if servo:
            drive = Servo(*pieces, *servo, angle=train.gap / 2, velocity=v)
        start = State.touching(train, RIGHT, velocity=v)
        run = integrate(replace(train, coulomb=f), drive, start, tolerance=1e-8)
        rests.append(run.load_angle[-1] - train.gap / 2 - v**2 / (2 * move.deceleration))
    return Case(name, 2 * abs(rests[0]), np.array(rests[1:])[None])


def cases() -> Iterator[Case]:
    """Yield the rows of the table of effects."""
    rubbing = replace(GEARED, coulomb=FRICTION)
    soft = replace(
        rubbing,
        stiffness=STIFFNESS,
        damping=GEAR_DAMPING * 2 * math.sqrt(STIFFNESS * GEARED.load_inertia),
    )
    stuck = math.ceil(1.5 * GEARED.load_inertia * FAST.deceleration)
    yield free("the paper: free motor, no friction, rotor at N = 1", PAPER)
    yield free("rotor seen through the gearbox, N = 50", GEARED)
    yield held("motor held by its servo, no friction", GEARED, FAST)
    yield held(f"held, friction {FRICTION:g} N m, {FAST.speed:g} rad/s", rubbing, FAST)
    yield held(f"held, friction {FRICTION:g} N m, {SLOW.speed:g} rad/s", rubbing, SLOW)
    heavy = replace(GEARED, coulomb=stuck)
    yield held(f"held, friction {stuck:g} N m, {FAST.speed:g} rad/s", heavy, FAST)
    viscous = replace(rubbing, viscous=VISCOUS)
    yield integrated(
        f"as the fifth row, viscous friction {VISCOUS:g} N m s/rad", viscous, SLOW, None
    )
    yield integrated(
        f"friction {FRICTION:g} N m, {FAST.speed:g} rad/s, compliant gear", soft, FAST, None
    )
    inertia = GEARED.reflected_inertia + GEARED.load_inertia
    for bandwidth in BANDWIDTHS:
        gain = inertia * (2 * math.pi * bandwidth) ** 2
        name = f"friction {FRICTION:g} N m, {FAST.speed:g} rad/s, servo of {bandwidth:g} Hz"
        yield integrated(name, rubbing, FAST, (gain, 2 * math.sqrt(gain * inertia)))


def effects_table() -> Iterator[str]:
    """Yield what each effect does to the load and to RP at the tool."""
    yield (
        "| case | load shift on reversal [rad] | at the tool [mm] | RP, one side [mm] "
        "| over measured | RP, random sides [mm] | over measured |"
    )
    yield "|---|---|---|---|---|---|---|"
    rng = np.random.default_rng(2)
    for case in cases():
        to_mm = ARM_M * 1000
        one = repeatability(case.one_side * to_mm).mean()
        one = 0.0 if one < 1e-9 else one  # rounding
        drawn = np.resize(case.one_side, (SETS, ARRIVALS))
        sides = 1 - 2 * rng.integers(2, size=drawn.shape)
        two = repeatability(sides * drawn * to_mm).mean()
        yield (
            f"| {case.name} | {case.shift:.4g} | {case.shift * to_mm:.4g} | {one:.3g} | "
            f"{one / MEASURED_MM:.3g} | {two:.3g} | {two / MEASURED_MM:.3g} |"
        )


def assumptions() -> Iterator[str]:
    """Yield what the table assumes."""
    yield f"* Coulomb friction {FRICTION:g} N m, viscous friction {VISCOUS:g} N m s/rad at joint 1."
    yield (
        f"* Gear and shaft {STIFFNESS / 60 * math.pi / 180:g} N m/arcmin, damped with "
        f"{GEAR_DAMPING:g} of critical; the servo is critically damped."
    )
    yield (
        f"* Arrivals at {FAST.speed:g} rad/s (slow: {SLOW.speed:g} rad/s), braking with "
        f"{FAST.deceleration:g} rad/s²; between arrivals the speed scatters by "
        f"{FAST.speed_scatter:.0%}, the friction by {FAST.friction_scatter:.0%}."
    )
    yield (
        f"* RP is the mean over {SETS} tests of {ARRIVALS} arrivals by eq. 2-6 (one test of "
        f"{ARRIVALS} where the motion is integrated), at {ARM_M:g} m; measured: {MEASURED_MM:g} mm."
    )


def speed() -> Iterator[str]:
    """Yield how fast arrivals are followed."""
    train, count = replace(GEARED, coulomb=FRICTION), 10_000
    best = math.inf
    for _ in range(5):
        begin = time.perf_counter()
        arrivals(train, SLOW, Approach.RANDOM, count=count, rng=np.random.default_rng(1))
        best = min(best, time.perf_counter() - begin)
    yield (
        f"{count} arrivals take {best * 1000:.1f} ms on one core of the machine that made this "
        f"page, {10 / best:.0f} times faster than the 10 s that they may take."
    )


def three_states() -> Trajectory:
    """Return a motion to and fro through right contact, no contact and left contact."""
    drive = Torque((0.02, 0.06, 0.05, 0.05), (0.6, -0.6, 0.6, -0.4))
    return solve(GEARED, drive, State(gap_angle=0.0), points=60)


def plot_gap(trajectory: Trajectory, train: DriveTrain, path: Path) -> None:
    """Draw gap angle, motor and load through time, the three contact states in colour."""
    figure = Figure(figsize=(8, 5.5), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    time = trajectory.time * 1000
    _shade_contacts(upper, trajectory)
    for end in (-1, 1):
        upper.axhline(end * train.gap / 2 * 1000, color="#7f97ad", lw=0.8, ls="--")
    upper.plot(time, trajectory.gap_angle * 1000, color="#1f4e79", lw=1.8)
    upper.set(ylabel="motor − load [mrad]", title="Gap angle in the three contact states")
    upper.set_ylim(-0.62 * train.gap * 1000, 0.62 * train.gap * 1000)
    upper.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=3, fontsize=8, frameon=False
    )
    lower.plot(
        time, trajectory.motor_angle * 1000, color="#e69f00", lw=1.8, label="motor, at the output"
    )
    lower.plot(time, trajectory.load_angle * 1000, color="#444444", lw=1.8, label="load")
    lower.set(xlabel="time [ms]", ylabel="angle [mrad]")
    lower.legend(fontsize=8, frameon=False)
    save_figure(figure, path)


def _shade_contacts(axes: Axes, trajectory: Trajectory) -> None:
    names = {1: "right contact", 0: "no contact", -1: "left contact"}
    edges = np.flatnonzero(np.diff(trajectory.contact)) + 1
    ends = np.append(edges, len(trajectory.time)) - 1
    for first, last in zip(np.append(0, edges), ends, strict=True):
        side = int(trajectory.contact[first])
        label = names.pop(side, None)
        span = trajectory.time[[first, last]] * 1000
        axes.axvspan(*span, color=CONTACT[side], lw=0, label=label)


def picture() -> Iterator[str]:
    """Draw the picture and yield the line that shows it."""
    path = DOCS / "figures" / "gap_angle.svg"
    path.parent.mkdir(parents=True, exist_ok=True)
    plot_gap(three_states(), GEARED, path)
    yield "![Gap angle through time](../../docs/figures/gap_angle.svg)"


PARTS: dict[str, Callable[[], Iterator[str]]] = {
    "equation 16": equation_16_table,
    "assumptions": assumptions,
    "effects": effects_table,
    "speed": speed,
    "picture": picture,
}


if __name__ == "__main__":
    run(PARTS, RESULTS / "model.md", __doc__)
