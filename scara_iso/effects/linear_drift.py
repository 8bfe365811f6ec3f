"""A drift at constant rate: size per cycle times the cycles since the first."""

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
    return values["size"] * conditions.elapsed


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    return (Shape(column(conditions.elapsed)),)


EFFECT = Effect(
    name="linear_drift",
    parameters=(Parameter("size", "b", "reading/cycle", "drift per cycle"),),
    cause="a slow thermal trend, or creep of fixture, indicator stand or belt",
    confirm_by="repeat the run after a warm-up: thermal drift has gone, creep has slowed; compare "
    "the slope of a second run",
    series=_series,
    shapes=_shapes,
)
