"""How often a test is called pass, fail or neither against a limit, by simulation.

    python benchmarks/conformity.py [--seed 9283] [--runs 4000] [--only exponential]

The true RP is the expected one of 30 cycles. Each cell draws many tests of n cycles from a known
scatter, sets the limit so that the true RP is a given multiple of it, and decides as `analyze`
does; beside it stands simple acceptance. XY is the radial figure. Last, how often tests of the
number of cycles that a test without verdict asks for prove it.
"""

from __future__ import annotations

import argparse

import numpy as np
from coverage import Scatter, draw_tests

from scara_iso import Run, analyze
from scara_iso.iso9283.core.figures import Conformity
from scara_iso.iso9283.core.results import LimitCheck
from scara_iso.iso9283.core.statistics import repeatability
from scara_iso.run import Axis, FloatArray

SHARES = (1.1, 1.0, 0.9, 0.8, 0.7, 0.6)
EXPECTED = 20_000
NEAR = 0.03
LONGEST = 5000
FIGURES = {"X": 1, "XY": 2}
SCATTERS = (
    Scatter("Gaussian", lambda rng, shape: rng.standard_normal(shape)),
    Scatter("uniform", lambda rng, shape: rng.uniform(-1, 1, shape)),
    Scatter("Student t, 5", lambda rng, shape: rng.standard_t(5, shape)),
    Scatter("gamma, shape 2", lambda rng, shape: rng.gamma(2, 1, shape)),
    Scatter("exponential", lambda rng, shape: rng.exponential(1, shape)),
    Scatter("lognormal, s 0.5", lambda rng, shape: rng.lognormal(0, 0.5, shape)),
    Scatter("rounded, sigma 1.0 div.", lambda rng, shape: rng.standard_normal(shape), 1.0),
    Scatter("rounded, sigma 0.5 div.", lambda rng, shape: rng.standard_normal(shape), 2.0),
    Scatter("rounded, sigma 0.3 div.", lambda rng, shape: rng.standard_normal(shape), 1 / 0.3),
)


def expected(scatter: Scatter, figure: str, rng: np.random.Generator) -> float:
    """Return the mean of the figure over tests of 30 cycles, without rounding."""
    drawn = scatter.draw(rng, (EXPECTED, FIGURES[figure], 30))
    return float(repeatability(drawn).RP.mean())


def decided(tests: FloatArray, scatter: Scatter, figure: str, limit: float) -> list[LimitCheck]:
    """Return what `analyze` decides of each test; ``tests`` of shape (runs, components, n)."""
    runs, components, n = tests.shape
    axes = [Axis(name, tests[:, k].ravel(), resolution=scatter.division or 1e-9)
            for k, name in enumerate("XY"[:components])]  # fmt: skip
    run = Run(
        cycle=np.tile(np.arange(2, n + 2), runs),
        axes={axis.name: axis for axis in axes},
        pose=np.repeat([f"T{k}" for k in range(runs)], n),
    )
    return list(analyze(run, cycles=n + 1, limits={figure: limit}).limits)


def shares(checks: list[LimitCheck]) -> str:
    """Return the shares of pass, fail, and inside by simple acceptance."""
    words = [check.verdict.value for check in checks]
    said = (np.equal(words, "pass"), np.equal(words, "fail"), [check.inside for check in checks])
    return "/".join(f"{100 * np.mean(one):5.1f}" for one in said)


def cycles_wanted(scatter: Scatter, share: float, runs: int, rng: np.random.Generator) -> str:
    """Return the cycles that tests of 30 ask for whose RP is the true one, and what they prove."""
    true = expected(scatter, "X", rng)
    tests = draw_tests(scatter, rng, (runs, 1, 30))
    near = [check for check in decided(tests, scatter, "X", true / share)
            if abs(check.RP / true - 1) < NEAR and check.cycles_wanted is not None]  # fmt: skip
    if not near:
        return "decided"
    n = int(np.median([check.cycles_wanted for check in near if check.cycles_wanted]))
    if n > LONGEST:
        return f"{n} not tried"
    again = decided(draw_tests(scatter, rng, (400, 1, n)), scatter, "X", true / share)
    proven = np.mean([check.verdict is not Conformity.NOT_PROVABLE for check in again])
    return f"{n} prove {100 * proven:.0f}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=9283)
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--only", help="this scatter")
    wanted = parser.parse_args()
    for k, scatter in enumerate(SCATTERS):
        if wanted.only not in {None, scatter.name}:
            continue
        for n in (30, 50):
            for figure, components in FIGURES.items():
                rng = np.random.default_rng([wanted.seed, k, n, components])
                true = expected(scatter, figure, rng)
                tests = draw_tests(scatter, rng, (wanted.runs, components, n))
                cells = [shares(decided(tests, scatter, figure, true / s)) for s in SHARES]
                print(f"{scatter.name:<26}{n:>4} {figure:<3} {'  '.join(cells)}", flush=True)
        rng = np.random.default_rng([wanted.seed, k])
        asked = [cycles_wanted(scatter, s, wanted.runs, rng) for s in (1.3, 0.9, 0.8, 0.7)]
        print(f"{scatter.name:<26} cycles wanted: {', '.join(asked)}", flush=True)


if __name__ == "__main__":
    main()
