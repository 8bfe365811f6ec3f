"""The load coasts through the gap until friction stops it: min(2D, I_L w^2 / (2 T_c)).

Energy balance over the gap: 1/2 I_L w^2 = T_c angle. Only the course over the ``speed`` column is
searched: the square of the speed, saturating once the whole gap is crossed.
"""

import numpy as np

from scara_iso.effects import Conditions, Grid, KnownCourse, Parameter, as_column
from scara_iso.run import FloatArray

_COLUMN = "speed"
_SATURATION = np.arange(6, 21) / 20
"""Speeds tried at which the whole gap is crossed, as a share of the largest one recorded."""

_FEWEST_SPEEDS = 3
"""Two say nothing of where a course saturates."""


def _columns(conditions: Conditions, *, full_at: float) -> FloatArray:
    return as_column(np.minimum(1.0, (conditions.covariates[_COLUMN] / full_at) ** 2))


def _speeds(conditions: Conditions) -> Grid:
    speeds = np.unique(np.abs(conditions.covariates[_COLUMN]))
    shares = _SATURATION if len(speeds) >= _FEWEST_SPEEDS else np.ones(1)
    return Grid.exact(shares * speeds[-1] if speeds[-1] else [])


EFFECT = KnownCourse(
    name="coast_in_gap",
    parameters=(
        Parameter("size", "2D", "reading", "travel across the whole gap, at the tool"),
        Parameter(
            "full_at",
            "w",
            "speed",
            "speed from which the whole gap is crossed",
            above=0,
            grid=_speeds,
        ),
    ),
    cause="the load coasts on through the gap until Coulomb friction stops it",
    confirm_by="run at 10, 50 and 100 % of the speed: the shift must grow with its square until "
    "the whole gap is crossed",
    needs=(_COLUMN,),
    columns=_columns,
)
