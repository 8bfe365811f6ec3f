"""Something begins in mid-run and settles: 0 before cycle k, then 1 - exp(-(t - k + 1) / tau).

t is the number of the cycle.
"""

from functools import partial

import numpy as np

from scara_iso.effects import Conditions, Grid, KnownCourse, Parameter, as_column
from scara_iso.run import FloatArray

_BEGINS = partial(Grid.cycles, 4)
"""Fewer cycles before it are a warm-up; fewer after it a step."""

_TAUS = partial(Grid.shares, (0.05, 0.09, 0.16))


def _columns(conditions: Conditions, *, at_cycle: float, tau: float) -> FloatArray:
    since = conditions.cycle - at_cycle + 1.0
    return as_column(1 - np.exp(-np.maximum(since, 0.0) / tau))


EFFECT = KnownCourse(
    name="settles",
    parameters=(
        Parameter("at_cycle", "k", "", "first cycle that it moves", grid=_BEGINS),
        Parameter("tau", "τ", "cycles", "time constant", above=0, grid=_TAUS),
        Parameter("size", "A", "reading", "travel to the new level"),
    ),
    cause="something changed during the test and settled: a heater or a machine switched on, a "
    "clamp or a stand that slipped and crept on",
    confirm_by="ask what was switched on, moved or loaded at that time, and repeat the run: it "
    "must not come back at the same cycle",
    at_once="look for what was switched on, and for a clamp that gives way",
    weight=0.15,  # that of an onset (benchmarks/ablation.py)
    test_weight=0.5,
    smooth=True,
    columns=_columns,
)
