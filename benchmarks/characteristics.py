"""How often the 95 % intervals of the characteristics hold the truth, by simulation.

    python benchmarks/characteristics.py [--seed 9283] [--runs 500]

Each line draws many tests and counts where the interval of XYZ lies wholly above the true figure
(too high), wholly below it (too low), or holds it; of `steady_after` also how many tests give none.
Robots that do not move at all are there on purpose: the largest of several distances is never 0,
and an interval that forgets it would be too high.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from itertools import combinations

import numpy as np

from scara_iso.base.quantities import Estimate
from scara_iso.iso9283 import repeatability
from scara_iso.iso9283.characteristics.drp import change_of_repeatability
from scara_iso.iso9283.core.drift import DriftFit, fit_drift
from scara_iso.iso9283.core.statistics import largest_distance
from scara_iso.run import Axis, FloatArray

Draw = Callable[[np.random.Generator, tuple[int, ...]], FloatArray]
Ends = tuple[float, float] | None
Test = Callable[[np.random.Generator], Ends]
Case = tuple[str, str, float, Test]

SCATTERS: dict[str, Draw] = {
    "Gaussian": lambda rng, shape: rng.standard_normal(shape),
    "Student t, 5": lambda rng, shape: rng.standard_t(5, shape) * math.sqrt(3 / 5),
    "exponential": lambda rng, shape: rng.exponential(1, shape) - 1,
}
SIGMA = 0.01  # mm
CYCLES, BLOCKS, VISITS = 30, 33, 10
HOURS = np.arange(BLOCKS) / 4


def shown(
    rng: np.random.Generator, draw: Draw, centres: FloatArray, n: int, division: float
) -> list[FloatArray]:
    """Return positions of shape (3, n) about each centre, as a dial of this division shows them."""
    place = rng.uniform(0, 1, 3) * (division or 1)
    found = [(c + place)[:, None] + SIGMA * draw(rng, (3, n)) for c in centres]
    return [np.rint(x / division) * division for x in found] if division else found


def dials(division: float) -> list[Axis]:
    """Return the axes of a dial."""
    return [Axis(name, np.zeros(1), resolution=division or None) for name in "XYZ"]


def directions(draw: Draw, apart: float, division: float = 0.0) -> Test:
    """Return vAP of three barycentres at the corners of an equal triangle."""
    corners = apart * np.array([(0, 0, 0), (1, 0, 0), (0.5, math.sqrt(0.75), 0)])

    def test(rng: np.random.Generator) -> Ends:
        groups = shown(rng, draw, corners, CYCLES, division)
        pairs = list(combinations(range(3), 2))
        return largest_distance(groups, pairs, axes=dials(division), clause="").interval

    return test


def blocks(draw: Draw, size: float, tau_h: float = 0.9, division: float = 0.0) -> Test:
    """Return dAP of blocks that drift in X."""

    def test(rng: np.random.Generator) -> Ends:
        groups = shown(rng, draw, course(size, tau_h), VISITS, division)
        pairs = [(0, k) for k in range(1, BLOCKS)]
        return largest_distance(groups, pairs, axes=dials(division), clause="").interval

    return test


def course(size: float, tau_h: float) -> FloatArray:
    """Return where each block stands, shape (blocks, 3)."""
    return np.outer(size * (1 - np.exp(-HOURS / tau_h)), (1.0, 0.0, 0.0))


def scatters(draw: Draw, growth: float) -> Test:
    """Return dRP of blocks of which the last scatters more."""

    def test(rng: np.random.Generator) -> Ends:
        groups = [SIGMA * draw(rng, (3, VISITS)) for _ in range(BLOCKS)]
        groups[-1] *= growth
        found: Estimate = change_of_repeatability(groups, dials(0.0))
        return found.interval

    return test


def steady(draw: Draw, size: float, tau_h: float) -> Test:
    """Return the time until blocks that drift in X are steady."""

    def test(rng: np.random.Generator) -> Ends:
        groups = shown(rng, draw, course(size, tau_h), VISITS, 0.0)
        fit: DriftFit | None = fit_drift(groups, HOURS, dials(0.0))
        return fit.steady_interval_h if fit is not None and fit.steady else None

    return test


def true_rp(draw: Draw, n: int) -> float:
    """Return the mean RP in space of tests of n visits."""
    rng = np.random.default_rng(0)
    return float(repeatability(SIGMA * draw(rng, (20_000, 3, n))).RP.mean())


def cases() -> Iterator[Case]:
    """Yield figure, scatter and size, truth, and what makes the interval of a test."""
    for name, draw in SCATTERS.items():
        for apart in (0.0, 0.5, 5.0):
            said = f"{name}, {apart:g} sigma apart"
            yield "vAP", said, apart * SIGMA, directions(draw, apart * SIGMA)
        for size in (0.0, 1.0, 6.0):
            moved = float(course(size * SIGMA, 0.9)[-1, 0])
            yield "dAP", f"{name}, {size:g} sigma of drift", moved, blocks(draw, size * SIGMA)
        for growth in (1.0, 3.0):
            truth = (growth - 1) * true_rp(draw, VISITS)
            yield "dRP", f"{name}, last block x {growth:g}", truth, scatters(draw, growth)
        for tau in (0.5, 1.5):
            truth = math.log(10) * tau
            yield "steady_after", f"{name}, tau {tau:g} h", truth, steady(draw, 6 * SIGMA, tau)
    gaussian = SCATTERS["Gaussian"]
    for sigmas in (0.3, 1.0):
        division, said = SIGMA / sigmas, f"rounded, sigma {sigmas:g} div."
        yield "vAP", f"{said}, 0 apart", 0.0, directions(gaussian, 0.0, division)
        yield "vAP", f"{said}, 5 sigma", 0.05, directions(gaussian, 0.05, division)
        moved = float(course(0.06, 0.9)[-1, 0])
        yield "dAP", f"{said}, 6 sigma", moved, blocks(gaussian, 0.06, division=division)


def simulate(truth: float, test: Test, seed: int, runs: int) -> list[float]:
    """Return the shares of tests too high, too low, none and holding, and the median width."""
    found = [test(np.random.default_rng([seed, run])) for run in range(runs)]
    ends = [one for one in found if one is not None]
    high = sum(low > truth + 1e-12 for low, _ in ends) / runs
    low = sum(top < truth for _, top in ends) / runs
    none = 1 - len(ends) / runs
    width = float(np.median([top - bottom for bottom, top in ends] or [math.nan]))
    return [high, low, none, 1 - high - low - none, width]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=9283)
    parser.add_argument("--runs", type=int, default=500)
    wanted = parser.parse_args()
    print("| figure | scatter | truth | too high | too low | none | **holds** | width |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    for code, said, truth, test in cases():
        high, low, none, held, width = simulate(truth, test, wanted.seed, wanted.runs)
        shares = f"{high:.1%} | {low:.1%} | {none:.1%} | **{held:.1%}**"
        print(f"| `{code}` | {said} | {truth:.3g} | {shares} | {width:.2g} |", flush=True)


if __name__ == "__main__":
    main()
