"""Two levels between which hidden states change: the load rests on either of two flanks, unseen.

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
from math import lgamma
from typing import NamedTuple

import numpy as np

from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.diagnosis.engine.rounded import KNOWN_FROM, log_density
from scara_iso.effects import Chain
from scara_iso.run import FloatArray, IntArray

_LEVELS = 14
_PAIRS = np.triu_indices(_LEVELS, 1)
_SCATTERS = np.geomspace(0.12, 1.05, 10)
"""Scatters tried, over the standard deviation of the readings."""
_BEFORE_UNDERFLOW = 8
_TINY = 1e-300
_NEGLIGIBLE = 40.0
"""Log of how much less likely than the likeliest a cell is that cannot change a digit."""

FEWEST_ON_A_LEVEL = 4
"""Fewer readings than this are no level of their own."""

SPLIT_SCALE = 4.0
"""Half-normal prior of the distance of two levels, in scatters; below 1 they are one level."""

LEAST_SCATTER = 0.6
"""Scatter about either of two levels, in divisions: that of a finer one would be the dial's."""


class TwoLevels(NamedTuple):
    """Log Bayes factor of each chain against scatter alone, and the likeliest course.

    The chain changes its state twice at least: one change is a step, none is scatter.

    ``switching`` is the posterior mean probability that the state changes from one cycle to the
    next; ``share_upper`` (n,) the probability of the upper level in each cycle given all of them,
    under the likeliest levels and chain.
    """

    log_bf: FloatArray
    switching: float
    share_upper: FloatArray


def two_levels(
    y: FloatArray, division: float, chains: Sequence[Chain], *, known: float = 0.0
) -> TwoLevels | None:
    """Return the evidence that readings y (n,) lie on two levels; nan marks an unseen cycle.

    ``division`` is the dial's, 0 where there is none: rounding keeps the scatter from being smaller
    than division / sqrt(12), and readings that spread no farther lie on one level (None). ``known``
    are squares as in `evidence.Views`. Cells far below the most that the largest can weigh are left
    out.
    """
    unseen = ~np.isfinite(y)
    seen = y[~unseen]
    least = rounding_uncertainty(division)
    if not np.ptp(seen) or np.ptp(seen) < least:
        return None
    p, q = np.array([(c.leave_lower, c.leave_upper) for c in chains]).T
    levels = np.linspace(seen.min(), seen.max(), _LEVELS)
    scatter = np.maximum(seen.std(ddof=1) * _SCATTERS, least)
    lower, upper, log_prior = _cells(levels, scatter, known)
    if not lower.size:
        return None
    shown, at = np.unique(np.where(unseen, 0.0, y), return_inverse=True)
    of_shown = log_density(shown[:, None, None], levels[:, None], scatter, division)
    density = of_shown.reshape(len(shown), -1)[at]
    density[unseen] = 0.0
    low, up = density[:, lower], density[:, upper]
    peak = np.maximum(low, up)
    most = peak.sum(axis=0) + log_prior
    kept = most > most.max() - len(y) * np.log(2) - _NEGLIGIBLE
    low, up = np.exp(low - peak)[:, kept], np.exp(up - peak)[:, kept]
    beside = most[kept] - _log_scatter_alone(seen, known, division)
    likely = log_likelihood(low, up, p, q)
    settled, odds = _at_most_one_change(low, up, p, q)
    changing = np.maximum(-np.expm1(np.minimum(settled - likely, 0.0)), _TINY)
    log_weight = likely + np.log(changing) - np.log1p(-odds)[:, np.newaxis] + beside
    highest = log_weight.max()
    weight = np.exp(log_weight - highest)
    by_chain = weight.sum(axis=1)
    c, cell = np.unravel_index(np.argmax(weight), weight.shape)
    switching = float((2 * p * q / (p + q)) @ by_chain / by_chain.sum())
    share = _smoothed(low[:, cell], up[:, cell], float(p[c]), float(q[c]))
    return TwoLevels(highest + np.log(np.maximum(by_chain, _TINY)), switching, share)


def _cells(
    levels: FloatArray, scatter: FloatArray, known: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return for each pair of levels with a scatter the places of either, and the log prior."""
    a, b = _PAIRS
    distance = (levels[b] - levels[a])[:, np.newaxis] / scatter
    density = np.log(2 / (SPLIT_SCALE * np.sqrt(2 * np.pi))) - (distance / SPLIT_SCALE) ** 2 / 2
    cell = 2 * np.log(levels[1] - levels[0]) + np.log(np.log(_SCATTERS[1] / _SCATTERS[0]))
    pair, s = np.nonzero(distance >= 1)
    log_prior = density[pair, s] - np.log(scatter[s]) + cell
    if known:
        log_prior -= (KNOWN_FROM - 1) * np.log(scatter[s]) + known / (2 * scatter[s] ** 2)
    return a[pair] * len(scatter) + s, b[pair] * len(scatter) + s, log_prior


def log_likelihood(
    lower: FloatArray, upper: FloatArray, p: FloatArray, q: FloatArray
) -> FloatArray:
    """Return the log likelihood (chains, cells) of readings for the chains p, q (chains,).

    ``lower`` and ``upper`` are (n, cells).
    """
    p, q = p[:, np.newaxis], q[:, np.newaxis]
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
    A likelihood that vanishes is no loss: some course has the larger likelihood, 1, at every cycle.
    """
    n, k = len(lower), np.arange(1, len(lower) + 1)
    odds, summed = np.zeros(len(p)), np.zeros((len(p), lower.shape[1]))
    p, q = p[:, np.newaxis], q[:, np.newaxis]
    for first, then, leave, back in ((lower, upper, p, q), (upper, lower, q, p)):
        stays = back / (leave + back) * (1 - leave) ** (k - 1)
        once = stays * np.where(k < n, leave * (1 - back) ** np.maximum(n - 1 - k, 0), 1.0)
        after = np.ones_like(then)
        after[:-1] = np.multiply.accumulate(then[:0:-1], axis=0)[::-1]
        summed += once @ (np.multiply.accumulate(first, axis=0) * after)
        odds += once.sum(axis=1)
    return np.log(np.maximum(summed, _TINY)), odds


def _smoothed(lower: FloatArray, upper: FloatArray, p: float, q: float) -> FloatArray:
    """Return the probability of the upper level given all cycles, shape (n,)."""
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
    """Return the log marginal likelihood of one level under the prior 1 / scatter.

    On a dial, with how much likelier the readings are as rounded than as exact about their mean;
    their scatter is that beside rounding (Sheppard's correction), at least a fifth of a division.
    """
    nu = len(seen) - 1
    m = nu + (KNOWN_FROM - 1 if known else 0)
    S = float(((seen - seen.mean()) ** 2).sum()) + known
    exact = lgamma(m / 2) - nu / 2 * np.log(2 * np.pi) - m / 2 * np.log(S / 2)
    exact -= 0.5 * np.log(nu + 1) + np.log(2)
    if not division:
        return float(exact)
    variance = float(seen.var(ddof=1))
    left = max(variance - division**2 / 12, division**2 / 25)
    level = np.array([seen.mean()])
    rounded = log_density(seen, level, np.array([left**0.5]), division)
    unrounded = log_density(seen, level, np.array([variance**0.5]), 0.0)
    return float(exact + (rounded - unrounded).sum())


class Emissions(NamedTuple):
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
        weight, p, q = np.array([(c.weight, c.leave_lower, c.leave_upper) for c in self.chains]).T
        lower, upper = (e[orders.T].reshape(len(e), -1) for e in (self.lower, self.upper))
        log_order = log_likelihood(lower, upper, p, q).reshape(len(p), len(orders), -1)
        start = (q / (p + q))[:, np.newaxis, np.newaxis]
        none = np.log(start * self.lower + (1 - start) * self.upper).sum(axis=1)[:, np.newaxis]
        ratio = np.exp(log_order - none).mean(axis=2)
        return np.asarray(weight / weight.sum() @ ratio)


def emissions_of(values: FloatArray, division: FloatArray, chains: Sequence[Chain]) -> Emissions:
    """Return how likely each of the readings (n, axes) is in either state of its axis.

    The scatter is at least LEAST_SCATTER of the ``division`` (axes,): that of a finer one would be
    the dial's alone.
    """
    n, axes = values.shape
    centred = values - values.mean(axis=0)
    below, between, ranked = split(centred)
    k = below[between.argmax(axis=0)]
    squares = (ranked**2).sum(axis=0)
    within = np.maximum(squares - between.max(axis=0), 1e-12 * squares)
    scatter = np.maximum(np.sqrt(within / (n - 2)), LEAST_SCATTER * division)
    lowest = np.cumsum(ranked, axis=0)[k - 1, np.arange(axes)]
    levels = np.stack([lowest / k, -lowest / (n - k)])[:, np.newaxis]
    density = -0.5 * ((centred - levels) / scatter) ** 2
    lower, upper = np.exp(density - density.max(axis=0))
    return Emissions(lower, upper, chains)


def split(centred: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return how many readings may lie on the lower level (s,), and the squares between both.

    That is of each split of the sorted readings (n, ...), shape (s, ...), no level of fewer than
    FEWEST_ON_A_LEVEL; and the sorted readings.
    """
    n, k = len(centred), FEWEST_ON_A_LEVEL
    ranked = np.sort(centred, axis=0)
    below = np.arange(k, n - k + 1)
    on = below.reshape(-1, *[1] * (centred.ndim - 1))
    between = np.cumsum(ranked, axis=0)[k - 1 : n - k] ** 2 * n / (on * (n - on))
    return below, between, ranked
