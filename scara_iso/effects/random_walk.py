"""A random walk: the sum of independent steps, one for each cycle."""

import numpy as np

from scara_iso.effects import Parameter, RandomCourse
from scara_iso.run import FloatArray


def _filtered(steps: FloatArray) -> FloatArray:
    return np.cumsum(steps, axis=0)


EFFECT = RandomCourse(
    name="random_walk",
    parameters=(Parameter("size", "w", "reading", "standard deviation of one step"),),
    cause="a loose part that settles anew each cycle, a stepper losing counts, or slow wandering",
    confirm_by="log the encoders: if only the tool wanders, look for a loose part behind them",
    weight=0.6,  # benchmarks/ablation.py, listed kinds: walks named, no sure wrong name more
    test_weight=0.3,  # benchmarks/diagnosis.py, table power
    filtered=_filtered,
    variances=(0.03, 0.1, 0.3, 1.0),
)
