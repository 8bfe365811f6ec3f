"""R&R by average and range, as it was done by hand: for comparison with the ANOVA only.

The mean range of m Gaussian values is d2 sigma; over g subgroups the root of d2^2 + d3^2 / g,
d2*, takes its place (Duncan 1974, appendix D3). AIAG takes d2 for more than 15 subgroups.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from scara_iso.run import FloatArray

_MANY = 15
_REACH, _STEPS = 8.0, 1200
STUDY = 6.0
"""Standard deviations that a study's variation is wide: 99.73 % of Gaussian scatter."""
CATEGORIES = 1.41
"""ndc = 1.41 PV / GRR (AIAG's rounding of the root of 2)."""


@dataclass(frozen=True, slots=True)
class ByRanges:
    """Standard deviations by ranges, in the readings' unit."""

    EV: float
    """Repeatability."""
    AV: float
    """Operators."""
    GRR: float
    """Both together."""
    PV: float
    """Parts."""
    TV: float
    """Total."""
    of_study: float
    """GRR / TV."""
    of_tolerance: float | None
    """6 GRR / T."""
    ndc: int | None
    """Number of distinct categories; null where nothing scatters."""


def by_ranges(cells: FloatArray, tolerance: float | None) -> ByRanges:
    """Return R&R of readings of shape (parts, operators or 1, trials) by average and range."""
    p, o, r = cells.shape
    EV = float(np.ptp(cells, axis=2).mean()) / d2_star(r, p * o)
    AV = 0.0
    if o > 1:
        apart = float(np.ptp(cells.mean(axis=(0, 2)))) / d2_star(o, 1)
        AV = math.sqrt(max(apart**2 - EV**2 / (p * r), 0.0))
    PV = float(np.ptp(cells.mean(axis=(1, 2)))) / d2_star(p, 1)
    GRR = math.hypot(EV, AV)
    TV = math.hypot(GRR, PV)
    return ByRanges(
        EV,
        AV,
        GRR,
        PV,
        TV,
        of_study=GRR / TV if TV > 0 else 0.0,
        of_tolerance=None if tolerance is None else STUDY * GRR / tolerance,
        ndc=whole_categories(CATEGORIES * PV / GRR) if GRR > 0 else None,
    )


def whole_categories(ndc: float) -> int:
    """Return ndc as AIAG states it: cut to a whole number, and at least 1."""
    return max(int(ndc), 1)


@cache
def d2_star(m: int, g: int) -> float:
    """Return what the mean range of ``g`` subgroups of ``m`` is divided by, for sigma."""
    x = np.linspace(-_REACH, _REACH, _STEPS)
    step = float(x[1] - x[0])
    below = np.array([0.5 * math.erfc(-value / math.sqrt(2)) for value in x])
    d2 = float((1 - below**m - (1 - below) ** m).sum()) * step
    if g > _MANY:
        return d2
    low, high = below[:, np.newaxis], below[np.newaxis, :]
    inside = 1 - high**m - (1 - low) ** m + np.maximum(high - low, 0.0) ** m
    squared = 2 * float(np.triu(inside, 1).sum()) * step**2 + float(np.trace(inside)) * step**2
    return math.sqrt(d2**2 + (squared - d2**2) / g)
