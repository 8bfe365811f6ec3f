"""Scatter traced to the joints, over many simulated tests: bias, error, how often intervals hold.

Run: python benchmarks/joint_scatter.py [SEEDS]. A robot of 250 and 200 mm is measured at five poses
by dials, and its RP predicted at a sixth, where the prediction is compared with the RP expected
there and with the RP that a test there measures. The sources of each line are what docs says of
them; coverage is of the true values.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.sources import (
    SOURCES,
    PoseCovariances,
    Traced,
    gaussian_rp,
    patterns_of,
    rounding_of,
    rp_at,
    source_intervals,
    trace,
)
from scara_iso.iso9283 import repeatability
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

SEEDS = 60
ARM = Arm(250, 200)
FIVE = ((-40, 60), (-10, 100), (20, 40), (45, 90), (70, 120))
ELSEWHERE = (0, 75)


@dataclass(frozen=True)
class Robot:
    """What scatters: joints [rad], the dial's own [mm]; ``n`` cycles on a ``division`` [mm].

    ``together`` is the joints' correlation, ``third`` the deviation [mm] of a source that acts in
    one direction at half of the poses, ``tails`` the degrees of freedom of a Student's t.
    """

    joints: tuple[float, float] = (10e-6, 15e-6)
    dial: float = 1.5e-3
    division: float = 1e-3
    n: int = 30
    poses: tuple[tuple[float, float], ...] = FIVE
    together: float = 0.0
    third: float = 0.0
    tails: float = np.inf

    @property
    def true(self) -> FloatArray:
        """Standard deviations of the sources."""
        return np.array([*self.joints, self.dial])

    @property
    def variances(self) -> FloatArray:
        """As `Traced.variances`."""
        return np.array([*self.true**2, self.together * self.joints[0] * self.joints[1]])


ROBOTS = {
    "as assumed": Robot(),
    "four poses": Robot(poses=FIVE[:4]),
    "three poses": Robot(poses=FIVE[:3]),
    "15 cycles": Robot(n=15),
    "100 cycles": Robot(n=100),
    "perfect dial": Robot(dial=0.1e-3),
    "joint 2 hardly": Robot(joints=(10e-6, 1e-6)),
    "joint 1 hardly": Robot(joints=(1e-6, 15e-6)),
    "scatter of 1.2 divisions": Robot(division=3e-3),
    "0.7 divisions": Robot(division=5e-3),
    "0.5 divisions": Robot(division=7e-3),
    "0.35 divisions": Robot(division=10e-3),
    "joints together, 0.5": Robot(together=0.5),
    "joints together, -0.3": Robot(together=-0.3),
    "joints together, -0.7": Robot(together=-0.7),
    "a third source, 2 um": Robot(third=2e-3),
    "a third source, 4 um": Robot(third=4e-3),
    "tails of t5": Robot(tails=5),
    "tails of t3": Robot(tails=3),
}


def readings(robot: Robot, rng: np.random.Generator, seeds: int) -> FloatArray:
    """Return what dials show, (seeds, poses and ELSEWHERE, n, 2) [mm]."""
    joints = np.array([*robot.poses, ELSEWHERE], dtype=float)
    shape = (seeds, len(joints), robot.n)

    def chance(width: int) -> FloatArray:
        if np.isinf(robot.tails):
            return rng.normal(size=(*shape, width))
        scale = np.sqrt(1 - 2 / robot.tails)
        return rng.standard_t(robot.tails, size=(*shape, width)) * scale

    rho = robot.together
    root = np.diag(robot.joints) @ np.array([[1, 0], [rho, np.sqrt(1 - rho**2)]])
    seen = np.einsum("pik,spnk->spni", ARM.jacobian(joints), chance(2) @ root.T)
    seen += robot.dial * chance(2)
    phi = rng.uniform(0, np.pi, size=(*shape[:2], 1))
    acts = rng.uniform(size=(*shape[:2], 1)) < 0.5
    along = np.stack([np.cos(phi), np.sin(phi)], axis=-1) * acts[..., np.newaxis]
    seen += robot.third * along * chance(1)
    step = robot.division
    return np.round(seen / step + rng.uniform(size=(*shape[:2], 1, 2))) * step


def fitted(robot: Robot, shown: FloatArray) -> list[Traced]:
    """Return the fits to all poses but ELSEWHERE."""
    about = shown - shown.mean(axis=-2, keepdims=True)
    observed = np.einsum("...ni,...nj->...ij", about, about)[:, :-1] / (robot.n - 1)
    known = rounding_of(np.full(2, robot.division))
    freedom = np.full(len(robot.poses), robot.n - 1.0)
    patterns = patterns_of(ARM, np.array(robot.poses, dtype=float))
    return [trace(PoseCovariances(one, freedom, patterns, known)) for one in observed]


def held(robot: Robot, fits: list[Traced]) -> Iterator[float]:
    """Yield how often the interval of each source holds the true value."""
    ends = np.array([list(source_intervals(one)) for one in fits])
    inside = (ends[:, :, 0] <= robot.true) & (robot.true <= ends[:, :, 1])
    yield from inside.mean(axis=0).tolist()


def line(name: str, robot: Robot, seeds: int) -> str:
    """Return bias, rms error and coverage of the sources, and what comes of the sixth pose."""
    shown = readings(robot, np.random.default_rng(9283), seeds)
    fits = fitted(robot, shown)
    error = np.sqrt([one.variances[: len(SOURCES)] for one in fits]) / robot.true - 1
    of_sources = [
        f"{b:+4.0%} {r:4.0%} {c:5.1%}"
        for b, r, c in zip(error.mean(axis=0), np.sqrt((error**2).mean(axis=0)),
                           held(robot, fits), strict=True)
    ]  # fmt: skip
    measured = repeatability(np.swapaxes(shown[:, -1], -1, -2)).RP
    known = rounding_of(np.full(2, robot.division))
    there = patterns_of(ARM, np.array([ELSEWHERE], dtype=float))
    value, low, high = np.array([rp_at(one, there, robot.n) for one in fits])[..., 0].T
    truth = known + np.einsum("k,mkij->mij", robot.variances, there)[0]
    plain = np.isinf(robot.tails) and not robot.third
    expected = gaussian_rp(truth, robot.n)[0] if plain else measured.mean()
    of_rp = [np.sqrt(np.mean((one / expected - 1) ** 2)) for one in (value, measured)]
    inside = np.mean((low <= measured) & (measured <= high))
    return (
        f"| {name} | {' | '.join(of_sources)} | {of_rp[0]:.1%} | {of_rp[1]:.1%} | {inside:.1%} | "
        f"{np.mean([one.together for one in fits]):.0%} | "
        f"{np.mean([one.p_value < 0.05 for one in fits]):.0%} |"
    )


def main(seeds: int = SEEDS) -> None:
    """Print a table, a line for each robot."""
    columns = [f"{name}: bias, rms, coverage" for name in SOURCES]
    columns += ["RP elsewhere: rms, predicted", "rms, measured there", "interval holds measured"]
    columns += ["joints seen together", "misfit seen"]
    print(f"{seeds} tests a line; one standard error of 95 % is {np.sqrt(0.0475 / seeds):.1%}")
    print(f"| | {' | '.join(columns)} |\n|{'---|' * (len(columns) + 1)}")
    for name, robot in ROBOTS.items():
        print(line(name, robot, seeds), flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
