"""Scatter with a short memory: each deviation keeps a share r of the one before (AR(1))."""

import numpy as np

from scara_iso.effects import Grid, Parameter, RandomCourse
from scara_iso.run import FloatArray


def _filtered(innovations: FloatArray, *, correlation: float) -> FloatArray:
    """Return x_j = r x_(j-1) + sqrt(1 - r^2) e_j, stationary with unit variance."""
    course = np.array(innovations, dtype=np.float64)
    course[1:] *= np.sqrt(1 - correlation**2)
    for j in range(1, len(course)):
        course[j] += correlation * course[j - 1]
    return course


EFFECT = RandomCourse(
    name="autocorrelated",
    parameters=(
        Parameter(
            "correlation",
            "r",
            "",
            "share of a deviation that is left in the next cycle",
            above=0,
            up_to=1,
            grid=lambda _: Grid.exact([0.3, 0.45, 0.6, 0.75, 0.85]),
        ),
        Parameter("size", "σ", "reading", "standard deviation of the course"),
    ),
    cause="readings that are not independent: a slow vibration, a filter in the indicator, a "
    "temperature that wanders",
    confirm_by="wait longer between the cycles: neighbouring deviations must no longer be alike",
    weight=0.25,  # benchmarks/diagnosis.py, tables naming and outside
    test_weight=0.6,  # benchmarks/diagnosis.py, table power
    common=False,
    filtered=_filtered,
    variances=(1.0, 4.0),
)
