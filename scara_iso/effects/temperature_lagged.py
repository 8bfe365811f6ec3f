"""Thermal growth behind a thermometer: in proportion to a recorded temperature, delayed.

The machine follows the thermometer as one body or as two, one behind the other, each with time
constant tau: dx/dt = (T - x) / tau, from x = T at the first cycle.
"""

import numpy as np

from scara_iso.effects import Conditions, Grid, KnownCourse, Parameter, as_column
from scara_iso.run import FloatArray

_SHORTEST, _LONGEST = 0.06, 0.6
"""Lags tried, of the run; a shorter one is `temperature`."""


def _columns(conditions: Conditions, *, column: str, tau: float, bodies: float) -> FloatArray:
    course = conditions.covariates[column]
    kept = np.exp(-np.diff(conditions.time) / tau)
    for _ in range(round(bodies)):
        course = _followed(course, kept)
    return as_column(course - course.mean())


def _followed(course: FloatArray, kept: FloatArray) -> FloatArray:
    """Return a body's temperature behind ``course`` (n,), taken as linear between cycles."""
    follows = np.array(course, dtype=np.float64)
    for j, share in enumerate(kept, start=1):
        around = (course[j] + course[j - 1]) / 2
        follows[j] = around + (follows[j - 1] - around) * share
    return follows


def _tau(conditions: Conditions) -> Grid:
    n = len(conditions)
    return Grid.geometric(max(1.2, _SHORTEST * n), _LONGEST * n, 5)


EFFECT = KnownCourse(
    name="temperature_lagged",
    parameters=(
        Parameter(
            "column",
            "T",
            "",
            "the recorded temperature",
            text=True,
            grid=lambda conditions: Grid(conditions.named("temperature*")),
        ),
        Parameter(
            "tau",
            "τ",
            "cycles",
            "lag; in median intervals if time_s is there",
            above=0,
            grid=_tau,
            timed=True,
        ),
        Parameter(
            "bodies",
            "m",
            "",
            "bodies that lag, one behind the other",
            above=0,
            grid=lambda _: Grid.exact([1.0, 2.0]),
        ),
        Parameter("size", "α", "reading/°C", "change per degree of the lagging temperature"),
    ),
    needs=("temperature*",),
    cause="thermal growth of links, base, fixture or stand, which follow the thermometer late",
    confirm_by="change the temperature and hold it: the reading must still move, with this lag",
    weight=1.0,  # benchmarks/diagnosis.py, table gains
    smooth=True,
    columns=_columns,
)
