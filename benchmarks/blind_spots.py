"""What once passed for scatter: levels along a slant, three levels, an odd cycle.

    python benchmarks/blind_spots.py [--runs 100]

31 cycles of X and Y at one pose, along 45 degrees, and at five poses along a direction that turns;
scatter of 10 divisions. Sizes are in that scatter; of two levels two cycles in five are on the
upper. *Before*: each axis alone, two levels at most.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from functools import partial
from unittest.mock import patch

import numpy as np

from scara_iso.diagnosis import Verdict, diagnose_poses, whole_cycles
from scara_iso.diagnosis.engine import marginal
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.run import Axis, FloatArray, Run

N, SCATTER = 31, 10.0
ANGLES = {1: np.array([np.pi / 4]), 5: np.radians([-60, -10, 60, 120, 200])}
Law = Callable[[np.random.Generator, int], FloatArray]
FAMILIES: dict[str, Law] = {
    "Gaussian": lambda rng, n: rng.normal(size=n),
    "t5": lambda rng, n: rng.standard_t(5, n) / np.sqrt(5 / 3),
    "Laplace": lambda rng, n: rng.laplace(size=n) / np.sqrt(2),
    "uniform": lambda rng, n: rng.uniform(-1, 1, n) * np.sqrt(3),
    "arcsine": lambda rng, n: np.sin(rng.uniform(0, 2 * np.pi, n)) * np.sqrt(2),
    "gamma": lambda rng, n: (rng.gamma(4, size=n) - 4) / 2,
}


def is_found(rng: np.random.Generator, course: FloatArray, poses: int, law: Law) -> bool:
    """Return whether anything is found where a course (n,) moves all axes along one direction."""
    rows: dict[str, Run] = {}
    for k, angle in enumerate(ANGLES[poses]):
        axes = {
            name: Axis(name, np.rint(SCATTER * (course * part + law(rng, N))), resolution=1.0)
            for name, part in (("X", np.cos(angle)), ("Y", np.sin(angle)))
        }
        rows[f"P{k + 1}"] = Run(np.arange(1, N + 1), axes)
    if poses == 1:
        return diagnose_readings(rows["P1"]).verdict is not Verdict.NOTHING
    labels = np.repeat([*rows], N)
    every = Run(
        np.tile(np.arange(1, N + 1), poses),
        {
            name: Axis(
                name,
                np.concatenate([run.axes[name].readings for run in rows.values()]),
                resolution=1.0,
            )
            for name in ("X", "Y")
        },
        pose=labels,
    )
    whole = whole_cycles(every, {p: np.flatnonzero(labels == p) for p in rows})
    return diagnose_poses(whole).verdict is not Verdict.NOTHING


def two_levels(rng: np.random.Generator, size: float) -> FloatArray:
    """Return a course (n,) on two levels in no order."""
    return np.where(rng.random(N) < 0.4, size, 0.0)


def on_levels(rng: np.random.Generator, size: float, levels: int = 3) -> FloatArray:
    """Return a course (n,) on levels in no order."""
    return np.asarray(size * rng.integers(0, levels, N), dtype=np.float64)


def odd_cycle(rng: np.random.Generator, size: float) -> FloatArray:
    """Return a course (n,) that one cycle leaves."""
    return np.where(np.arange(N) == rng.integers(5, N), size, 0.0)


def shares(runs: int, poses: int) -> Iterator[tuple[str, float]]:
    """Yield what is simulated, and the share of tables [%] in which anything is found."""

    def share(
        seed: int,
        of: Callable[[np.random.Generator], FloatArray],
        law: Law,
    ) -> float:
        rngs = (np.random.default_rng([seed, run]) for run in range(runs))
        return 100 * sum(is_found(rng, of(rng), poses, law) for rng in rngs) / runs

    gaussian = FAMILIES["Gaussian"]
    for size in (4.0, 5.0, 6.0) if poses == 1 else (2.0, 3.0, 4.0):
        yield f"two levels {size:g}", share(1, partial(two_levels, size=size), gaussian)
    for size in (6.0, 8.0, 15.0) if poses == 1 else (4.0, 6.0, 8.0):
        yield f"three levels {size:g}", share(4, partial(on_levels, size=size), gaussian)
    yield "five levels 8", share(5, partial(on_levels, size=8.0, levels=5), gaussian)
    for size in (8.0, 10.0, 12.0) if poses == 1 else (4.0, 5.0, 6.0):
        yield f"odd cycle {size:g}", share(2, partial(odd_cycle, size=size), gaussian)
    for name, law in FAMILIES.items():
        yield f"scatter alone, {name}", share(3, lambda _: np.zeros(N), law)


def main() -> None:
    """Print a table for one pose and one for five."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100)
    runs = parser.parse_args().runs
    for poses in ANGLES:
        print(f"\n| poses: {poses} | found [%] | before [%] |\n|---|---|---|")
        together = list(shares(runs, poses))
        with (
            patch.object(marginal, "WIDEST_SHARE", 1e-6),
            patch.object(marginal, "THREE_SHARE", 1e-6),
        ):
            for (name, now), (_, before) in zip(together, shares(runs, poses), strict=True):
                print(f"| {name} | {now:.0f} | {before:.0f} |", flush=True)


if __name__ == "__main__":
    main()
