"""Since when a figure grows, how fast, and when it meets a limit: each as an interval.

The model is ln RP = a + ln(1 + b (t - t0)) from an unknown day t0 on and a before, with normal
errors of known size: scatter that wears in grows from some day at an even rate. Every t0 among the
tests and every b of a grid is weighed by its likelihood (Bayes; a is integrated out), so that not
knowing when the wear began widens every interval. How often they hold: benchmarks/history.py.
"""

from __future__ import annotations

import math

import numpy as np

from scara_iso.frozen import dataclass
from scara_iso.run import FloatArray

_GROWTH = np.concatenate([np.linspace(-0.95, 3, 159), np.linspace(3.1, 20, 170)])
"""Growth over the span of the tests, as a share of the level before."""
_TAIL = 0.025
_STEPS = 400
_AHEAD = 2.0
"""How many spans of the tests the future is looked into."""
FEWEST = 5
MONTH = 365.25 / 12
"""Days."""


@dataclass(frozen=True, eq=False, slots=True)
class Trend:
    """What is known of the course of ln RP; ``weights`` of shape (onsets, growths) add up to 1."""

    days: FloatArray
    """Of the tests, shape (tests,); the first that the trend is of is the first of them."""
    weights: FloatArray
    start: FloatArray
    """The level before [ln of the unit], of the shape of ``weights``."""
    error: float
    """Standard error of that level."""
    per_month: float
    """Median of the rate, in the unit of the figure."""
    interval: tuple[float, float]
    """95 %, of the rate."""
    onset: tuple[float, float]
    """95 %, of the day on which it begins."""

    @property
    def is_shown(self) -> bool:
        """Whether the rate is more than chance."""
        return self.interval[0] > 0 or self.interval[1] < 0

    def level(self, days: FloatArray) -> FloatArray:
        """Return the expected figure on days of shape (n,)."""
        means = [float((self.weights * (self.start + g)).sum()) for g in self._growth(days)]
        return np.asarray(np.exp(np.array(means)))

    def chance_above(self, limit: float, days: FloatArray) -> FloatArray:
        """Return the probability that the figure's true value is above ``limit`` on each day."""
        from scipy.special import ndtr  # noqa: PLC0415 - for trends only

        off = math.log(limit)
        found = [
            (self.weights * ndtr((self.start + g - off) / self.error)).sum()
            for g in self._growth(days)
        ]
        return np.array([float(one) for one in found])

    def _growth(self, days: FloatArray) -> list[FloatArray]:
        onsets, span = self.days[:-1, np.newaxis], self.days[-1] - self.days[0]
        grown = [_GROWTH * np.maximum(day - onsets, 0) / span for day in days.tolist()]
        return [np.log1p(np.maximum(one, -0.99)) for one in grown]


@dataclass(frozen=True, slots=True)
class LimitCrossing:
    """When the true figure meets a limit, if it goes on as it does; days, as in the trend."""

    limit: float
    """In the unit of the figure."""
    earliest: float | None
    """The chance is 2.5 % from this day on; None: not within the horizon."""
    likely: float | None
    """50 %."""
    latest: float | None
    """97.5 %."""
    horizon: float
    """How far was looked ahead."""


def trend_of(days: FloatArray, logs: FloatArray, errors: FloatArray) -> Trend | None:
    """Return the trend of ln figures on days, with their standard errors; all of shape (tests,).

    None for fewer than five tests.
    """
    if len(days) < FEWEST:
        return None
    span, onsets = days[-1] - days[0], days[:-1, np.newaxis, np.newaxis]
    growth = np.log1p(_GROWTH[:, np.newaxis] * np.maximum(days - onsets, 0) / span)
    weight = 1 / errors**2
    left = logs - growth
    start = (weight * left).sum(axis=-1) / weight.sum()
    misfit = (weight * (left - start[..., np.newaxis]) ** 2).sum(axis=-1)
    prior = -np.log1p(_GROWTH**2) + np.log(np.gradient(_GROWTH))  # heavy tails: benchmarks/history
    log_posterior = prior - misfit / 2
    posterior = np.exp(log_posterior - log_posterior.max())
    posterior /= posterior.sum()
    rate = np.exp(start) * _GROWTH / span * MONTH
    low, middle, high = _quantiles(rate.ravel(), posterior.ravel(), (_TAIL, 0.5, 1 - _TAIL))
    of_onset = posterior.sum(axis=1)
    begun = _quantiles(days[:-1], of_onset, (_TAIL, 1 - _TAIL))
    error = 1 / math.sqrt(float(weight.sum()))
    return Trend(days, posterior, start, error, middle, (low, high), (begun[0], begun[1]))


def crossing(trend: Trend, limit: float) -> LimitCrossing:
    """Return when the figure meets ``limit``, looked for from the last test on."""
    last, span = float(trend.days[-1]), float(trend.days[-1] - trend.days[0])
    ahead = np.linspace(last, last + _AHEAD * span, _STEPS)
    chance = trend.chance_above(limit, ahead)

    def first(share: float) -> float | None:
        above = np.flatnonzero(chance >= share)
        return float(ahead[above[0]]) if len(above) else None

    return LimitCrossing(limit, first(_TAIL), first(0.5), first(1 - _TAIL), float(ahead[-1]))


def _quantiles(values: FloatArray, weights: FloatArray, shares: tuple[float, ...]) -> list[float]:
    order = np.argsort(values)
    total, ordered = np.cumsum(weights[order]), values[order]
    at = np.minimum(np.searchsorted(total, np.array(shares)), len(ordered) - 1)
    return [float(one) for one in ordered[at]]
