"""A bend: nothing before a cycle, then a drift at constant rate."""

import numpy as np

from scara_iso.effects import Conditions, Grid, KnownCourse, Parameter, as_column
from scara_iso.run import FloatArray

_LEAST_CYCLES = 4
"""Fewer cycles on one side of a bend are a drift, or nothing."""


def _columns(conditions: Conditions, *, at_cycle: float) -> FloatArray:
    return as_column(np.maximum(conditions.cycle - at_cycle, 0.0))


def _bends(conditions: Conditions) -> Grid:
    inner = conditions.cycle[_LEAST_CYCLES - 1 : len(conditions) - _LEAST_CYCLES]
    return Grid.exact(inner[:: max(1, round(len(conditions) / 25))])


EFFECT = KnownCourse(
    name="onset",
    parameters=(
        Parameter("at_cycle", "k", "", "last cycle before the drift", grid=_bends),
        Parameter("size", "b", "reading/cycle", "drift per cycle after it"),
    ),
    cause="something began to warm or to creep during the test: a heater or a machine switched on, "
    "a clamp that started to give",
    confirm_by="ask what was switched on or loaded at that time, and repeat the run without it",
    at_once="look for what was switched on, and for a clamp that gives way",
    weight=0.15,  # benchmarks/diagnosis.py, table naming
    test_weight=0.5,  # benchmarks/diagnosis.py, table power
    smooth=True,
    columns=_columns,
)
