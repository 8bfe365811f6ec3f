"""A sudden shift: 0 before a cycle, the full size from it on."""

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

_LEAST_CYCLES = 3
"""Fewer cycles on one side of a step are outliers, not a level."""


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    return np.where(conditions.cycle >= values["at_cycle"], values["size"], 0.0)


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    cycles = conditions.cycle
    starts = cycles[_LEAST_CYCLES : len(cycles) - _LEAST_CYCLES + 1]
    return tuple(Shape(column(cycles >= k), {"at_cycle": int(k)}) for k in starts)


EFFECT = Effect(
    name="step",
    parameters=(
        Parameter("at_cycle", "k", "", "first cycle after the shift"),
        Parameter("size", "Δ", "reading", "shift"),
    ),
    cause="fixture or indicator slipped, a collision, a skipped tooth, or a re-zeroed indicator",
    confirm_by="check the clamps of fixture and indicator, then repeat the run: the shift must "
    "not come back at the same cycle",
    series=_series,
    weight=1.4,
    shapes=_shapes,
)
