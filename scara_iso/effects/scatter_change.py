"""Scatter that is wider, or narrower, from a cycle on while the mean stays."""

import numpy as np

from scara_iso.effects import Conditions, Grid, Parameter, ScatterChange
from scara_iso.run import FloatArray

_LEAST_CYCLES = 5


def _scale(conditions: Conditions, *, at_cycle: float, ratio: float) -> FloatArray:
    after = conditions.cycle >= at_cycle
    return np.where(after == (ratio > 1), max(ratio, 1 / ratio), 1.0)


def _starts(conditions: Conditions) -> Grid:
    return Grid.exact(conditions.cycle[_LEAST_CYCLES : len(conditions) - _LEAST_CYCLES + 1 : 2])


EFFECT = ScatterChange(
    name="scatter_change",
    parameters=(
        Parameter("at_cycle", "k", "", "first cycle of the other scatter", grid=_starts),
        Parameter(
            "ratio",
            "r",
            "",
            "scatter from that cycle on, over scatter before it",
            above=0,
            grid=lambda _: Grid.exact([1 / 3, 1 / 1.8, 1.8, 3.0]),
        ),
        Parameter("scatter", "σ", "reading", "standard deviation on the narrower side"),
    ),
    cause="something came loose during the test, or settled",
    confirm_by="check the clamps and repeat the run",
    weight=0.3,  # benchmarks/diagnosis.py, table naming
    test_weight=2.0,  # benchmarks/diagnosis.py, table power
    common=False,
    scale=_scale,
)
