"""A two-state hidden Markov model: the load rests on either of two flanks, unseen.

The state s_j in {lower, upper} of cycle j is a Markov chain (`Chain`), p = P(lower -> upper),
q = P(upper -> lower), that starts in its stationary distribution, P(upper) = p / (p + q). A reading
is y_j = m(s_j) + sigma e_j, e_j normal. With a_j(s) = P(y_1 .. y_j, s_j = s) the likelihood
comes by the forward algorithm,

    a_j(s) = P(y_j | s) sum_r a_(j-1)(r) P(r -> s),    P(y | p, q, m, sigma) = sum_s a_n(s),

and P(s_j | y) by the backward one (Rabiner 1989, eq. 19-27). Both levels m and sigma are integrated
out on a grid; courses with one change of state or none belong to the step and to scatter, and their
part is taken off in closed form.

Do unseen states persist? Where levels and scatter are those that the readings show in any order,
the likelihood of each order of the cycles is part of the test of the order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import lgamma

import numpy as np

from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.diagnosis.likelihood.rounded import normal_cdf
from scara_iso.diagnosis.tuning import FEWEST_ON_A_LEVEL, KNOWN_FROM, LEAST_SCATTER, SPLIT_SCALE
from scara_iso.effects import Chain
from scara_iso.run import FloatArray, IntArray

_LEVELS = 14
_PAIRS = np.triu_indices(_LEVELS, 1)
_SCATTERS = np.geomspace(0.12, 1.05, 10)
"""Scatters tried, over the standard deviation of the readings."""

_BEFORE_UNDERFLOW, _FACTORS = 8, 64
_TINY = 1e-300
_NO_MEMORY = 1e-9
_NEGLIGIBLE = 40.0
"""Log of how much less likely than the likeliest a cell is that cannot change a digit."""


@dataclass(frozen=True, eq=False, slots=True)
class TwoLevels:
    """Log Bayes factor of each chain against scatter alone, and the likeliest course.

    The chain changes its state twice at least: one change is a step, none is scatter.

    ``switching`` is the posterior mean probability that the state changes from one cycle to the
    next; ``lower``, ``upper`` (n,) and ``leave`` (2,) are those of the likeliest levels and chain.
    """

    log_bf: FloatArray
    switching: float
    lower: FloatArray
    upper: FloatArray
    leave: FloatArray

    @property
    def share_upper(self) -> FloatArray:
        """Probability of the upper level in each cycle given all of them, shape (n,)."""
        return _smoothed(self.lower, self.upper, self.leave)


def can_show_two(y: FloatArray, division: float) -> bool:
    """Whether readings y (n,) spread as far as the scatter that rounding alone leaves.

    Closer ones, such as what an effect leaves of readings finer than their stated division, lie on
    one level: `between_levels` has nothing to try.
    """
    return float(np.ptp(y)) >= rounding_uncertainty(division)


@dataclass(frozen=True, eq=False, slots=True)
class _Grid:
    """Levels (l, 1) and scatters (s,); of each cell the log prior and its places in their table."""

    levels: FloatArray
    scatters: FloatArray
    lower: IntArray
    upper: IntArray
    log_prior: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class BetweenLevels:
    """Log likelihoods (n, cells) of readings in either level of many pairs, the larger of them 0.

    A cell is a pair with a scatter; ``log_scale`` (cells,) is the log of the most that it can
    weigh, against scatter alone.
    """

    log_lower: FloatArray
    log_upper: FloatArray
    log_scale: FloatArray

    @property
    def log_most(self) -> float:
        """What no chain's log Bayes factor exceeds."""
        return float(np.logaddexp.reduce(self.log_scale))

    def under(self, chains: Sequence[Chain]) -> TwoLevels:
        """Return the evidence for each chain, and the likeliest course."""
        p, q = np.array([(c.leave_lower, c.leave_upper) for c in chains]).T
        lower, upper = np.exp(self.log_lower), np.exp(self.log_upper)
        likely = log_likelihood(lower, upper, p, q)
        settled, odds = _at_most_one_change(lower, upper, p, q)
        changing = np.maximum(-np.expm1(np.minimum(settled - likely, 0.0)), _TINY)
        log_weight = likely + np.log(changing) - np.log1p(-odds)[:, np.newaxis] + self.log_scale
        peak = log_weight.max()
        weight = np.exp(log_weight - peak)
        by_chain = weight.sum(axis=1)
        log_bf = peak + np.log(np.maximum(by_chain, _TINY))
        c, cell = np.unravel_index(np.argmax(weight), weight.shape)
        switching = float((2 * p * q / (p + q)) @ by_chain / by_chain.sum())
        leave = np.array([p[c], q[c]])
        return TwoLevels(log_bf, switching, lower[:, cell], upper[:, cell], leave)


def between_levels(y: FloatArray, division: float, *, known: float = 0.0) -> BetweenLevels:
    """Return readings y (n,) between two levels; nan marks a cycle that is not seen.

    ``division`` is the dial's, 0 where there is none: rounding keeps the scatter from being smaller
    than division / sqrt(12), and y `can_show_two` beside it. ``known`` are squares as in
    `evidence.Views`, 0 for a scatter that is not known. Even states drawn by lot reach 2^-n of the
    most that a cell can weigh, so cells far below the largest are left out.
    """
    unseen = ~np.isfinite(y)
    seen = y[~unseen]
    grid = _grid(seen, division, known)
    shown, at = np.unique(np.where(unseen, 0.0, y), return_inverse=True)
    of_shown = _log_density(shown[:, None, None], grid.levels, grid.scatters, division)
    density = of_shown.reshape(len(shown), -1)[at]
    density[unseen] = 0.0
    log_lower, log_upper = density.take(grid.lower, axis=1), density.take(grid.upper, axis=1)
    peak = np.maximum(log_lower, log_upper)
    most = peak.sum(axis=0) + grid.log_prior
    kept = np.flatnonzero(most > most.max() - len(y) * np.log(2) - _NEGLIGIBLE)
    lower, upper = ((one - peak).take(kept, axis=1) for one in (log_lower, log_upper))
    return BetweenLevels(lower, upper, most[kept] - _log_scatter_alone(seen, known, division))


def _grid(seen: FloatArray, division: float, known: float) -> _Grid:
    levels = np.linspace(seen.min(), seen.max(), _LEVELS)
    scatter = np.maximum(seen.std(ddof=1) * _SCATTERS, rounding_uncertainty(division))
    a, b = _PAIRS
    distance = (levels[b] - levels[a])[:, np.newaxis] / scatter
    density = np.log(2 / (SPLIT_SCALE * np.sqrt(2 * np.pi))) - (distance / SPLIT_SCALE) ** 2 / 2
    cell = 2 * np.log(levels[1] - levels[0]) + np.log(np.log(_SCATTERS[1] / _SCATTERS[0]))
    pair, s = np.nonzero(distance >= 1)
    log_prior = density[pair, s] - np.log(scatter[s]) + cell
    if known:
        log_prior -= (KNOWN_FROM - 1) * np.log(scatter[s]) + known / (2 * scatter[s] ** 2)
    row = len(scatter)
    return _Grid(levels[:, np.newaxis], scatter, a[pair] * row + s, b[pair] * row + s, log_prior)


def _log_density(
    y: FloatArray, level: FloatArray, scatter: FloatArray, division: float
) -> FloatArray:
    """Return that of readings about a level: of the division that each rounds to, over its width.

    Far from the level, where that vanishes, it is the density itself.
    """
    exact = -0.5 * ((y - level) / scatter) ** 2 - np.log(scatter * np.sqrt(2 * np.pi))
    if not division:
        return np.asarray(exact)
    apart = -np.abs(y - level)
    p = normal_cdf((apart + division / 2) / scatter) - normal_cdf((apart - division / 2) / scatter)
    return np.where(p > _TINY, np.log(np.maximum(p, _TINY) / division), exact)


def log_likelihood(
    lower: FloatArray, upper: FloatArray, p: FloatArray, q: FloatArray
) -> FloatArray:
    """Return the log likelihood (chains, cells) of readings for the chains p, q (chains,).

    ``lower`` and ``upper`` are (n, cells). Where p + q = 1 the next state does not depend on the
    last one, and the likelihood is a product.
    """
    remembers = np.abs(p + q - 1) > _NO_MEMORY
    found = np.empty((len(p), lower.shape[1]))
    above, apart = p / (p + q), upper - lower
    for c in np.flatnonzero(~remembers):
        found[c] = _log_of_product(lower + above[c] * apart)
    if remembers.any():
        p, q = p[remembers, np.newaxis], q[remembers, np.newaxis]
        found[remembers] = _forward(lower, upper, p, q)
    return found


def _log_of_product(likely: FloatArray) -> FloatArray:
    """Return the logarithm (cells,) of the product of likelihoods (n, cells).

    The larger of the two that each is a mean of is 1, so that none of _FACTORS vanishes.
    """
    parts = [likely[k : k + _FACTORS] for k in range(0, len(likely), _FACTORS)]
    return np.asarray(sum(np.log(np.multiply.reduce(part)) for part in parts))


def _forward(lower: FloatArray, upper: FloatArray, p: FloatArray, q: FloatArray) -> FloatArray:
    """Return the log likelihood of the readings for chains (chains, 1), shape (chains, cells)."""
    below, above = (np.repeat(start / (p + q), lower.shape[1], axis=1) for start in (q, p))
    log_scale = np.zeros_like(below)
    for j, (low, up) in enumerate(zip(lower, upper, strict=True)):
        below *= low
        above *= up
        if j % _BEFORE_UNDERFLOW == 0:
            both = below + above
            log_scale += np.log(both + _TINY)
            below /= both
            above /= both
        moved = p * below
        moved -= q * above
        below -= moved
        above += moved
    return np.asarray(log_scale + np.log(below + above + _TINY))


def _at_most_one_change(
    lower: FloatArray, upper: FloatArray, p: FloatArray, q: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the log likelihood (chains, cells) of every course with one change or none.

    Weighted by the courses' probabilities under the chains p, q (chains,); their sum is (chains,).
    """
    n = len(lower)
    odds = np.stack([_odds_of_one(p, q, n), _odds_of_one(q, p, n)], axis=1)
    courses = np.stack([_changed_once(lower, upper), _changed_once(upper, lower)])
    summed = np.tensordot(odds, courses, axes=([1, 2], [0, 1]))
    return np.log(np.maximum(summed, _TINY)), odds.sum(axis=(1, 2))


def _odds_of_one(leave: FloatArray, back: FloatArray, n: int) -> FloatArray:
    """Return the probability (chains, n) of k = 1 .. n cycles in one state, the rest in the other.

    ``leave`` and ``back`` (chains,) are the chances of leaving either state.
    """
    k = np.arange(1, n + 1)
    leave, back = leave[:, np.newaxis], back[:, np.newaxis]
    stays = back / (leave + back) * (1 - leave) ** (k - 1)
    return np.asarray(stays * np.where(k < n, leave * (1 - back) ** np.maximum(n - 1 - k, 0), 1.0))


def _changed_once(first: FloatArray, then: FloatArray) -> FloatArray:
    """Return the likelihood of ``first`` for k cycles and ``then`` afterwards, k = 1 .. n.

    One that vanishes is no loss: some course has at every cycle the larger likelihood, which is 1.
    """
    after = np.ones_like(then)
    after[:-1] = np.multiply.accumulate(then[:0:-1], axis=0)[::-1]
    return np.asarray(np.multiply.accumulate(first, axis=0) * after)


def _smoothed(lower: FloatArray, upper: FloatArray, leave: FloatArray) -> FloatArray:
    """Return the probability of the upper level given all cycles, shape (n,)."""
    p, q = leave
    change = np.array([[1 - p, p], [q, 1 - q]])
    emitted = np.stack([lower, upper], axis=1)
    share, back = np.empty_like(emitted), np.empty_like(emitted)
    ahead, behind = np.array([q, p]) / (p + q), np.ones(2)
    for j, emission in enumerate(emitted):
        share[j] = ahead * emission / (ahead @ emission)
        ahead = share[j] @ change
    for j in range(len(emitted) - 1, -1, -1):
        back[j] = behind
        behind = change @ (emitted[j] * behind)
        behind = behind / behind.sum()
    both = share * back
    return np.asarray(both[:, 1] / both.sum(axis=1))


def _log_scatter_alone(seen: FloatArray, known: float, division: float) -> float:
    """Return the log marginal likelihood of one level under the prior 1 / scatter."""
    nu = len(seen) - 1
    m = nu + (KNOWN_FROM - 1 if known else 0)
    S = float(((seen - seen.mean()) ** 2).sum()) + known
    free = lgamma(m / 2) - nu / 2 * np.log(2 * np.pi) - m / 2 * np.log(S / 2)
    return float(free - 0.5 * np.log(nu + 1) - np.log(2)) + _rounding_of_one_level(seen, division)


def _rounding_of_one_level(seen: FloatArray, division: float) -> float:
    """Return how much likelier readings are as rounded than as exact about their mean.

    Their scatter is that beside rounding (Sheppard's correction), at least a fifth of a division.
    """
    if not division:
        return 0.0
    variance = float(seen.var(ddof=1))
    left = max(variance - division**2 / 12, division**2 / 25)
    level = np.array([seen.mean()])
    rounded = _log_density(seen, level, np.array([left**0.5]), division)
    return float((rounded - _log_density(seen, level, np.array([variance**0.5]), 0.0)).sum())


@dataclass(frozen=True, eq=False, slots=True)
class Emissions:
    """Likelihood (n, axes) of each reading in the lower and the upper state, the larger of them 1.

    Levels and scatter are those of the best split of the sorted readings, which no order changes.
    """

    lower: FloatArray
    upper: FloatArray
    chains: Sequence[Chain]

    def persistence(self, orders: IntArray) -> FloatArray:
        """Return how much likelier states under the chains make each order (m, n), shape (m,).

        Against states drawn anew in each cycle: the mean likelihood ratio over chains and axes.
        """
        weight = np.array([chain.weight for chain in self.chains])
        p = np.array([chain.leave_lower for chain in self.chains])
        q = np.array([chain.leave_upper for chain in self.chains])
        lower, upper = (e[orders.T].reshape(len(e), -1) for e in (self.lower, self.upper))
        log_order = log_likelihood(lower, upper, p, q).reshape(len(p), len(orders), -1)
        start = (q / (p + q))[:, np.newaxis, np.newaxis]
        none = np.log(start * self.lower + (1 - start) * self.upper).sum(axis=1)[:, np.newaxis]
        ratio = np.exp(log_order - none).mean(axis=2)
        return np.asarray(weight / weight.sum() @ ratio)


def emissions_of(values: FloatArray, division: FloatArray, chains: Sequence[Chain]) -> Emissions:
    """Return how likely each of the readings (n, axes) is in either state of its axis.

    The scatter is at least 0.6 of the ``division`` (axes,): that of a finer one would be the
    dial's alone.
    """
    n, axes = values.shape
    centred = values - values.mean(axis=0)
    ranked = np.sort(centred, axis=0)
    below = np.arange(FEWEST_ON_A_LEVEL, n - FEWEST_ON_A_LEVEL + 1)[:, np.newaxis]
    sums = np.cumsum(ranked, axis=0)
    between = sums[below[:, 0] - 1] ** 2 * n / (below * (n - below))
    k = below[between.argmax(axis=0), 0]
    squares = (ranked**2).sum(axis=0)
    within = np.maximum(squares - between.max(axis=0), 1e-12 * squares)
    scatter = np.maximum(np.sqrt(within / (n - 2)), LEAST_SCATTER * division)
    lowest = sums[k - 1, np.arange(axes)]
    levels = np.stack([lowest / k, -lowest / (n - k)])[:, np.newaxis]
    density = -0.5 * ((centred - levels) / scatter) ** 2
    lower, upper = np.exp(density - density.max(axis=0))
    return Emissions(lower, upper, chains)
