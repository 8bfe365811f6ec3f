"""How often a dial is said to be coarser than stated, where it is and where it is not.

    python benchmarks/coarse_dial.py [--tables 20000]

Normal scatter about a random place, without and with a shift of it, rounded to the dial's steps,
which are shown in divisions of 0.001 mm: the resolution that is stated. Printed is the share of
tables with `doubtful-resolution`, by the scatter in steps.
"""

from __future__ import annotations

import argparse
from types import SimpleNamespace

import numpy as np

import scara_iso
from scara_iso.iso9283.checks import doubtful_resolution

DIVISION = 0.001
SCATTERS = (0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0)
"""In steps of the dial."""
READINGS = (10, 15, 30, 60)
STEPS = (1.0, 2.0, 5.0, 12.7, 25.4)
"""In divisions: 12.7 is 0.0005 inch."""
SHIFTS = (0, 20)
"""Most steps by which the arm moves at a random cycle."""


def said(rng: np.random.Generator, count: int, scatter: float, step: float, shift: int) -> bool:
    """Return whether one table has the finding."""
    place = rng.uniform() + rng.uniform(0, shift) * (np.arange(count) >= rng.integers(1, count))
    shown = np.rint(np.rint(rng.normal(place, scatter)) * step) * DIVISION
    axis = scara_iso.Axis("X", shown.round(6), resolution=DIVISION)
    run = scara_iso.Run(np.arange(1, count + 1), {"X": axis})
    return any(doubtful_resolution.check(SimpleNamespace(run=run)))


def main() -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=int, default=20_000, help="of each kind")
    tables = parser.parse_args().tables
    rng = np.random.default_rng(1)
    print("step  shift  readings  " + "".join(f"{scatter:>9g}" for scatter in SCATTERS))
    kinds = [(1.0, SHIFTS[1]), *((step, SHIFTS[0]) for step in STEPS)]
    for step, shift in kinds:
        many = tables if step == 1 else max(tables // 20, 1)
        for n in READINGS:
            shares = [
                np.mean([said(rng, n, s, step, shift) for _ in range(many)]) for s in SCATTERS
            ]
            row = "".join(f"{share:9.3%}" for share in shares)
            print(f"{step:4g}  {shift:5}  {n:8}  {row}", flush=True)


if __name__ == "__main__":
    main()
