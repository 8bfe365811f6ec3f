"""Evidence that grows with every reading, valid whenever it is looked at: a test martingale.

The rank of each new reading among all before it is uniform and independent of the earlier ranks
wherever the readings are exchangeable, whatever their distribution (Renyi 1962; Vovk, Gammerman and
Shafer 2005). Each hypothesis bets on where the next reading will lie; a mixture of bets is a
martingale that starts at 1, and reaches 20 with a probability of at most 1/20 for ever (Ville).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from scara_iso.run import FloatArray, IntArray

_CELLS = 64
"""A bet is constant in so many equal parts of the ranks."""
_GRID = np.linspace(-8.0, 14.0, 441)
"""Where the distribution of the earlier readings is followed, in scatters."""
_STEPS = (1.5, 2.5, 4.0)
"""Sizes of a step, in scatters (benchmarks/watch.py, as all figures here)."""
_SHARES = np.linspace(0.0, 1.0, 65)
"""Of the earlier readings, how many lie behind the step."""
_STEP_WEIGHT = 0.5
_EARLY = 20.0
"""Half of the weight of all steps is on the first so many readings."""
_TAUS, _WARM_UPS, _WARM_UP_WEIGHT = (3.0, 6.0, 12.0), (2.5, 4.5), 0.2
_SPANS, _RAMP, _RAMP_WEIGHT = (30.0, 100.0, 300.0, 1000.0), 4.5, 0.15
_ALTERNATIONS, _ALTERNATION_WEIGHT = (1.5, 3.0), 0.15
_SURE = 0.99
"""A bet keeps the rest back, so that no single reading loses everything."""
_LARGEST_LOG = 300.0


class EProcess:
    """The evidence of each of several channels; their mean is one too, however they hang together.

    `take` wants, reading by reading, each channel's rank among its own readings as a number from 0
    to 1, uniform within the rank.
    """

    def __init__(self, channels: int) -> None:
        courses = len(_course_weights())
        self._steps = np.zeros((channels, 0, 2, len(_STEPS)))
        self._courses = np.zeros((channels, 2, courses))
        self._before = np.zeros((courses, len(_GRID)))
        self._taken = 0

    def take(self, ranks: FloatArray) -> FloatArray:
        """Return the evidence (channels,) with the next reading's ``ranks`` (channels,)."""
        n = self._taken
        here = _courses_at(n)
        ahead = np.stack([np.interp(_GRID - size, _GRID, _normal()) for size in here])
        self._steps = np.pad(self._steps, ((0, 0), (0, 1), (0, 0), (0, 0)))
        if n:
            cells = np.stack([_cell(ranks), _cell(1.0 - ranks)], axis=1)
            self._steps += np.log(_step_bets(n, cells)).transpose(2, 0, 3, 1)
            bets = np.stack([_bet(b / n, a) for b, a in zip(self._before, ahead, strict=True)])
            self._courses += np.log(bets[:, cells]).transpose(1, 2, 0)
        self._before += ahead
        self._taken = n + 1
        return self._evidence()

    def _evidence(self) -> FloatArray:
        """Return the mean over directions, courses, and the cycles where a step began."""
        n = self._taken
        begun = _EARLY / (_EARLY + np.arange(n))
        weights = np.append(0.0, begun[:-1] - begun[1:])
        steps = np.exp(np.minimum(self._steps, _LARGEST_LOG)).mean(axis=(2, 3))
        courses = np.exp(np.minimum(self._courses, _LARGEST_LOG)).mean(axis=1)
        by_step = steps @ weights + begun[-1]
        return np.asarray(_STEP_WEIGHT * by_step + courses @ _course_weights())


def _cell(ranks: FloatArray) -> IntArray:
    return np.minimum((ranks * _CELLS).astype(np.int64), _CELLS - 1)


def _bet(before: FloatArray, ahead: FloatArray) -> FloatArray:
    """Return the bet on the rank of a reading distributed as ``ahead`` among those ``before``.

    Both are distribution functions over the grid. The bet is the probability of each part of the
    ranks over that of scatter alone, so its mean is 1.
    """
    edges = np.interp(np.arange(1, _CELLS) / _CELLS, before, _GRID)
    below = np.concatenate([[0.0], np.interp(edges, _GRID, ahead), [1.0]])
    return np.asarray(_SURE * np.diff(below) * _CELLS + (1.0 - _SURE))


def _step_bets(n: int, cells: IntArray) -> FloatArray:
    """Return the bets (n + 1, sizes, ..) on ``cells`` after ``n`` readings, by the step's begin."""
    place = (n - np.arange(n + 1)) / n * (len(_SHARES) - 1)
    lower = np.minimum(place.astype(np.int64), len(_SHARES) - 2)
    table = _step_table()[:, :, cells]
    upper_share = (place - lower).reshape(-1, *(1,) * (table.ndim - 1))
    return np.asarray((1 - upper_share) * table[lower] + upper_share * table[lower + 1])


@cache
def _step_table() -> FloatArray:
    """Return the bets (shares, sizes, cells) on a reading behind a step."""
    normal = _normal()
    behind = [np.interp(_GRID - size, _GRID, normal) for size in _STEPS]
    return np.array(
        [[_bet((1 - share) * normal + share * b, b) for b in behind] for share in _SHARES]
    )


@cache
def _normal() -> FloatArray:
    return np.array([0.5 * math.erfc(-y / math.sqrt(2.0)) for y in _GRID.tolist()])


@cache
def _course_weights() -> FloatArray:
    """Return the weight of each course that `_courses_at` gives."""
    kinds = (
        (len(_TAUS) * len(_WARM_UPS), _WARM_UP_WEIGHT),
        (len(_SPANS), _RAMP_WEIGHT),
        (len(_ALTERNATIONS), _ALTERNATION_WEIGHT),
    )
    return np.concatenate([np.full(count, weight / count) for count, weight in kinds])


def _courses_at(k: int) -> FloatArray:
    """Return how far each course has gone at reading ``k`` from 0, in scatters."""
    warm = [size * -math.expm1(-k / tau) for tau in _TAUS for size in _WARM_UPS]
    ramps = [_RAMP * min(k / span, 1.0) for span in _SPANS]
    return np.array([*warm, *ramps, *(size * (k % 2) for size in _ALTERNATIONS)])
