"""Since when a figure grows, how fast, and when it meets a limit: each as an interval.

The model is ln RP = a + ln(1 + b (t - t0)) from an unknown day t0 on and a before: scatter that
wears in grows from some day at an even rate. Errors are normal: those of the tests' own sampling,
and what tests differ by beside it, of unknown size. Every t0 among the tests, every b and every
such size of a grid is weighed by its likelihood (Bayes; a is integrated out), so that knowing none
of them widens every interval. How often they hold: benchmarks/history.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scara_iso.run import FloatArray

_GROWTH = np.concatenate([np.linspace(-0.95, 3, 159), np.linspace(3.1, 20, 170)])
"""Growth over the span of the tests, as a share of the level before."""
_LIKELY = 3.0
"""Growth of this size is likely as any below it: less says too late when a robot that wears fast
meets its limit (benchmarks/history.py)."""
_BETWEEN = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.4, 2.0, 3.0])
"""What tests may differ by beside their sampling, in errors of that."""
_NEGLIGIBLE = 1e-3
"""Weight of all cells together that are left out."""
_TAIL = 0.025
_STEPS = 100
_AHEAD = 2.0
"""How many spans of the tests the future is looked into."""
FEWEST = 5
MONTH = 365.25 / 12
"""Days."""


@dataclass(frozen=True, eq=False, slots=True)
class Trend:
    """What is known of the course of ln RP, in cells of an onset, a growth and an error.

    The arrays of cells have the shape (cells,).
    """

    days: FloatArray
    """Of the tests, shape (tests,); the first that the trend is of is the first of them."""
    weights: FloatArray
    """Probability of each cell; together 1."""
    begun: FloatArray
    """Day of each cell from which the figure grows."""
    growth: FloatArray
    """Growth over the span of the tests, as a share of the level before."""
    start: FloatArray
    """The level before [ln of the unit]."""
    error: FloatArray
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
        means = [float(self.weights @ self._at(day)) for day in days.tolist()]
        return np.asarray(np.exp(np.array(means)))

    def chance_above(self, limit: float, days: FloatArray) -> FloatArray:
        """Return the probability that the figure's true value is above ``limit`` on each day."""
        from scipy.special import ndtr  # noqa: PLC0415 - for trends only

        off = math.log(limit)
        found = [self.weights @ ndtr((self._at(d) - off) / self.error) for d in days.tolist()]
        return np.array([float(one) for one in found])

    def _at(self, day: float) -> FloatArray:
        """Return ln of the figure of each cell on a day."""
        span = float(self.days[-1] - self.days[0])
        return self.start + _grown(self.growth, (day - self.begun) / span)


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


def trend_of(days: FloatArray, logs: FloatArray, sampling: FloatArray) -> Trend | None:
    """Return the trend of ln figures on days, with their sampling errors; all of shape (tests,).

    None for fewer than five tests.
    """
    if len(days) < FEWEST:
        return None
    span, onsets = days[-1] - days[0], days[:-1, np.newaxis, np.newaxis]
    unbiased = logs + sampling**2 / 2  # the ln of a figure that is right on average lies low
    left = unbiased - _grown(_GROWTH[:, np.newaxis], (days - onsets) / span)
    of_growth = np.log(np.gradient(_GROWTH) / (_LIKELY**2 + _GROWTH**2))  # heavy tails
    of_between = np.log(np.gradient(_BETWEEN) / (1 + _BETWEEN**2))
    found = []
    for between, prior in zip(_BETWEEN * sampling.mean(), of_between, strict=True):
        weight = 1 / (sampling**2 + between**2)
        start = left @ weight / weight.sum()
        misfit = ((left - start[..., np.newaxis]) ** 2) @ weight
        known = np.log(weight).sum() - np.log(weight.sum())
        log_posterior = prior + of_growth + (known - misfit) / 2
        found.append((log_posterior, start, np.full(start.shape, weight.sum() ** -0.5)))
    log_posterior, start, error = (np.stack(part) for part in zip(*found, strict=True))
    return _summed_up(days, log_posterior, start, error)


def _summed_up(
    days: FloatArray, log_posterior: FloatArray, start: FloatArray, error: FloatArray
) -> Trend:
    """Return the trend of cells of shape (between, onsets, growths): those that matter."""
    posterior = np.exp(log_posterior - log_posterior.max())
    ordered = np.sort(posterior, axis=None)
    left_out = np.searchsorted(np.cumsum(ordered), _NEGLIGIBLE * posterior.sum())
    kept = posterior >= ordered[left_out]
    weights = posterior[kept] / posterior[kept].sum()
    begun = np.broadcast_to(days[:-1, np.newaxis], posterior.shape)[kept]
    growth = np.broadcast_to(_GROWTH, posterior.shape)[kept]
    rate = np.exp(start[kept]) * growth / (days[-1] - days[0]) * MONTH
    low, middle, high = _quantiles(rate, weights, (_TAIL, 0.5, 1 - _TAIL))
    first, last = _quantiles(begun, weights, (_TAIL, 1 - _TAIL))
    return Trend(
        days, weights, begun, growth, start[kept], error[kept], middle, (low, high), (first, last)
    )


def _grown(growth: FloatArray, since: FloatArray) -> FloatArray:
    """Return ln of the figure over that before, so long ``since`` the onset [spans]."""
    return np.asarray(np.log1p(np.maximum(growth * np.maximum(since, 0), -0.99)))


def crossing(trend: Trend, limit: float) -> LimitCrossing:
    """Return when the figure meets ``limit``, looked for from the last test on."""
    last, span = float(trend.days[-1]), float(trend.days[-1] - trend.days[0])
    ahead = np.linspace(last, last + _AHEAD * span, _STEPS)
    chance = trend.chance_above(limit, ahead)

    def first(share: float) -> float | None:
        above = np.flatnonzero(chance >= share)
        if not len(above):
            return None
        k = max(int(above[0]), 1)  # between two days the chance is taken to go straight
        return float(np.interp(share, chance[k - 1 : k + 1], ahead[k - 1 : k + 1]))

    return LimitCrossing(limit, first(_TAIL), first(0.5), first(1 - _TAIL), float(ahead[-1]))


def _quantiles(values: FloatArray, weights: FloatArray, shares: tuple[float, ...]) -> list[float]:
    order = np.argsort(values)
    total, ordered = np.cumsum(weights[order]), values[order]
    at = np.minimum(np.searchsorted(total, np.array(shares)), len(ordered) - 1)
    return [float(one) for one in ordered[at]]
