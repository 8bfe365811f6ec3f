"""Type 1: one part of known size read again and again. Cg, Cgk, the bias and its t-test."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scara_iso.measurement_system.budget import Budget, budget, rectangular, stated_parts
from scara_iso.measurement_system.pivots import (
    between,
    drawn_mean,
    drawn_variance,
    interval_of_mean,
    interval_of_s,
    p_of_t,
)
from scara_iso.measurement_system.readings import GaugeReadings
from scara_iso.published import Count, Interval

FEWEST = 5
SHARE = 0.2
"""Share of the tolerance that six standard deviations may take: Cg = 0.2 T / (6 s)."""


@dataclass(frozen=True, slots=True)
class TypeOneFigures:
    """Figures of a type 1 study, in the readings' unit; null where something is not stated."""

    n: Count
    """Number of readings."""
    mean: float
    """Of the readings."""
    s: float
    """Their standard deviation, n - 1."""
    s_interval: Interval
    """95 %."""
    reference: float | None
    """True value of the part."""
    bias: float | None
    """Mean less reference."""
    bias_interval: Interval | None
    """95 %."""
    t: float | None
    """Bias over its standard error."""
    p_value: float | None
    """Chance of such a bias where there is none; null where all readings are alike."""
    Cg: float | None
    """0.2 T / (6 s): a fifth of the tolerance over the scatter."""
    Cg_interval: Interval | None
    """95 %."""
    Cgk: float | None
    """(0.1 T - |bias|) / (3 s): the same with the bias."""
    Cgk_interval: Interval | None
    """95 %."""


@dataclass(frozen=True, slots=True)
class TypeOne(TypeOneFigures):
    """A type 1 study."""

    budget: Budget
    """The uncertainties by VDA 5."""


def type_1(readings: GaugeReadings, tolerance: float | None, rng: np.random.Generator) -> TypeOne:
    """Return the figures of readings of one part; `DataError` for fewer than five.

    Cg = 0.2 T / (6 s), Cgk = (0.1 T - |bias|) / (3 s), t = bias sqrt(n) / s (AIAG MSA, 4th ed.,
    chapter III B for the bias; Bosch booklet 10, procedure 1, for Cg and Cgk).
    """
    values, n = readings.values, len(readings.values)
    if n < FEWEST:
        raise readings.refuse(f"{n} readings, {FEWEST} are the fewest", "read the part 50 times")
    shifted = values - values[0]  # keeps the digits of readings far from zero
    mean, s = float(values[0] + shifted.mean()), float(shifted.std(ddof=1))
    reference = None if readings.reference is None else float(readings.reference[0])
    bias = None if reference is None else mean - reference
    t = None if bias is None or s == 0 else bias * math.sqrt(n) / s
    variances = drawn_variance(s**2, n - 1, rng)
    scatter = np.sqrt(variances)
    s_ends = interval_of_s(s, n - 1)
    Cg = Cg_ends = Cgk = Cgk_ends = None
    if tolerance is not None and s > 0:
        Cg = SHARE * tolerance / (6 * s)
        Cg_ends = (Cg * s / s_ends[1], Cg * s / s_ends[0])
    parts = {**stated_parts(readings.resolution, readings.uncertainty), "EVR": s}
    draws = {"EVR": scatter}
    if bias is not None:
        biases = drawn_mean(bias, variances, n, rng)
        parts["BI"], draws["BI"] = rectangular(abs(bias)), rectangular(1.0) * np.abs(biases)
        if tolerance is not None and s > 0:
            Cgk = (SHARE / 2 * tolerance - abs(bias)) / (3 * s)
            Cgk_ends = between((SHARE / 2 * tolerance - np.abs(biases)) / (3 * scatter))
    missing = tuple(name for name in ("CAL", "RE", "BI") if name not in parts)
    return TypeOne(
        n=n,
        mean=mean,
        s=s,
        s_interval=s_ends,
        reference=reference,
        bias=bias,
        bias_interval=None if bias is None else interval_of_mean(bias, s, n),
        t=t,
        p_value=None if t is None else p_of_t(t, n - 1),
        Cg=Cg,
        Cg_interval=Cg_ends,
        Cgk=Cgk,
        Cgk_interval=Cgk_ends,
        budget=budget("MS", parts, draws, tolerance, missing),
    )
