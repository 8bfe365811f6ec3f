"""Scatter that is wider, or narrower, from a cycle on while the mean stays."""

import numpy as np
from numpy.random import Generator

from scara_iso.effects._effect import (
    Conditions,
    Effect,
    Parameter,
    Sizes,
    Spread,
)
from scara_iso.run import FloatArray

_LEAST_CYCLES = 5
_RATIOS = (1 / 3, 1 / 1.8, 1.8, 3.0)


def _series(conditions: Conditions, values: Sizes, rng: Generator) -> FloatArray:
    """Return the scatter that is added on the wider side, independent of that of the readings."""
    ratio, after = values["ratio"], conditions.cycle >= values["at_cycle"]
    wider = after if ratio > 1 else ~after
    added = values["scatter"] * np.sqrt(max(ratio, 1 / ratio) ** 2 - 1)
    return np.where(wider, added * rng.normal(size=len(conditions)), 0.0)


def _spreads(conditions: Conditions) -> tuple[Spread, ...]:
    starts = conditions.cycle[_LEAST_CYCLES : len(conditions) - _LEAST_CYCLES + 1 : 2]
    return tuple(Spread(int(k), ratio) for k in starts for ratio in _RATIOS)


EFFECT = Effect(
    name="scatter_change",
    parameters=(
        Parameter("at_cycle", "k", "", "first cycle of the other scatter"),
        Parameter("ratio", "r", "", "scatter from that cycle on, over scatter before it", above=0),
        Parameter("scatter", "σ", "reading", "standard deviation on the narrower side"),
    ),
    cause="something came loose during the test, or settled",
    confirm_by="check the clamps and repeat the run",
    series=_series,
    weight=0.3,
    common=False,
    spreads=_spreads,
)
