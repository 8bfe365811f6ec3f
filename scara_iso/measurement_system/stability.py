"""Stability: one part read in several sessions. Shewhart's charts of its mean and scatter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scara_iso.measurement_system.pivots import p_of_t
from scara_iso.measurement_system.readings import GaugeReadings, numbered
from scara_iso.published import Count
from scara_iso.run import FloatArray, IntArray

FEWEST = 3
_D2_OF_TWO = 2 / math.sqrt(math.pi)
"""Mean range of two Gaussian values."""


@dataclass(frozen=True, eq=False, slots=True)
class Stability:
    """The course of a part's readings over sessions, in the readings' unit."""

    sessions: tuple[str, ...]
    """Their names."""
    counts: tuple[Count, ...]
    """Readings of each session."""
    means: FloatArray
    """Shape (sessions,)."""
    scatters: FloatArray | None
    """Standard deviation of each; null where each has one reading only."""
    sigma: float
    """Standard deviation of one reading within a session; between neighbours where it has one."""
    centre: float
    """Mean of all readings."""
    half_width: FloatArray
    """From the centre to either limit of the mean, 3 sigma / sqrt(n), shape (sessions,)."""
    scatter_limits: tuple[FloatArray, FloatArray] | None
    """Of `scatters`, shape (sessions,) each."""
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
    range where a session is one reading.
    """
    sessions, at = numbered(readings.session or ())
    if len(sessions) < FEWEST:
        raise readings.refuse(f"{len(sessions)} sessions", f"read the part in {FEWEST} or more")
    counts = np.bincount(at)
    means = np.bincount(at, readings.values) / counts
    scatters = _scatters(readings.values, at, counts)
    centre = float((counts * means).sum() / counts.sum())
    if scatters is None:
        sigma = float(np.abs(np.diff(means)).mean()) / _D2_OF_TWO
    else:
        sigma = float((scatters / c4(counts)).mean())
    half_width = 3 * sigma / np.sqrt(counts)
    limits = None if scatters is None else _scatter_limits(sigma, counts)
    out = np.abs(means - centre) > half_width
    if limits is not None and scatters is not None:
        out |= (scatters < limits[0]) | (scatters > limits[1])
    trend, p_value = _trend(means)
    return Stability(
        sessions=sessions,
        counts=tuple(counts.tolist()),
        means=means,
        scatters=scatters,
        sigma=sigma,
        centre=centre,
        half_width=half_width,
        scatter_limits=limits,
        outside=tuple(sessions[k] for k in np.flatnonzero(out)),
        between=_between(means, sigma, counts, alone=scatters is None),
        trend=trend,
        trend_p_value=p_value,
    )


def c4(n: IntArray) -> FloatArray:
    """Return what the mean standard deviation of ``n`` Gaussian values falls short by."""
    from scipy.special import gammaln  # noqa: PLC0415 - scipy for studies only

    return np.asarray(np.sqrt(2 / (n - 1)) * np.exp(gammaln(n / 2) - gammaln((n - 1) / 2)))


def _scatters(values: FloatArray, at: IntArray, counts: IntArray) -> FloatArray | None:
    if counts.min() < 2:
        return None
    return np.array([values[at == k].std(ddof=1) for k in range(len(counts))])


def _scatter_limits(sigma: float, counts: IntArray) -> tuple[FloatArray, FloatArray]:
    middle, width = sigma * c4(counts), 3 * sigma * np.sqrt(1 - c4(counts) ** 2)
    return np.maximum(middle - width, 0.0), middle + width


def _between(means: FloatArray, sigma: float, counts: IntArray, *, alone: bool) -> float:
    if alone:
        return 0.0
    return math.sqrt(max(float(means.var(ddof=1)) - float((sigma**2 / counts).mean()), 0.0))


def _trend(means: FloatArray) -> tuple[float, float | None]:
    k = np.arange(len(means)) - (len(means) - 1) / 2
    slope = float(k @ means / (k @ k))
    left = means - means.mean() - slope * k
    residual = math.sqrt(float(left @ left) / (len(means) - 2))
    if residual <= 1e-12 * float(np.abs(means).max() or 1.0):
        return slope, None
    return slope, p_of_t(slope * math.sqrt(float(k @ k)) / residual, len(means) - 2)
