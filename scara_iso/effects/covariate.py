"""Whatever else was recorded beside the readings: in proportion to that column."""

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

_CLAIMED = ("approach", "payload_kg", "speed", "time_s")
"""Columns of other effects, besides every ``temperature...``."""


def _recorded(conditions: Conditions) -> dict[str, FloatArray]:
    return {
        name: values
        for name, values in conditions.covariates.items()
        if name not in _CLAIMED and not name.lower().startswith("temperature")
    }


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    recorded = next(iter(_recorded(conditions).values()))
    return np.asarray(values["size"] * (recorded - recorded.mean()))


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    return tuple(
        Shape(column(values), {"column": name}) for name, values in _recorded(conditions).items()
    )


EFFECT = Effect(
    name="covariate",
    parameters=(
        Parameter("column", "z", "", "the recorded quantity"),
        Parameter("size", "c", "reading/unit", "change per unit of the recorded quantity"),
    ),
    cause="whatever this column records acts on the pose, or shares a cause with it",
    confirm_by="hold the quantity constant, then change it on purpose, in random order",
    series=_series,
    shapes=_shapes,
)
