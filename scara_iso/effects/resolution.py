"""The dial's own division: readings are rounded to it.

Its share of the variance is known and not searched: resolution^2 / 12 (GUM F.2.2.1).
"""

import numpy as np
from numpy.random import Generator

from scara_iso.effects._effect import Conditions, Effect, Parameter, Sizes
from scara_iso.run import FloatArray


def _series(conditions: Conditions, values: Sizes, rng: Generator) -> FloatArray:
    """Return rounding errors as they are beside scatter wider than a third of a division."""
    half = values["division"] / 2
    return np.asarray(rng.uniform(-half, half, size=len(conditions)))


EFFECT = Effect(
    name="resolution",
    parameters=(
        Parameter("division", "d", "reading", "smallest difference that is shown", above=0),
    ),
    cause="the indicator's division is too coarse for this robot's scatter",
    confirm_by="measure with a finer indicator",
    series=_series,
    common=False,
)
