"""How often RP of a second test lies in the interval that `diagnose` of the first one predicts.

    python benchmarks/repeat_test.py [--pairs 100] [--seed 9283]

Two tests of 30 cycles with one scatter, one axis, a dial of 0.001 mm and a standard deviation of
five divisions. The interval is to hold in 95 of 100 pairs.
"""

import argparse
import math
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from scara_iso import analyze, diagnose
from scara_iso.run import Axis, Run

SIGMA = 0.005
LAWS = {
    "Gaussian": lambda rng: rng.normal(size=31),
    "Student t, 5": lambda rng: rng.standard_t(5, 31) * math.sqrt(3 / 5),
    "uniform": lambda rng: rng.uniform(-math.sqrt(3), math.sqrt(3), 31),
    "exponential": lambda rng: rng.exponential(size=31),
}


def is_inside(task: tuple[str, int]) -> bool:
    """Return whether RP of the second of two tests lies in the interval of the first."""
    law, seed = task
    rng = np.random.default_rng([seed, list(LAWS).index(law)])
    first, second = (
        Run(np.arange(1, 32), {"X": Axis("X", readings, resolution=0.001)})
        for readings in (np.round(0.5 + SIGMA * LAWS[law](rng), 3) for _ in range(2))
    )
    low, high = diagnose(first).repeatability.completed["X"].interval
    return bool(low <= analyze(second).poses[0].axes["X"].RP <= high)


def main() -> None:
    """Print the share of pairs for each law of scatter, with its standard error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=9283)
    options = parser.parse_args()
    with ProcessPoolExecutor(2) as pool:
        for law in LAWS:
            tasks = [(law, options.seed + k) for k in range(options.pairs)]
            share = sum(pool.map(is_inside, tasks)) / len(tasks)
            error = math.sqrt(share * (1 - share) / len(tasks))
            print(f"{law:14s}{share:7.1%} +/- {error:.1%}", flush=True)


if __name__ == "__main__":
    main()
