"""The load coasts through the gap until friction stops it: min(2D, I_L w^2 / (2 T_c)).

Energy balance over the gap: 1/2 I_L w^2 = T_c angle. Only the course over the ``speed`` column is
searched: the square of the speed, saturating once the whole gap is crossed.
"""

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

_COLUMN = "speed"
_SATURATION = tuple(share / 20 for share in range(6, 21))
"""Speeds tried at which the whole gap is crossed, as a share of the largest one recorded."""


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    return values["size"] * _course(conditions.covariates[_COLUMN], values["full_at"])


def _course(speed: FloatArray, full_at: float) -> FloatArray:
    return np.asarray(np.minimum(1.0, (speed / full_at) ** 2))


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    speed = conditions.covariates.get(_COLUMN)
    if speed is None or not np.any(speed):
        return ()
    top = float(np.abs(speed).max())
    full = [share * top for share in _SATURATION if np.ptp(_course(speed, share * top)) > 0]
    return tuple(Shape(column(_course(speed, f)), {"full_at": f}) for f in full)


EFFECT = Effect(
    name="coast_in_gap",
    parameters=(
        Parameter("size", "2D", "reading", "travel across the whole gap, at the tool"),
        Parameter("full_at", "w", "speed", "speed from which the whole gap is crossed", above=0),
    ),
    cause="the load coasts on through the gap until Coulomb friction stops it",
    confirm_by="run at 10, 50 and 100 % of the speed: the shift must grow with its square until "
    "the whole gap is crossed",
    series=_series,
    direction=Direction.JOINT,
    shapes=_shapes,
)
