"""Something that comes once and goes again: a bump, or a knock that dies away.

With rise 1 the course is exp(-(t - k)^2 / (2 w^2)); with rise 0 it is 0 before k and
exp(-(t - k) / w) from there on.
"""

from functools import partial

import numpy as np

from scara_iso.effects import Conditions, Grid, KnownCourse, Parameter, as_column
from scara_iso.run import FloatArray

_PEAKS = partial(Grid.cycles, 2)
"""At either end a peak would be a warm-up, or a drift."""

_WIDTHS = partial(Grid.shares, (0.05, 0.1, 0.17))


def _columns(conditions: Conditions, *, at_cycle: float, width: float, rise: float) -> FloatArray:
    since = (conditions.cycle - at_cycle) / width
    if rise:
        return as_column(np.exp(-0.5 * since**2))
    return as_column(np.where(since < 0, 0.0, np.exp(-np.maximum(since, 0.0))))


EFFECT = KnownCourse(
    name="transient",
    parameters=(
        Parameter("at_cycle", "k", "", "cycle of the peak", grid=_PEAKS),
        Parameter("width", "w", "cycles", "how long it lasts", above=0, grid=_WIDTHS),
        Parameter(
            "rise",
            "r",
            "",
            "1: comes and goes; 0: comes at once and dies away",
            grid=lambda _: Grid.exact([1.0, 0.0]),
        ),
        Parameter("size", "A", "reading", "travel at the peak"),
    ),
    cause="something came and went during the test: a door, a draught, a knock at the stand",
    confirm_by="ask what happened at that time, and repeat the run: it must not come back at the "
    "same cycle",
    at_once="look for a door, a draught, a hand on the bench",
    recurs=False,
    weight=0.5,  # benchmarks/diagnosis.py, tables naming and outside
    test_weight=0.8,  # benchmarks/diagnosis.py, table power
    columns=_columns,
)
