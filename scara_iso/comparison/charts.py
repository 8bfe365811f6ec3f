"""Control charts: individuals and moving range, EWMA, CUSUM, and what makes figures fit for them.

Shewhart's individuals, Roberts' EWMA (1959) and Page's CUSUM (1954) as Montgomery, Introduction to
Statistical Quality Control, gives them (ch. 6.4 and 9). Figures of scatter come standardised
against the tests before them (`standardised`), so that no test has to be declared the good ones.

Since when a figure grows, how fast, and when it meets a limit: each as an interval.

The model is ln RP = a + ln(1 + b (t - t0)), or a + c (t - t0), from an unknown day t0 on and a
before: wear grows from some day at an even rate, or compounds; both are as likely. Errors are
normal: those of the tests' own sampling, and what tests differ by beside it, of unknown size. Every
t0 among the tests, every b and c and every such size of a grid is weighed by its likelihood (Bayes;
a is integrated out), so that knowing none of them widens every interval. How often they hold:
benchmarks/history.py.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import date
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from scara_iso.base.published import INTERNAL, Interval, fill, published
from scara_iso.run import FloatArray

LAMBDA, WIDTH = 0.2, 2.86
"""EWMA: weight of the newest test, and limit in standard errors; average run length 370."""
SLACK, DECISION = 0.5, 4.77
"""CUSUM: slack and decision interval in standard errors; average run length 370."""
D2 = 2 / math.sqrt(math.pi)
"""Mean range of two standard normal values: 1.128."""
D4 = 1 + 3 * math.sqrt(1 - 2 / math.pi) / (2 / math.sqrt(math.pi)) * math.sqrt(2)
"""Upper limit of a range of two over their mean range: 3.267."""


def none_for_nan(found: FloatArray) -> tuple[float | None, ...]:
    """Return numbers, shape (n,), None for NaN."""
    return tuple(None if math.isnan(one) else one for one in found.tolist())


@dataclass(frozen=True, eq=False, slots=True)
class Individuals:
    """Values against their mean, and moving ranges; arrays of shape (tests,)."""

    centre: FloatArray
    """Mean of the stretch that a test belongs to."""
    low: FloatArray
    """Three standard errors below it."""
    high: FloatArray
    """Three standard errors above it."""
    moving_range: FloatArray = field(metadata=published(by=none_for_nan))
    """Distance from the test before, NaN at the first of a stretch."""
    range_limit: float
    """Upper limit of the moving range."""
    sigma: float
    """Standard error of a value."""
    alarms: tuple[int, ...] = field(metadata=INTERNAL)
    """Tests, from 0, that lie outside or moved farther than the limit."""
    dates: tuple[str, ...] = field(default=(), metadata=published("alarms"))
    """Dates of these tests."""


@dataclass(frozen=True, eq=False, slots=True)
class Ewma:
    """Exponentially weighted mean of standardised values; arrays of shape (tests,)."""

    points: FloatArray
    """The weighted means, in standard errors."""
    limits: FloatArray
    """Upper limit; the lower one is its negative."""
    alarms: tuple[int, ...] = field(metadata=INTERNAL)
    """Tests, from 0, that lie outside."""
    dates: tuple[str, ...] = field(default=(), metadata=published("alarms"))
    """Dates of these tests."""


@dataclass(frozen=True, eq=False, slots=True)
class Cusum:
    """One-sided cumulative sums of standardised values; arrays of shape (tests,)."""

    up: FloatArray
    """Sum of what lies above, in standard errors."""
    down: FloatArray
    """As a sum above 0, of what lies below."""
    limit: float
    """The decision interval."""
    alarms: tuple[int, ...] = field(metadata=INTERNAL)
    """Tests, from 0, at which a sum is beyond it."""
    dates: tuple[str, ...] = field(default=(), metadata=published("alarms"))
    """Dates of these tests."""


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


def ewma(z: FloatArray, stretches: Sequence[slice]) -> Ewma:
    """Return the chart of standardised values of shape (tests,), begun anew in each stretch."""
    points, limits = np.empty(len(z)), np.empty(len(z))
    for one in stretches:
        tests = np.arange(1, one.stop - one.start + 1)
        points[one] = _summed(z[one], lambda mean, new: LAMBDA * new + (1 - LAMBDA) * mean)
        limits[one] = WIDTH * np.sqrt(LAMBDA / (2 - LAMBDA) * (1 - (1 - LAMBDA) ** (2 * tests)))
    return Ewma(points, limits, _at(np.abs(points) > limits))


def cusum(z: FloatArray, stretches: Sequence[slice]) -> Cusum:
    """Return the chart of standardised values of shape (tests,), begun anew in each stretch."""
    up, down = np.empty(len(z)), np.empty(len(z))
    for one in stretches:
        up[one] = _summed(z[one], lambda above, new: max(0.0, above + new - SLACK))
        down[one] = _summed(z[one], lambda below, new: max(0.0, below - new - SLACK))
    return Cusum(up, down, DECISION, _at((up > DECISION) | (down > DECISION)))


def _summed(z: FloatArray, step: Callable[[float, float], float]) -> list[float]:
    return list(accumulate(z.tolist(), step, initial=0.0))[1:]


def _at(outside: np.ndarray) -> tuple[int, ...]:
    return tuple(np.flatnonzero(outside).tolist())


_GROWTH = np.concatenate([np.linspace(-0.95, 3, 159).round(9), np.linspace(3.1, 20, 170)])
"""Growth over the span of the tests, as a share of the level before; no growth is exactly 0."""
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


def date_on(day: float) -> str:
    """Return the date of a day since 1970-01-01: ``2026-05-12``."""
    return date.fromordinal(date(1970, 1, 1).toordinal() + int(day // 1)).isoformat()


def dates_on(days: Interval) -> tuple[str, str]:
    """Return the dates of two days since 1970-01-01."""
    return date_on(days[0]), date_on(days[1])


@dataclass(frozen=True, eq=False, slots=True)
class Trend:
    """What is known of the course of ln RP, in cells of a shape, an onset, a growth and an error.

    The figure grows by the same amount each day, or by the same share (wear that compounds). Both
    are as likely before the tests.

    The arrays of cells have the shape (cells,).
    """

    days: FloatArray = field(metadata=INTERNAL)
    """Of the tests, shape (tests,); the first that the trend is of is the first of them."""
    weights: FloatArray = field(metadata=INTERNAL)
    """Probability of each cell; together 1."""
    begun: FloatArray = field(metadata=INTERNAL)
    """Day of each cell from which the figure grows."""
    growth: FloatArray = field(metadata=INTERNAL)
    """Growth over the span of the tests, as a share of the level before."""
    start: FloatArray = field(metadata=INTERNAL)
    """The level before [ln of the unit]."""
    error: FloatArray = field(metadata=INTERNAL)
    """Standard error of that level."""
    compounds: npt.NDArray[np.bool_] = field(metadata=INTERNAL)
    """Whether it grows by the same share each day."""
    per_month: float
    """Median of the rate, in the unit of the figure."""
    interval: Interval
    """95 %, of the rate."""
    shown: bool = field(init=False)
    """Whether the rate is more than chance."""
    onset: Interval = field(metadata=published(by=dates_on))
    """95 %, of the day on which it begins."""
    levels: FloatArray = field(init=False, metadata=published("level"))
    """The expected figure at each test, shape (tests,)."""

    def __post_init__(self) -> None:
        low, high = self.interval
        fill(self, shown=low > 0 or high < 0, levels=self.level(self.days))

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
        return self.start + _grown(self.growth, (day - self.begun) / span, self.compounds)


def date_or_none(day: float | None) -> str | None:
    """Return the date of a day since 1970-01-01, None for None."""
    return None if day is None else date_on(day)


_DATED = published(by=date_or_none, always=True)


@dataclass(frozen=True, slots=True)
class LimitCrossing:
    """A limit, and on which day the true figure meets it if it goes on as it does."""

    limit: float
    """In the unit of the figure."""
    crossed: bool = False
    """Whether, since the last service, a test broke the limit, or the last lies above it; the exit
    code is then 1."""
    earliest: float | None = field(default=None, metadata=_DATED)
    """Date from which the chance is 2.5 %; None: not before the horizon."""
    likely: float | None = field(default=None, metadata=_DATED)
    """50 %."""
    latest: float | None = field(default=None, metadata=_DATED)
    """97.5 %."""
    horizon: float | None = field(default=None, metadata=_DATED)
    """How far was looked ahead."""


def trend_of(days: FloatArray, logs: FloatArray, sampling: FloatArray) -> Trend | None:
    """Return the trend of ln figures on days, with their sampling errors; all of shape (tests,).

    None for fewer than five tests.
    """
    if len(days) < FEWEST:
        return None
    span, onsets = days[-1] - days[0], days[:-1, np.newaxis, np.newaxis]
    unbiased = logs + sampling**2 / 2  # the ln of a figure that is right on average lies low
    since, growth = (days - onsets) / span, _GROWTH[:, np.newaxis]
    left = np.stack([unbiased - _grown(growth, since, np.array(one)) for one in (False, True)])
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
    """Return the trend of cells of shape (between, shapes, onsets, growths): those that matter."""
    posterior = np.exp(log_posterior - log_posterior.max())
    ordered = np.sort(posterior, axis=None)
    left_out = np.searchsorted(np.cumsum(ordered), _NEGLIGIBLE * posterior.sum())
    kept = posterior >= ordered[left_out]
    weights = posterior[kept] / posterior[kept].sum()
    begun = np.broadcast_to(days[:-1, np.newaxis], posterior.shape)[kept]
    growth = np.broadcast_to(_GROWTH, posterior.shape)[kept]
    compounds = np.broadcast_to(np.array([False, True])[:, None, None], posterior.shape)[kept]
    rate = np.exp(start[kept]) * growth / (days[-1] - days[0]) * MONTH
    low, middle, high = _quantiles(rate, weights, (_TAIL, 0.5, 1 - _TAIL))
    first, last = _quantiles(begun, weights, (_TAIL, 1 - _TAIL))
    return Trend(
        days=days,
        weights=weights,
        begun=begun,
        growth=growth,
        start=start[kept],
        error=error[kept],
        compounds=compounds,
        per_month=middle,
        interval=(low, high),
        onset=(first, last),
    )


def _grown(growth: FloatArray, since: FloatArray, compounds: npt.NDArray[np.bool_]) -> FloatArray:
    """Return ln of the figure over that before, so long ``since`` the onset [spans]."""
    since = np.maximum(since, 0)
    evenly = np.log1p(np.maximum(growth * since, -0.99))
    return np.asarray(np.where(compounds, np.log1p(growth) * since, evenly))


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

    days = (first(_TAIL), first(0.5), first(1 - _TAIL), float(ahead[-1]))
    return LimitCrossing(limit, False, *days)


def _quantiles(values: FloatArray, weights: FloatArray, shares: tuple[float, ...]) -> list[float]:
    order = np.argsort(values)
    total, ordered = np.cumsum(weights[order]), values[order]
    at = np.minimum(np.searchsorted(total, np.array(shares)), len(ordered) - 1)
    return [float(one) for one in ordered[at]]
