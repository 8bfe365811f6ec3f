"""How often the 95 % intervals of gauge studies hold the true value.

    python benchmarks/gauge_study.py [--studies 400]

Gaussian scatter; Cg and Cgk of 50 readings, sigma of R&R and its share of ten parts by three
operators three times, for some true sizes of the operators beside a scatter of 1.
"""

from __future__ import annotations

import argparse

import numpy as np

from scara_iso.gauge.crossed import crossed
from scara_iso.gauge.reference_parts import type_1
from scara_iso.gauge.table import GaugeReadings

PARTS, OPERATORS, TRIALS, PART = 10, 3, 3, 5.0
T = 30.0


def type_1_coverage(studies: int, bias: float) -> tuple[float, float]:
    """Return how often the intervals of Cg and Cgk hold."""
    held = np.zeros(2)
    for seed in range(studies):
        rng = np.random.default_rng(seed)
        readings = GaugeReadings("X", rng.normal(bias, 1, 50), "mm", reference=np.zeros(50))
        found = type_1(readings, T, np.random.default_rng(1))
        truth = (0.2 * T / 6, (0.1 * T - abs(bias)) / 3)
        for k, ends in enumerate((found.Cg_interval, found.Cgk_interval)):
            held[k] += ends is not None and ends[0] <= truth[k] <= ends[1]
    return tuple(held / studies)


def crossed_coverage(studies: int, operators: float, both: float) -> tuple[float, float, float]:
    """Return how often the intervals of GRR, of its share of TV and of ndc hold."""
    grr, held = np.sqrt(1 + operators**2 + both**2), np.zeros(3)
    truth = (grr, grr / np.hypot(grr, PART), 1.41 * PART / grr)
    names = [(f"{i}", "ABC"[j]) for i in range(PARTS) for j in range(OPERATORS) for _ in range(3)]
    part, operator = zip(*names, strict=True)
    for seed in range(studies):
        rng = np.random.default_rng(seed)
        cells = rng.normal(0, PART, (PARTS, 1, 1)) + rng.normal(0, operators, (1, OPERATORS, 1))
        cells = cells + rng.normal(0, both, (PARTS, OPERATORS, 1))
        values = (cells + rng.normal(0, 1, (PARTS, OPERATORS, TRIALS))).ravel()
        readings = GaugeReadings("X", values, "mm", part=part, operator=operator)
        found = crossed(readings, T, np.random.default_rng(1))
        whole = found.components["GRR"]
        for k, ends in enumerate((whole.interval, whole.of_study_interval, found.ndc_interval)):
            held[k] += ends is not None and ends[0] <= truth[k] <= ends[1]
    return tuple(held / studies)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=400)
    studies = parser.parse_args().studies
    print(f"type 1, {studies} studies of 50 readings: bias, Cg, Cgk")
    for bias in (0.0, 0.3, 1.0):
        print(f"  {bias:4}  " + "  ".join(f"{one:.1%}" for one in type_1_coverage(studies, bias)))
    print("R&R 10 x 3 x 3: operators, part x operator, GRR, GRR/TV, ndc")
    for operators, both in ((0.0, 0.0), (0.3, 0.0), (1.0, 0.0), (1.0, 1.0), (3.0, 0.3)):
        held = crossed_coverage(studies, operators, both)
        print(f"  {operators:4} {both:4}  " + "  ".join(f"{one:.1%}" for one in held))


if __name__ == "__main__":
    main()
