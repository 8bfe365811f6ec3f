"""A sine over the cycles: size sin(2 pi t / P + phase), t in cycles since the first.

Not gear transmission error: at one commanded pose every visit has the same joint angle, so that
error is a constant there.
"""

import numpy as np

from scara_iso.effects import AMPLITUDE_AND_PHASE, Conditions, Grid, KnownCourse, Parameter
from scara_iso.run import FloatArray

_SHORTEST, _LONGEST = 2.3, 0.6
"""Periods tried, in cycles and in the run's length; alternation (2 cycles) belongs to
`contact_side`."""

_FINER = 10


def _columns(conditions: Conditions, *, period: float) -> FloatArray:
    angle = 2 * np.pi * conditions.time / period
    return np.stack([np.sin(angle), np.cos(angle)], axis=1)


def _periods(conditions: Conditions) -> Grid:
    """Return frequencies at half the spacing of the Fourier ones, as likely in period as 1 / P."""
    apart = 1 / (2 * len(conditions))
    frequencies = np.arange(1 / (_LONGEST * len(conditions)), 1 / _SHORTEST, apart)
    periods = (1 / frequencies).tolist()
    steps = apart * np.arange(1 - _FINER, _FINER) / _FINER
    return Grid(periods, weights=periods, near=lambda period: 1 / (1 / period + steps))


EFFECT = KnownCourse(
    name="periodic",
    parameters=(
        Parameter(
            "period",
            "P",
            "cycles",
            "period; in median intervals if time_s is there",
            above=0,
            grid=_periods,
            timed=True,
        ),
        Parameter("size", "A", "reading", "amplitude"),
        Parameter("phase", "φ", "rad", "phase at the first cycle"),
    ),
    cause="air conditioning or a thermostat, a motion cycle longer than one visit, or vibration "
    "aliased by the cycle time",
    confirm_by="change the cycle time: the period in cycles must change, the period in minutes "
    "must not",
    weight=1.3,  # benchmarks/diagnosis.py, table naming
    test_weight=1.3,  # benchmarks/diagnosis.py, table power
    linear=AMPLITUDE_AND_PHASE,
    smooth=True,
    columns=_columns,
)
