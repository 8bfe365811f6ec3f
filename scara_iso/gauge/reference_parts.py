"""Studies of parts whose true value is known, or that never change: bias, linearity, stability.

Type 1: one part of known size read again and again; Cg, Cgk, the bias and its t-test. Linearity:
does the bias stay the same over the dial's range? A line through all readings. Stability: one part
read in several sessions; Shewhart's charts of its mean and scatter.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from scara_iso.base.published import INTERNAL, Count, Interval
from scara_iso.gauge.budget import (
    CONFIDENCE,
    Budget,
    between,
    budget,
    drawn_mean,
    drawn_variance,
    interval_of_mean,
    interval_of_s,
    p_of_t,
    rectangular,
    stated_parts,
)
from scara_iso.gauge.table import GaugeReadings, numbered
from scara_iso.run import FloatArray, IntArray

FEWEST = 5
SHARE = 0.2
"""Share of the tolerance that six standard deviations may take: Cg = 0.2 T / (6 s)."""


@dataclass(frozen=True, slots=True)
class TypeOne:
    """Figures of a type 1 study, in the readings' unit; null where something is not stated."""

    n: Count
    """Number of readings."""
    mean: float
    """Of the readings."""
    s: float
    """Their standard deviation, n - 1."""
    s_interval: Interval | None
    """95 %; null where all readings are alike, as of every figure of their scatter."""
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
    budget: Budget = field(metadata=INTERNAL)
    """The uncertainties by VDA 5."""


def type_1(readings: GaugeReadings, tolerance: float | None, rng: np.random.Generator) -> TypeOne:
    """Return the figures of readings of one part; `DataError` for fewer than five.

    Cg = 0.2 T / (6 s), Cgk = (0.1 T - |bias|) / (3 s), t = bias sqrt(n) / s (AIAG MSA, 4th ed.,
    chapter III B for the bias; Bosch booklet 10, procedure 1, for Cg and Cgk).
    """
    values, n = readings.values, len(readings.values)
    if n < FEWEST:
        raise readings.refuse(f"{n} readings, {FEWEST} are needed", "read the part 50 times")
    shifted = values - values[0]  # keeps the digits of readings far from zero
    mean, s = float(values[0] + shifted.mean()), float(shifted.std(ddof=1))
    reference = None if readings.reference is None else float(readings.reference[0])
    bias = None if reference is None else mean - reference
    t = None if bias is None or s == 0 else bias * math.sqrt(n) / s
    variances = drawn_variance(s**2, n - 1, rng)
    scatter = np.sqrt(variances)
    s_ends = interval_of_s(s, n - 1)
    Cg = Cg_ends = Cgk = Cgk_ends = None
    if tolerance is not None and s_ends is not None:
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
        budget=budget("MS", parts, draws, tolerance, ("CAL", "RE", "BI")),
    )


FEWEST_REFERENCES = 3


@dataclass(frozen=True, eq=False, slots=True)
class Linearity:
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
    slope_interval: Interval | None
    """95 %; null where the line goes through all."""
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
    budget: Budget = field(metadata=INTERNAL)
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
    if len(references) < 2 or n < FEWEST_REFERENCES + 2:
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
        slope_interval=(slope - t * of_slope, slope + t * of_slope) if residual > 0 else None,
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
    return budget("MS", parts, draws, tolerance, ("CAL", "RE"))


FEWEST_SESSIONS = 3
_MEAN_OF_ONE = math.sqrt(2 / math.pi)
"""Mean size of a standard Gaussian value."""


@dataclass(frozen=True, eq=False, slots=True)
class Stability:
    """The course of a part's readings over sessions, in the readings' unit."""

    sessions: tuple[str, ...]
    """Their names."""
    counts: tuple[Count, ...]
    """Readings of each session."""
    means: FloatArray
    """Shape (sessions,)."""
    scatters: tuple[float | None, ...] | None
    """Standard deviation of each, null of one reading; null where most have one only."""
    sigma: float
    """Standard deviation of one reading within a session, or from one to the next."""
    centre: float
    """Mean of all readings."""
    half_width: FloatArray
    """From the centre to either limit of the mean, 3 sigma / sqrt(n), shape (sessions,)."""
    scatter_limits: tuple[tuple[float | None, ...], tuple[float | None, ...]] | None
    """Of `scatters`, lower and upper, for each session."""
    outside: tuple[str, ...]
    """Sessions whose mean or scatter is outside its limits."""
    between: float
    """Standard deviation between sessions beyond what their scatter makes; 0 for none."""
    trend: float
    """Change of the mean from session to session."""
    trend_p_value: float | None
    """Chance of such a trend where there is none; null where the means lie on a line."""


def stability(readings: GaugeReadings) -> Stability:
    """Return the charts; `DataError` for fewer than three sessions.

    AIAG MSA, 4th ed., chapter III B; limits of x-bar and s (ISO 7870-2), of individuals by moving
    range where most sessions are one reading.
    """
    sessions, at = numbered(readings.session or ())
    if len(sessions) < FEWEST_SESSIONS:
        raise readings.refuse(
            f"{len(sessions)} sessions", f"read the part in {FEWEST_SESSIONS} or more"
        )
    counts = np.bincount(at)
    shifted = readings.values - readings.values[0]  # keeps the digits of readings far from zero
    means = readings.values[0] + np.bincount(at, shifted) / counts
    centre = float((counts * means).sum() / counts.sum())
    half_width, between = 3 / np.sqrt(counts), 0.0
    scatters, low, high = np.full((3, len(counts)), np.nan)
    has_scatter = (counts - 1).sum() >= len(counts) - 1
    if has_scatter:
        repeated = np.flatnonzero(counts > 1)
        scatters[repeated] = [shifted[at == k].std(ddof=1) for k in repeated]
        factors = c4(counts[repeated])
        sigma = float((scatters[repeated] / factors).mean())
        middle, width = sigma * factors, 3 * sigma * np.sqrt(1 - factors**2)
        low[repeated], high[repeated] = np.maximum(middle - width, 0.0), middle + width
        beyond = float(means.var(ddof=1)) - float((sigma**2 / counts).mean())
        between = math.sqrt(max(beyond, 0.0))
    else:  # more is known from session to session than within
        sigma = _from_one_to_the_next(means, counts)
    half_width *= sigma
    out = (np.abs(means - centre) > half_width) | (scatters < low) | (scatters > high)
    trend, p_value = _trend(means)
    return Stability(
        sessions=sessions,
        counts=tuple(counts.tolist()),
        means=means,
        scatters=_known(scatters) if has_scatter else None,
        sigma=sigma,
        centre=centre,
        half_width=half_width,
        scatter_limits=(_known(low), _known(high)) if has_scatter else None,
        outside=tuple(sessions[k] for k in np.flatnonzero(out)),
        between=between,
        trend=trend,
        trend_p_value=p_value,
    )


def _from_one_to_the_next(means: FloatArray, counts: IntArray) -> float:
    steps = np.abs(np.diff(means)) / np.sqrt(1 / counts[1:] + 1 / counts[:-1])
    return float(steps.mean()) / _MEAN_OF_ONE


def _known(values: FloatArray) -> tuple[float | None, ...]:
    return tuple(None if math.isnan(value) else value for value in values.tolist())


def c4(n: IntArray) -> FloatArray:
    """Return what the mean standard deviation of ``n`` Gaussian values falls short by."""
    from scipy.special import gammaln  # noqa: PLC0415 - scipy for studies only

    return np.asarray(np.sqrt(2 / (n - 1)) * np.exp(gammaln(n / 2) - gammaln((n - 1) / 2)))


def _trend(means: FloatArray) -> tuple[float, float | None]:
    k = np.arange(len(means)) - (len(means) - 1) / 2
    slope = float(k @ means / (k @ k))
    left = means - means.mean() - slope * k
    residual = math.sqrt(float(left @ left) / (len(means) - 2))
    if residual <= 1e-12 * float(np.abs(means).max() or 1.0):
        return slope, None
    return slope, p_of_t(slope * math.sqrt(float(k @ k)) / residual, len(means) - 2)
