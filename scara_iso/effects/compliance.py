"""Deflection in proportion to the payload. Gravity loads Z of a SCARA, not X and Y."""

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

_COLUMN = "payload_kg"


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    payload = conditions.covariates[_COLUMN]
    return np.asarray(values["size"] * (payload - payload.mean()))


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    payload = conditions.covariates.get(_COLUMN)
    return () if payload is None else (Shape(column(payload)),)


EFFECT = Effect(
    name="compliance",
    parameters=(Parameter("size", "c", "reading/kg", "deflection per kilogram"),),
    cause="joints, links and bearings yield under the payload; expected in Z, where gravity acts",
    confirm_by="a static load test: hang known weights at the tool and read the deflection",
    series=_series,
    shapes=_shapes,
)
