"""How often RP of new tests lies in the interval that `diagnose` of the first one predicts.

    python benchmarks/repeat_test.py [--tests 200] [--repeats 10] [--seed 9283] [--only walk]

Tests of 30 cycles of one mechanism, a dial of 0.001 mm in X and Y and a standard deviation of five
divisions. Courses and sides act in either axis by themselves, but for *sides in common*. What is
chance is drawn anew in each test, what follows the cycles is not. The interval is to hold RP of X
and of the plane in 95 of 100 new tests.
"""

import argparse
import math
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.iso9283 import repeatability
from scara_iso.run import Axis, FloatArray, Run

Draw = Callable[[np.random.Generator], FloatArray]
"""Readings of a test in standard deviations of its scatter, shape (axes, cycles)."""

SIGMA, DIVISION = 0.005, 0.001
SHAPE = (2, 30)
CYCLE = np.arange(SHAPE[1])
SIDES_STAY = 0.2


def _sides(distance: float, upper: float, axes: int = 2) -> Draw:
    def draw(rng: np.random.Generator) -> FloatArray:
        return distance * (rng.random((axes, SHAPE[1])) < upper) + rng.normal(size=SHAPE)

    return draw


def _sticky(rng: np.random.Generator) -> FloatArray:
    sides = np.cumsum(rng.random(SHAPE) < SIDES_STAY, axis=1) % 2
    return 10 * sides + rng.normal(size=SHAPE)


def _autocorrelated(rng: np.random.Generator) -> FloatArray:
    course = 4 * rng.normal(size=SHAPE)
    course[:, 1:] *= 0.6
    for j in range(1, SHAPE[1]):
        course[:, j] += 0.8 * course[:, j - 1]
    return np.asarray(course + rng.normal(size=SHAPE))


def _course(shape: FloatArray) -> Draw:
    return lambda rng: shape + rng.normal(size=SHAPE)


MECHANISMS: dict[str, Draw] = {
    "Gaussian": lambda rng: rng.normal(size=SHAPE),
    "Student t, 5": lambda rng: rng.standard_t(5, SHAPE) * math.sqrt(3 / 5),
    "uniform": lambda rng: rng.uniform(-math.sqrt(3), math.sqrt(3), SHAPE),
    "exponential": lambda rng: rng.exponential(size=SHAPE),
    "two sides, 10 apart": _sides(10, 0.5),
    "two sides, 20 apart": _sides(20, 0.5),
    "two sides, 10 apart, 20:80": _sides(10, 0.8),
    "two sides, 20 apart, 20:80": _sides(20, 0.8),
    "sides in common, 10 apart": _sides(10, 0.5, axes=1),
    "sides that stay, 10 apart": _sticky,
    "walk, steps of 1": lambda rng: (
        np.cumsum(rng.normal(size=SHAPE), axis=1) + rng.normal(size=SHAPE)
    ),
    "autocorrelated, 0.8": _autocorrelated,
    "drift": _course(0.3 * CYCLE),
    "step": _course(5.0 * (CYCLE >= 15)),
    "sine": _course(5 * np.sin(2 * np.pi * CYCLE / 10 + 1)),
    "warm-up": _course(8 * (1 - np.exp(-CYCLE / 5))),
}


def counted(task: tuple[str, int, int]) -> tuple[list[int], str]:
    """Return how many new tests lie inside for X and for XY, above XY, and what was found."""
    name, seed, repeats = task
    rng = np.random.default_rng([seed, list(MECHANISMS).index(name)])
    first, *others = (_read(MECHANISMS[name](rng)) for _ in range(repeats + 1))
    axes = {n: Axis(n, row, resolution=DIVISION) for n, row in zip("XY", first, strict=True)}
    found = diagnose_readings(Run(CYCLE + 1, axes))
    inside = []
    for figure, count in (("X", 1), ("XY", 2)):
        low, high = found.repeatability.completed[figure].interval
        RP = repeatability(np.stack(others)[:, :count]).RP
        inside.append(int(((low <= RP) & (RP <= high)).sum()))
    return inside, "+".join(sorted({one.effect for one in found.effects})) or found.verdict.value


def _read(readings: FloatArray) -> FloatArray:
    return np.asarray(np.round(0.5 + SIGMA * readings, 3))


def main() -> None:
    """Print the share of new tests inside for each mechanism, with its standard error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tests", type=int, default=200)
    parser.add_argument("--repeats", type=int, default=10)
    parser.add_argument("--seed", type=int, default=9283)
    parser.add_argument("--only", default="", help="mechanisms whose name holds this")
    options = parser.parse_args()
    print(f"{'mechanism':28}{'X':>8}{'XY':>8}   found")
    with ProcessPoolExecutor(2) as pool:
        for name in (one for one in MECHANISMS if options.only in one):
            tasks = [(name, options.seed + k, options.repeats) for k in range(options.tests)]
            inside, found = zip(*pool.map(counted, tasks, chunksize=5), strict=True)
            shares = np.mean(inside, axis=0) / options.repeats
            often = ", ".join(f"{n} {k}" for n, k in Counter(found).most_common(3))
            print(f"{name:28}{shares[0]:8.1%}{shares[1]:8.1%}   {often}", flush=True)


if __name__ == "__main__":
    main()
