"""Control charts: individuals and moving range, EWMA, CUSUM, and what makes figures fit for them.

Shewhart's individuals, Roberts' EWMA (1959) and Page's CUSUM (1954) as Montgomery, Introduction to
Statistical Quality Control, gives them (ch. 6.4 and 9). Figures of scatter come standardised
against the tests before them (`standardised`), so that no test has to be declared the good ones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.run import FloatArray

LAMBDA, WIDTH = 0.2, 2.86
"""EWMA: weight of the newest test, and limit in standard errors; average run length 370."""
SLACK, DECISION = 0.5, 4.77
"""CUSUM: slack and decision interval in standard errors; average run length 370."""
D2 = 2 / math.sqrt(math.pi)
"""Mean range of two standard normal values: 1.128."""
D4 = 1 + 3 * math.sqrt(1 - 2 / math.pi) / (2 / math.sqrt(math.pi)) * math.sqrt(2)
"""Upper limit of a range of two over their mean range: 3.267."""


@dataclass(frozen=True, eq=False, slots=True)
class Individuals:
    """Values against their mean, and moving ranges; arrays of shape (tests,)."""

    centre: FloatArray
    """Mean of the stretch that a test belongs to."""
    low: FloatArray
    """Three standard errors below it."""
    high: FloatArray
    """Three standard errors above it."""
    moving_range: FloatArray
    """Distance from the test before, NaN at the first of a stretch."""
    range_limit: float
    """Upper limit of the moving range."""
    sigma: float
    """Standard error of a value."""
    alarms: tuple[int, ...]
    """Tests, from 0, that lie outside or moved farther than the limit."""


@dataclass(frozen=True, eq=False, slots=True)
class Ewma:
    """Exponentially weighted mean of standardised values; arrays of shape (tests,)."""

    points: FloatArray
    """The weighted means, in standard errors."""
    limits: FloatArray
    """Upper limit; the lower one is its negative."""
    alarms: tuple[int, ...]
    """Tests, from 0, that lie outside."""


@dataclass(frozen=True, eq=False, slots=True)
class Cusum:
    """One-sided cumulative sums of standardised values; arrays of shape (tests,)."""

    up: FloatArray
    """Sum of what lies above, in standard errors."""
    down: FloatArray
    """As a sum above 0, of what lies below."""
    limit: float
    """The decision interval."""
    alarms: tuple[int, ...]
    """Tests, from 0, at which a sum is beyond it."""


def moving_range_sigma(values: FloatArray, stretches: Sequence[slice]) -> float | None:
    """Return the mean distance of neighbours over d2, neighbours of one stretch; None without."""
    found = np.concatenate([np.abs(np.diff(values[one])) for one in stretches] or [np.empty(0)])
    return float(found.mean()) / D2 if len(found) else None


def between_tests(
    values: FloatArray, sampling: FloatArray, stretches: Sequence[slice]
) -> FloatArray:
    """Return the standard errors of values of shape (tests,) as tests of one stretch differ.

    Never less than those by ``sampling`` alone: few tests that happen to agree make no narrow
    limits.
    """
    seen = moving_range_sigma(values, stretches) or 0.0
    robot = max(seen**2 - float((sampling**2).mean()), 0.0)
    return np.asarray(np.sqrt(robot + sampling**2))


def individuals(values: FloatArray, errors: FloatArray, stretches: Sequence[slice]) -> Individuals:
    """Return the chart of values of shape (tests,); ``errors`` are their standard errors.

    The limits are never nearer than three standard errors of a value: what differs by its own
    sampling is no sign.
    """
    sigma = max(moving_range_sigma(values, stretches) or 0.0, math.sqrt(float((errors**2).mean())))
    centre, moved = np.empty(len(values)), np.full(len(values), np.nan)
    for one in stretches:
        centre[one] = values[one].mean()
        moved[one.start + 1 : one.stop] = np.abs(np.diff(values[one]))
    range_limit = D4 * D2 * sigma
    outside = (np.abs(values - centre) > 3 * sigma) | (moved > range_limit)
    return Individuals(
        centre, centre - 3 * sigma, centre + 3 * sigma, moved, range_limit, sigma, _at(outside)
    )


def standardised(values: FloatArray, sigma: FloatArray, stretches: Sequence[slice]) -> FloatArray:
    """Return each value's distance from the mean of those before it in its stretch, over its error.

    ``sigma`` are the standard errors of the values. Independent standard normal values where
    nothing changes (Quesenberry 1991, the mean unknown and the error known); 0 for the first.
    """
    found = np.zeros(len(values))
    for one in stretches:
        weight = 1 / sigma[one] ** 2
        total, summed = np.cumsum(weight), np.cumsum(weight * values[one])
        before = summed[:-1] / total[:-1]
        apart = values[one][1:] - before
        found[one.start + 1 : one.stop] = apart / np.sqrt(sigma[one][1:] ** 2 + 1 / total[:-1])
    return found


def ewma(
    z: FloatArray, stretches: Sequence[slice], *, weight: float = LAMBDA, width: float = WIDTH
) -> Ewma:
    """Return the chart of standardised values of shape (tests,), begun anew in each stretch."""
    points, limits = np.empty(len(z)), np.empty(len(z))
    for one in stretches:
        mean = 0.0
        for k in range(one.start, one.stop):
            mean = weight * float(z[k]) + (1 - weight) * mean
            points[k] = mean
            shrunk = 1 - (1 - weight) ** (2 * (k - one.start + 1))
            limits[k] = width * math.sqrt(weight / (2 - weight) * shrunk)
    return Ewma(points, limits, _at(np.abs(points) > limits))


def cusum(
    z: FloatArray, stretches: Sequence[slice], *, slack: float = SLACK, decision: float = DECISION
) -> Cusum:
    """Return the chart of standardised values of shape (tests,), begun anew in each stretch."""
    up, down = np.empty(len(z)), np.empty(len(z))
    for one in stretches:
        above = below = 0.0
        for k in range(one.start, one.stop):
            above = max(0.0, above + float(z[k]) - slack)
            below = max(0.0, below - float(z[k]) - slack)
            up[k], down[k] = above, below
    return Cusum(up, down, decision, _at((up > decision) | (down > decision)))


def _at(outside: np.ndarray) -> tuple[int, ...]:
    return tuple(np.flatnonzero(outside).tolist())
