"""Linearity: does the bias stay the same over the dial's range? A line through all readings."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scara_iso.measurement_system.budget import Budget, budget, rectangular, stated_parts
from scara_iso.measurement_system.pivots import CONFIDENCE, drawn_variance, p_of_t
from scara_iso.measurement_system.readings import GaugeReadings
from scara_iso.published import Count, Interval
from scara_iso.run import FloatArray, IntArray

FEWEST = 3


@dataclass(frozen=True, eq=False, slots=True)
class LinearityFigures:
    """The line bias = slope x reference + intercept, in the readings' unit."""

    n: Count
    """Number of readings."""
    references: FloatArray
    """Each true value once, ascending, shape (k,)."""
    biases: FloatArray
    """Mean bias at each, shape (k,)."""
    lower: FloatArray
    """Lower end of the line's 95 % band at each, shape (k,)."""
    upper: FloatArray
    """Upper end."""
    slope: float
    """Change of the bias with the reference."""
    slope_interval: Interval
    """95 %."""
    slope_p_value: float | None
    """Chance of such a slope where there is none; null where the line goes through all."""
    intercept: float
    """Bias at reference 0."""
    intercept_p_value: float | None
    """Chance of such an intercept where there is none."""
    residual: float
    """Standard deviation about the line."""
    explained: float | None
    """R squared; null where no bias differs."""
    largest_bias: float
    """Mean bias farthest from 0."""
    holds_zero: bool
    """Whether no bias lies within the band over the whole range: AIAG's criterion."""


@dataclass(frozen=True, eq=False, slots=True)
class Linearity(LinearityFigures):
    """A study of linearity."""

    budget: Budget
    """The uncertainties by VDA 5."""


def linearity(
    readings: GaugeReadings, tolerance: float | None, rng: np.random.Generator
) -> Linearity:
    """Return the line; `DataError` for fewer than three readings beyond two references.

    AIAG MSA, 4th ed., chapter III B: least squares through the bias of each single reading.
    """
    from scipy.special import stdtrit  # noqa: PLC0415 - scipy for studies only

    x = np.asarray(readings.reference)
    bias, n = readings.values - x, len(x)
    references, at = np.unique(x, return_inverse=True)
    if len(references) < 2 or n < FEWEST + 2:
        raise readings.refuse(
            f"{n} readings of {len(references)} references",
            "read five parts over the range, 12 times",
        )
    centre = x.mean()
    S_xx = float(((x - centre) ** 2).sum())
    slope = float(((x - centre) * (bias - bias.mean())).sum()) / S_xx
    intercept = float(bias.mean() - slope * centre)
    left = bias - slope * x - intercept
    freedom, total = n - 2, float(((bias - bias.mean()) ** 2).sum())
    residual = math.sqrt(float(left @ left) / freedom)
    t = float(stdtrit(freedom, (1 + CONFIDENCE) / 2))
    of_slope = residual / math.sqrt(S_xx)
    half = t * residual * np.sqrt(1 / n + (references - centre) ** 2 / S_xx)
    line = slope * references + intercept
    of_intercept = residual * math.sqrt(1 / n + float(centre) ** 2 / S_xx)
    biases = np.bincount(at, bias) / np.bincount(at)
    return Linearity(
        n=n,
        references=references,
        biases=biases,
        lower=line - half,
        upper=line + half,
        slope=slope,
        slope_interval=(slope - t * of_slope, slope + t * of_slope),
        slope_p_value=p_of_t(slope / of_slope, freedom) if residual > 0 else None,
        intercept=intercept,
        intercept_p_value=p_of_t(intercept / of_intercept, freedom) if residual > 0 else None,
        residual=residual,
        explained=None if total == 0 else 1 - float(left @ left) / total,
        largest_bias=float(biases[np.argmax(np.abs(biases))]),
        holds_zero=bool(np.all(np.abs(line) <= half)),
        budget=_budget(readings, biases, at, tolerance, rng),
    )


def _budget(
    readings: GaugeReadings,
    biases: FloatArray,
    at: IntArray,
    tolerance: float | None,
    rng: np.random.Generator,
) -> Budget:
    """Return the system's budget: the largest bias stands for u_LIN, and is not counted twice."""
    x = np.asarray(readings.reference)
    within = readings.values - x - biases[at]
    freedom = max(len(x) - len(biases), 1)
    variance = float(within @ within) / freedom
    parts = {
        **stated_parts(readings.resolution, readings.uncertainty),
        "EVR": math.sqrt(variance),
        "LIN": rectangular(float(np.abs(biases).max())),
    }
    draws = {"EVR": np.sqrt(drawn_variance(variance, freedom, rng))}
    missing = tuple(name for name in ("CAL", "RE") if name not in parts)
    return budget("MS", parts, draws, tolerance, missing)
