"""An approach to steady temperature: size (1 - exp(-t / tau)), t in cycles or from ``time_s``."""

import numpy as np
from numpy.random import Generator

from scara_iso.effects._effect import (
    Conditions,
    Effect,
    Parameter,
    Shape,
    Sizes,
    column,
)
from scara_iso.run import FloatArray

# Time constants to try, in cycles: shorter ones are an outlying first cycle, longer ones a drift.
_TAU = tuple(float(tau) for tau in np.geomspace(1.5, 12.0, 7))


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    return np.asarray(values["size"] * (1 - np.exp(-conditions.time / values["tau"])))


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    return tuple(_shape(conditions, tau) for tau in _TAU)


def _nearby(conditions: Conditions, values: Sizes) -> tuple[Shape, ...]:
    factors = np.geomspace(_TAU[0] / _TAU[1], _TAU[1] / _TAU[0], 9)
    return tuple(_shape(conditions, values["tau"] * float(factor)) for factor in factors)


def _shape(conditions: Conditions, tau: float) -> Shape:
    return Shape(column(1 - np.exp(-conditions.time / tau)), {"tau": tau})


EFFECT = Effect(
    name="warm_up",
    parameters=(
        Parameter("size", "A", "reading", "travel from the first cycle to steady temperature"),
        Parameter(
            "tau", "τ", "cycles", "time constant; in median intervals if time_s is there", above=0
        ),
    ),
    cause="motors, gears and links were still reaching their running temperature",
    confirm_by="run the robot for 60 minutes before the test, then start once more cold: the "
    "course must vanish and return",
    series=_series,
    shapes=_shapes,
    nearby=_nearby,
)
