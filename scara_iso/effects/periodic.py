"""A sine over the cycles: size sin(2 pi t / P + phase), t in cycles since the first.

Not gear transmission error: at one commanded pose every visit has the same joint angle, so that
error is a constant there.
"""

import math

import numpy as np
from numpy.random import Generator

from scara_iso.effects._effect import (
    Conditions,
    Effect,
    Parameter,
    Shape,
    Sizes,
)
from scara_iso.run import FloatArray

_SHORTEST, _LONGEST = 2.3, 18.0
"""Periods tried, in cycles; alternation (2 cycles) belongs to `contact_side`."""

_FINER = 10


def _series(conditions: Conditions, values: Sizes, _: Generator) -> FloatArray:
    angle = 2 * np.pi * conditions.time / values["period"] + values["phase"]
    return np.asarray(values["size"] * np.sin(angle))


def _shapes(conditions: Conditions) -> tuple[Shape, ...]:
    """Frequencies at half the spacing of the Fourier ones, as likely in period as 1 / P."""
    frequencies = np.arange(1 / _LONGEST, 1 / _SHORTEST, _spacing(conditions))
    return tuple(_shape(conditions.time, float(f)) for f in frequencies)


def _nearby(conditions: Conditions, values: Sizes) -> tuple[Shape, ...]:
    apart = _spacing(conditions) * np.arange(1 - _FINER, _FINER) / _FINER
    return tuple(_shape(conditions.time, 1 / values["period"] + float(d)) for d in apart)


def _spacing(conditions: Conditions) -> float:
    return 1 / (2 * max(len(conditions), 2))


def _shape(time: FloatArray, frequency: float) -> Shape:
    angle = 2 * np.pi * frequency * time
    columns = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    return Shape(columns, {"period": 1 / frequency}, weight=1 / frequency)


def _sizes(coefficients: FloatArray) -> dict[str, float]:
    sine, cosine = float(coefficients[0]), float(coefficients[1])
    return {"size": math.hypot(sine, cosine), "phase": math.atan2(cosine, sine)}


EFFECT = Effect(
    name="periodic",
    parameters=(
        Parameter(
            "period", "P", "cycles", "period; in median intervals if time_s is there", above=0
        ),
        Parameter("size", "A", "reading", "amplitude"),
        Parameter("phase", "φ", "rad", "phase at the first cycle"),
    ),
    cause="air conditioning or a thermostat, a motion cycle longer than one visit, or vibration "
    "aliased by the cycle time",
    confirm_by="change the cycle time: the period in cycles must change, the period in minutes "
    "must not",
    series=_series,
    weight=1.3,
    shapes=_shapes,
    nearby=_nearby,
    sizes=_sizes,
)
