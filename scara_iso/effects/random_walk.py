"""A random walk: the sum of independent steps, one for each cycle."""

import numpy as np
from numpy.random import Generator

from scara_iso.effects._effect import (
    Conditions,
    Effect,
    Parameter,
    Process,
    Sizes,
)
from scara_iso.run import FloatArray

_STEP_VARIANCES = (0.03, 0.1, 0.3, 1.0)
"""Variances of one step tried, in units of the scatter's variance."""


def _series(conditions: Conditions, values: Sizes, rng: Generator) -> FloatArray:
    return np.asarray(values["size"] * np.cumsum(rng.normal(size=len(conditions))))


def _processes(conditions: Conditions) -> tuple[Process, ...]:
    since = conditions.elapsed + 1
    together = np.minimum(since[:, np.newaxis], since)
    return tuple(Process(variance * together, variance**0.5) for variance in _STEP_VARIANCES)


EFFECT = Effect(
    name="random_walk",
    parameters=(Parameter("size", "w", "reading", "standard deviation of one step"),),
    cause="a loose part that settles anew each cycle, a stepper losing counts, or slow wandering",
    confirm_by="log the encoders: does the commanded joint angle wander, or only the tool?",
    series=_series,
    weight=0.3,
    processes=_processes,
)
