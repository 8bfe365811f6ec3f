"""Thermal growth: in proportion to a recorded temperature, centred on its mean."""

import numpy as np
from numpy.random import Generator

from scara_iso.effects._effect import (
    Conditions,
    Direction,
    Effect,
    Parameter,
    Shape,
    Sizes,
    column,
)
from scara_iso.run import FloatArray

_PREFIX = "temperature"


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    name = next(name for name in conditions.covariates if name.lower().startswith(_PREFIX))
    recorded = conditions.covariates[name]
    return np.asarray(values["size"] * (recorded - recorded.mean()))


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    return tuple(
        Shape(column(values), {"column": name})
        for name, values in conditions.covariates.items()
        if name.lower().startswith(_PREFIX)
    )


EFFECT = Effect(
    name="temperature",
    parameters=(
        Parameter("column", "T", "", "the recorded temperature"),
        Parameter("size", "α", "reading/°C", "change per degree"),
    ),
    cause="thermal growth of links, base, fixture or indicator stand",
    confirm_by="hold the temperature constant, or heat one part on purpose: the reading must "
    "follow with the same coefficient",
    series=_series,
    direction=Direction.ARM,
    shapes=_shapes,
)
