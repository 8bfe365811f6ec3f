"""How the shares of the level are spent: what is found of listed and of unlisted structure.

    python benchmarks/shares.py [--runs 200]

For each choice of UNKNOWN_SHARE and of the three shares of the tests (order, two levels, odd
reading; they add up to 1.3 in each) the same tables are searched, of 30 cycles and a scatter of
four divisions: listed effects near the edge of what can be found, courses that no hypothesis
contains, odd readings, and scatter alone. Counts of the runs in which something was found.
"""

import argparse
import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from scara_iso.diagnosis import search
from scara_iso.diagnosis.search import problem_of
from scara_iso.diagnosis.significance import permutation
from scara_iso.effects import find_effects
from scara_iso.run import Axis, Run

J = np.arange(30)
CHIRP = np.sin(2 * np.pi * np.cumsum(1 / np.linspace(12, 3, 30)))
DAMPED = np.exp(-J / 12) * np.cos(2 * np.pi * J / 6)
VEE = 2 * np.abs(J - 15) / 15 - 1
CHOICES = (
    (0.3, 0.85, 0.2, 0.25),
    (0.15, 0.95, 0.2, 0.15),
    (0.05, 0.95, 0.2, 0.15),
)


def course(size, of):
    """Return a table's maker: scatter of 1 beside a course."""
    return lambda rng: rng.normal(size=(30, 1)) + size * np.asarray(of)[:, np.newaxis]


def odd(count, axes):
    """Return the maker of tables with some readings 8 to 15 scatters off on one axis."""

    def table(rng):
        values = rng.normal(size=(30, axes))
        rows = rng.choice(30, count, replace=False)
        values[rows, 0] += rng.choice([-1, 1], count) * rng.uniform(8, 15, count)
        return values

    return table


def walk(rng):
    """Return scatter beside a random walk."""
    return rng.normal(size=(30, 1)) + 0.45 * np.cumsum(rng.normal(size=(30, 1)), axis=0)


def widens(rng):
    """Return scatter that is three times as wide in the second half."""
    return rng.normal(size=(30, 1)) * np.where(J < 15, 1, 3)[:, np.newaxis]


TABLES = {
    "drift 2": course(2, J / 29), "step 1.5": course(1.5, J >= 15), "walk": walk,
    "scatter x 3": widens, "chirp 1.9": course(1.9, CHIRP), "chirp 3.5": course(3.5, CHIRP),
    "damped 3.5": course(3.5, DAMPED), "vee 1.2": course(1.2, VEE), "one odd": odd(1, 1),
    "two odd": odd(2, 1), "one odd of 3 axes": odd(1, 3),
    "gaussian": lambda rng: rng.normal(size=(30, 2)), "t5": lambda rng: rng.standard_t(5, (30, 2)),
    "laplace": lambda rng: rng.laplace(size=(30, 2)),
    "gamma 4": lambda rng: (rng.gamma(4, size=(30, 2)) - 4) / 2,
}  # fmt: skip


def found(values):
    """Return whether anything is found in readings on a dial."""
    axes = {
        name: Axis(name, np.round(4 * values[:, k]) / 1000, resolution=0.001)
        for k, name in enumerate("XYZ"[: values.shape[1]])
    }
    problem = problem_of(Run(J + 2, axes), directions={}, effects=find_effects())
    return search.find(problem, np.random.default_rng(1))[1][0].choice is not None


def main():
    """Print the counts of every choice."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=200)
    runs = parser.parse_args().runs
    names = [" / ".join(f"{share:g}" for share in choice) for choice in CHOICES]
    print(f"| tables | {' | '.join(names)} |\n|---{'|---' * len(names)}|")
    counts = []
    for choice in CHOICES:
        permutation.UNKNOWN_SHARE, search.ORDER_SHARE = choice[:2]
        search.TWO_LEVELS_SHARE, search.OUTLIER_SHARE = choice[2:]
        counts.append([
            sum(found(table(np.random.default_rng(9000 + seed))) for seed in range(runs))
            for table in TABLES.values()
        ])  # fmt: skip
    for name, *row in zip(TABLES, *counts, strict=True):
        print(f"| {name} | " + " | ".join(map(str, row)) + " |")


if __name__ == "__main__":
    main()
