"""The readings move with the cycle number.

RP counts a drift or a step during the test as scatter too. Found by the Mann-Kendall test (Kendall
1975, with ties), at 1 % over all axes and poses (Holm 1979). The 95 % interval of RP assumes
independent cycles, so it does not hold here. `diagnose` traces the shift to a cause.
"""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from scara_iso.iso9283.core.results import Finding, Findings, Measured, each_axis, poses_in_cycles
from scara_iso.run import FloatArray, IntArray

CODE = "trend"
BRIEF = "moved, its interval is void"
TREND_LEVEL = 0.01
_MOST_CYCLES = 2000  # every k-th of more: the test compares all pairs
_ADVICE = "run diagnose to find its cause"


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis with a monotonic trend."""
    tested = [
        (mann_kendall(axis.readings[:: math.ceil(axis.n / _MOST_CYCLES)]), pose, axis)
        for pose, axis in each_axis(poses_in_cycles(measured))
    ]
    every = len(measured.poses) * len(measured.run.axes)
    found = holm([p for p, *_ in tested], TREND_LEVEL, every)
    for (p, pose, axis), moves in zip(tested, found, strict=True):
        if moves:
            what = (
                f"the readings move during the test (Mann-Kendall p = {p:.1g}): RP "
                "counts a shift as scatter"
            )
            where = (axis.name, pose.label)
            also = (name for name in pose.figures if name != axis.name and axis.name in name)
            brief = next((f"{name} too" for name in also), "")
            yield Finding(
                CODE, "warning", what, *where, voids_interval=True, advice=_ADVICE, in_short=brief
            )


def holm(p_values: Sequence[float], level: float, tests: int) -> list[bool]:
    """Return what is found at a level that all ``tests`` share, step by step (Holm 1979)."""
    ordered = sorted(p_values)
    steps = enumerate(ordered)
    first_not = next((k for k, p in steps if p >= level / (tests - k)), len(ordered))
    return [p in ordered[:first_not] for p in p_values]


def mann_kendall(readings: FloatArray) -> float:
    """Return the two-sided p-value of the Mann-Kendall test, ties and continuity corrected.

    ``readings`` in the order of the cycles, shape (n,); normal approximation, good from n = 10.
    """
    n = len(readings)
    ranks = np.unique(readings, return_inverse=True)[1]
    earlier, later = _pairs(n)
    S = np.sign(ranks[later] - ranks[earlier]).sum()
    ties = np.bincount(ranks)
    variance = (n * (n - 1) * (2 * n + 5) - (ties * (ties - 1) * (2 * ties + 5)).sum()) / 18
    if variance <= 0:
        return 1.0
    return math.erfc(max(abs(int(S)) - 1, 0) / math.sqrt(2 * variance))


@cache
def _pairs(n: int) -> tuple[IntArray, IntArray]:
    return np.triu_indices(n, 1)
