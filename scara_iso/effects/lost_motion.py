"""Lost motion: the reading follows the sign of the approach, half width to either side."""

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

_COLUMN = "approach"


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    return np.asarray(values["size"] * np.sign(conditions.covariates[_COLUMN]))


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    approach = conditions.covariates.get(_COLUMN)
    return () if approach is None else (Shape(column(np.sign(approach))),)


EFFECT = Effect(
    name="lost_motion",
    parameters=(Parameter("size", "h", "reading", "half of the distance between approaches"),),
    cause="backlash and wind-up of a drive, taken up on the other side when the pose is "
    "approached the other way",
    confirm_by="run with one approach only: the difference must vanish",
    series=_series,
    direction=Direction.JOINT,
    shapes=_shapes,
)
