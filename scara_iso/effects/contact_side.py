"""Two levels: the load comes to rest on either flank of the gap.

The side may alternate, stay for some cycles (sticky), or be drawn anew each time; a two-state
Markov chain holds all three.
"""

import numpy as np
from numpy.random import Generator

from scara_iso.effects._effect import (
    Chain,
    Conditions,
    Direction,
    Effect,
    Parameter,
    Shape,
    Sizes,
    column,
)
from scara_iso.run import FloatArray

_STICKY = (0.1, 0.16, 0.24)
_SHARE_BELOW = (0.3, 0.4, 0.5, 0.6, 0.7)


def _series(conditions: Conditions, values: Sizes, rng: Generator) -> FloatArray:
    if values["switching"] == 1:
        return np.asarray(values["size"] * (conditions.cycle % 2), dtype=np.float64)
    switches = rng.random(len(conditions)) < values["switching"]
    switches[0] = rng.random() < 0.5
    return np.asarray(values["size"] * (np.cumsum(switches) % 2), dtype=np.float64)


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    """Alternation, the one order of sides that is known beforehand."""
    return (Shape(column(conditions.cycle % 2), {"switching": 1.0}),)


EFFECT = Effect(
    name="contact_side",
    parameters=(
        Parameter("size", "s", "reading", "distance of the two levels"),
        Parameter(
            "switching",
            "q",
            "",
            "probability that the side changes from cycle to cycle; 1: upper level in odd cycles",
            above=0,
            up_to=1,
        ),
    ),
    cause="the load comes to rest on either flank of a gear's gap (backlash)",
    confirm_by="preload the joint, or approach the pose from one side only: one level must remain",
    series=_series,
    direction=Direction.JOINT,
    weight=3.3,
    shapes=_shapes,
    chains=(
        *(Chain(q, q, 1.3 / len(_STICKY)) for q in _STICKY),
        *(Chain(1 - below, below, 1 / len(_SHARE_BELOW)) for below in _SHARE_BELOW),
    ),
)
