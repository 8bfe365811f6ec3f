"""A single reading that stands apart from all others."""

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


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    return np.where(conditions.cycle == values["at_cycle"], values["size"], 0.0)


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    return tuple(
        Shape(column(conditions.cycle == k), {"at_cycle": int(k)}) for k in conditions.cycle
    )


EFFECT = Effect(
    name="outlier",
    parameters=(
        Parameter("at_cycle", "k", "", "the cycle"),
        Parameter("size", "e", "reading", "distance from the others"),
    ),
    cause="a misread or mistyped digit, a bumped table, or a damaged frame on the serial line",
    confirm_by="look at the sheet or the raw capture of that cycle",
    series=_series,
    shapes=_shapes,
    ordered=False,
    recurs=False,
    gain=60.0,
)
