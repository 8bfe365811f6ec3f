"""Two levels under a hidden chain of sides: evidence, and the course of sides.

The load rests on either of two flanks; which one is a two-state Markov chain (`Chain`). Both
levels and the scatter are integrated out on a grid, the sides by the forward algorithm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import lgamma

import numpy as np

from scara_iso.effects import Chain
from scara_iso.run import FloatArray

_LEVELS = 14
_SCATTERS = np.geomspace(0.12, 1.05, 10)
"""Scatters tried, over the standard deviation of the readings."""

_SPLIT_SCALE = 4.0
"""Half-normal prior of the distance of the levels, in scatters; below 1 they are one level."""


@dataclass(frozen=True, eq=False, slots=True)
class TwoLevels:
    """Log Bayes factor of each chain against scatter alone, and the likeliest course.

    ``share_upper`` (n,) is the probability of the upper level in each cycle, ``switching`` the
    posterior mean probability that the side changes from one cycle to the next.
    """

    log_bf: FloatArray
    share_upper: FloatArray
    switching: float


@dataclass(frozen=True, eq=False, slots=True)
class _Grid:
    lower: FloatArray
    upper: FloatArray
    scatter: FloatArray
    log_prior: FloatArray


def two_levels(y: FloatArray, division: float, chains: Sequence[Chain]) -> TwoLevels:
    """Return the evidence for two levels in readings y (n,); nan marks a cycle that is not seen.

    ``division`` is the dial's: rounding keeps the scatter from being smaller than division /
    sqrt(12).
    """
    seen = y[np.isfinite(y)]
    grid = _grid(seen, division)
    lower, upper, scale = _emissions(y, grid)
    leave = np.array([(c.leave_lower, c.leave_upper) for c in chains])[:, :, None, None]
    forward, log_scale = _forward(lower, upper, leave[:, 0], leave[:, 1])
    log_weight = log_scale + scale + grid.log_prior
    peak = log_weight.max()
    weight = np.exp(log_weight - peak)
    log_bf = peak + np.log(np.maximum(weight.sum(axis=(1, 2)), 1e-300)) - _log_scatter_alone(seen)
    c, pair, s = np.unravel_index(np.argmax(weight), weight.shape)
    share = _smoothed(
        lower[:, pair, s], upper[:, pair, s], forward[:, c, pair, s], leave[c, :, 0, 0]
    )
    p = leave[:, :, 0, 0]
    switching = 2 * p[:, 0] * p[:, 1] / p.sum(axis=1)
    by_chain = weight.sum(axis=(1, 2))
    return TwoLevels(log_bf, share, float(switching @ by_chain / by_chain.sum()))


def _grid(seen: FloatArray, division: float) -> _Grid:
    levels = np.linspace(seen.min(), seen.max(), _LEVELS)
    scatter = np.maximum(seen.std(ddof=1) * _SCATTERS, division / np.sqrt(12))
    a, b = np.triu_indices(_LEVELS, 1)
    distance = (levels[b] - levels[a])[:, np.newaxis] / scatter
    density = np.log(2 / (_SPLIT_SCALE * np.sqrt(2 * np.pi))) - (distance / _SPLIT_SCALE) ** 2 / 2
    cell = 2 * np.log(levels[1] - levels[0]) + np.log(np.log(_SCATTERS[1] / _SCATTERS[0]))
    log_prior = np.where(distance < 1, -np.inf, density - np.log(scatter) + cell)
    return _Grid(levels[a], levels[b], scatter, log_prior)


def _emissions(y: FloatArray, grid: _Grid) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return likelihoods of either level, (n, pairs, scatters), and the log of their scale."""
    unseen = ~np.isfinite(y)
    reading = np.where(unseen, 0.0, y)[:, np.newaxis, np.newaxis]
    log_lower = -0.5 * ((reading - grid.lower[:, np.newaxis]) / grid.scatter) ** 2
    log_upper = -0.5 * ((reading - grid.upper[:, np.newaxis]) / grid.scatter) ** 2
    log_lower[unseen] = log_upper[unseen] = 0.0
    peak = np.maximum(log_lower, log_upper)
    scale = peak.sum(axis=0) - (~unseen).sum() * np.log(grid.scatter * np.sqrt(2 * np.pi))
    return np.exp(log_lower - peak), np.exp(log_upper - peak), scale


def _forward(
    lower: FloatArray, upper: FloatArray, p: FloatArray, q: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return filtered probabilities of the upper level (n, chains, pairs, scatters), log scale."""
    below, above = q / (p + q) * lower[0], p / (p + q) * upper[0]
    filtered = np.empty((len(lower), *below.shape))
    log_scale = np.zeros_like(below)
    for j in range(len(lower)):
        if j:
            below, above = (
                (below * (1 - p) + above * q) * lower[j],
                (below * p + above * (1 - q)) * upper[j],
            )
        total = below + above + 1e-300
        below, above = below / total, above / total
        log_scale += np.log(total)
        filtered[j] = above
    return filtered, log_scale


def _smoothed(
    lower: FloatArray, upper: FloatArray, filtered: FloatArray, leave: FloatArray
) -> FloatArray:
    """Return the probability of the upper level given all cycles, shape (n,)."""
    p, q = leave
    share = np.array(filtered)
    back_lower = back_upper = 1.0
    for j in range(len(lower) - 2, -1, -1):
        to_lower, to_upper = lower[j + 1] * back_lower, upper[j + 1] * back_upper
        back_lower = (1 - p) * to_lower + p * to_upper
        back_upper = q * to_lower + (1 - q) * to_upper
        back_lower, back_upper = np.array([back_lower, back_upper]) / (back_lower + back_upper)
        above = filtered[j] * back_upper
        share[j] = above / (above + (1 - filtered[j]) * back_lower)
    return share


def _log_scatter_alone(seen: FloatArray) -> float:
    """Return the log marginal likelihood of one level under the prior 1 / scatter."""
    nu = len(seen) - 1
    S = float(((seen - seen.mean()) ** 2).sum())
    return float(lgamma(nu / 2) - nu / 2 * np.log(np.pi * S) - 0.5 * np.log(nu + 1) - np.log(2))
