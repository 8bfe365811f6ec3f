"""Streams of a robot that comes to a dial and leaves it: a second-order step response.

Written for itself and shares nothing with the program: the response in closed form, its peak and
the times at which it crosses a band by bisection on that form.
"""

import math
from dataclasses import dataclass

import numpy as np

FREE = 3.0
"""Reading of the dial when nothing touches it [mm]."""


@dataclass(frozen=True)
class Arm:
    """An arm that answers a step with damping ratio ``zeta`` and natural frequency [rad/s]."""

    zeta: float = 0.3
    omega: float = 25.0

    def off(self, t, step):
        """Return the distance to the attained pose at times after a step of ``step``."""
        t = np.asarray(t, dtype=float)
        damped = self.omega * math.sqrt(1 - self.zeta**2)
        swing = np.cos(damped * t) + self.zeta / math.sqrt(1 - self.zeta**2) * np.sin(damped * t)
        return -step * np.exp(-self.zeta * self.omega * t) * swing

    def overshoot(self, step):
        """Return the largest distance beyond: textbook."""
        return abs(step) * math.exp(-math.pi * self.zeta / math.sqrt(1 - self.zeta**2))

    def stabilisation(self, step, band):
        """Return the time from the first crossing of the band to the last, on a fine grid."""
        t = np.linspace(0, 20 / (self.zeta * self.omega), 2_000_001)
        inside = np.abs(self.off(t, step)) <= band
        first = int(np.argmax(inside))
        return float(t[np.flatnonzero(~inside)[-1] + 1] - t[first])


def visits(
    rng,
    *,
    count=5,
    hz=500.0,
    dwell=2.0,
    away=1.5,
    level=0.4,
    scatter=0.005,
    noise=0.0005,
    free_noise=0.0,
    arm=None,
    travel=2.0,
    division=None,
):
    """Return time, reading and the true poses of ``count`` visits; the free dial rests between.

    The plunger is pushed in over ``travel`` seconds up to 0.3 mm before the pose; then the arm
    steps the rest, rings, dwells, and leaves as it came.
    """
    arm = arm or Arm()
    dt, pieces, poses = 1 / hz, [np.full(round(away * hz), FREE)], []
    for _ in range(count):
        pose = level + scatter * rng.standard_normal()
        near = pose + 0.3
        n = round(travel * hz)
        ramp = FREE + (near - FREE) * (0.5 - 0.5 * np.cos(np.pi * np.arange(n) / n))
        # A ramp that ends at speed: the last part of it is the step's own.
        t = np.arange(round(dwell * hz)) * dt
        pieces += [ramp[: int(0.9 * n)], pose + arm.off(t, -0.3)]
        pieces += [pose + (FREE - pose) * (0.5 - 0.5 * np.cos(np.pi * np.arange(n) / n))]
        pieces += [np.full(round(away * hz), FREE)]
        poses.append(pose)
    reading = np.concatenate(pieces)
    moved = reading != FREE
    reading = reading + np.where(moved, noise, free_noise) * rng.standard_normal(len(reading))
    if division:
        reading = np.round(reading / division) * division
    return np.arange(len(reading)) * dt, reading, np.array(poses)


def text(time, readings, head="# unit: mm\n# resolution: 0.001\n", places=3, time_places=4):
    """Return the stream as a table; ``readings`` by axis."""
    lines = [head + ",".join(["time_s", *readings])]
    for k, t in enumerate(time.tolist()):
        cells = [
            f"{t:.{time_places}f}",
            *(f"{values[k]:.{places}f}" for values in readings.values()),
        ]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"
