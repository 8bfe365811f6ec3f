"""How often a test is called pass, fail or neither against a limit, by simulation.

    python benchmarks/conformity.py [--seed 9283] [--runs 4000]

The true RP is the expected one of 30 cycles. Each cell draws many tests of n cycles from a known
scatter, sets the limit so that the true RP is a given multiple of it, and decides as `analyze`
does; beside it stands simple acceptance. Last, how often tests of the number of cycles that a test
without verdict asks for prove it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np
from coverage import Scatter, draw_tests

from scara_iso import Run, analyze
from scara_iso.repeatability import repeatability
from scara_iso.results import LimitCheck
from scara_iso.run import Axis, FloatArray

SHARES = (1.1, 1.0, 0.9, 0.8, 0.7, 0.6)
EXPECTED = 100_000
SCATTERS = (
    Scatter("Gaussian", lambda rng, shape: rng.standard_normal(shape)),
    Scatter("uniform", lambda rng, shape: rng.uniform(-1, 1, shape)),
    Scatter("Student t, 5", lambda rng, shape: rng.standard_t(5, shape)),
    Scatter("gamma, shape 2", lambda rng, shape: rng.gamma(2, 1, shape)),
    Scatter("lognormal, s 0.5", lambda rng, shape: rng.lognormal(0, 0.5, shape)),
    Scatter("rounded, sigma 1.0 div.", lambda rng, shape: rng.standard_normal(shape), 1.0),
    Scatter("rounded, sigma 0.5 div.", lambda rng, shape: rng.standard_normal(shape), 2.0),
    Scatter("rounded, sigma 0.3 div.", lambda rng, shape: rng.standard_normal(shape), 1 / 0.3),
)
POWER_NAMES = {1: ("X",), 2: ("X", "Y")}


def expected(scatter: Scatter, components: int, rng: np.random.Generator) -> float:
    """Return the mean RP of tests of 30 cycles, without rounding."""
    drawn = scatter.draw(rng, (EXPECTED, components, 30))
    return float(repeatability(drawn).RP.mean())


def decided(tests: FloatArray, scatter: Scatter, limit: float) -> Iterator[LimitCheck]:
    """Yield what `analyze` decides of each test of shape (components, n)."""
    names = POWER_NAMES[tests.shape[1]]
    runs, _, n = tests.shape
    run = Run(
        cycle=np.tile(np.arange(2, n + 2), runs),
        axes={
            name: Axis(name, tests[:, k].ravel(), resolution=scatter.division or 1e-9)
            for k, name in enumerate(names)
        },
        pose=np.repeat([f"T{k}" for k in range(runs)], n),
    )
    figure = "XY" if len(names) == 2 else "X"
    yield from analyze(run, cycles=n + 1, limits={figure: limit}).limits


def shares(checks: list[LimitCheck]) -> tuple[float, float, float]:
    """Return the shares of pass, fail, and inside by simple acceptance."""
    words = [check.verdict.value for check in checks]
    inside = np.mean([check.inside for check in checks])
    return np.mean(np.equal(words, "pass")), np.mean(np.equal(words, "fail")), float(inside)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=9283)
    parser.add_argument("--runs", type=int, default=2000)
    wanted = parser.parse_args()
    for k, scatter in enumerate(SCATTERS):
        for n in (30, 50):
            rng = np.random.default_rng([wanted.seed, k, n])
            true = expected(scatter, 1, rng)
            tests = draw_tests(scatter, rng, (wanted.runs, 1, n))
            cells = []
            for share in SHARES:
                passed, failed, inside = shares(list(decided(tests, scatter, true / share)))
                cells.append(f"{passed:6.1%}/{failed:5.1%}/{inside:6.1%}")
            print(f"{scatter.name:<26}{n:>4} {' '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
