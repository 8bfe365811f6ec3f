"""An approach to steady temperature: size (1 - exp(-t / tau)), t in cycles or from ``time_s``."""

import numpy as np

from scara_iso.effects import Conditions, Grid, KnownCourse, Parameter, as_column, linear_drift
from scara_iso.run import FloatArray


def _columns(conditions: Conditions, *, tau: float) -> FloatArray:
    return as_column(1 - np.exp(-conditions.time / tau))


_SHORTEST, _LONGEST = 1.5, 0.4
"""Time constants tried, in cycles and in the run's length: shorter ones are an outlying first
cycle, longer ones hardly told from a drift."""

_RATIO = 1.414
"""Between one that is tried and the next."""

_BEYOND, _RARE = 3, 0.1
"""So many longer ones are tried too, and weighed so: the course of a machine that heats up for
longer than its test is no straight line where it is large (real readings)."""


def _tau(conditions: Conditions) -> Grid:
    longest = max(_LONGEST * len(conditions), 2 * _SHORTEST)
    count = 1 + round(np.log(longest / _SHORTEST) / np.log(_RATIO))
    grid = Grid.geometric(_SHORTEST, longest, count)
    beyond = [longest * _RATIO**k for k in range(1, _BEYOND + 1)]
    return Grid([*grid.values, *beyond], [1.0] * count + [_RARE] * _BEYOND, grid.near)


EFFECT = KnownCourse(
    name="warm_up",
    parameters=(
        Parameter("size", "A", "reading", "travel from the first cycle to steady temperature"),
        Parameter(
            "tau",
            "τ",
            "cycles",
            "time constant; in median intervals if time_s is there",
            above=0,
            grid=_tau,
            timed=True,
        ),
    ),
    cause="motors, gears and links were still reaching their running temperature, or a clamp or "
    "stand crept to rest",
    confirm_by="run the robot for 60 minutes before the test: warm-up must be gone, and back after "
    "a cold start; creep is back after dials are clamped anew",
    at_once="let the robot run warm",
    test_weight=1.3,  # benchmarks/diagnosis.py, table power
    unsettled={
        linear_drift.EFFECT.name: "tau: the run is too short to tell a warm-up from a drift; run "
        "longer"
    },
    smooth=True,
    columns=_columns,
)
