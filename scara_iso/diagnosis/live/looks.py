"""Looks at a test of planned length while it runs: a group-sequential test of the cycles' order.

At every look the readings so far are ranked and their order is tested by permuting whole cycles,
which is exact whatever the distribution. The levels of the looks together are spent as O'Brien and
Fleming (1979) do: little early, nearly all at the end.
"""

from __future__ import annotations

from functools import cache
from statistics import NormalDist

import numpy as np

from scara_iso.diagnosis.likelihood.evidence import views_of
from scara_iso.diagnosis.likelihood.hypotheses import hypotheses_of
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build, constant
from scara_iso.diagnosis.significance.permutation import order_test
from scara_iso.diagnosis.tuning import FEWEST_CYCLES
from scara_iso.effects import Conditions, find_effects
from scara_iso.run import FloatArray, IntArray

ALARM = 20.0
"""Evidence at which it is said that something acts: one over the level."""
MOST_PLANNED = 60
"""A test of more cycles is watched as one of open length: looks would wait a third of it."""
_FIRST, _EVERY = 10, 2
_BOUNDARY = 2.05
"""A look after a share t of the readings is an alarm from the normal quantile of p that is this
over the root of t. All looks together then reach it in 4.0 to 4.5 % of tests of 20 to 60 readings,
and with several channels in no more than 5 % (benchmarks/watch.py)."""
_PERMUTATIONS = 1999
_NORMAL = NormalDist()


def is_look(taken: int, planned: int) -> bool:
    """Say whether there is a look after ``taken`` of ``planned`` readings."""
    due = taken >= _FIRST and (taken - _FIRST) % _EVERY == 0
    return FEWEST_CYCLES <= taken <= planned and (due or taken == planned)


def look(values: FloatArray, noise: FloatArray, planned: int, rng: np.random.Generator) -> float:
    """Return the evidence of one look at the readings so far, ``values`` (n, channels).

    ``noise`` of the same shape breaks ties: each reading keeps its own at every look. The largest
    evidence of all looks reaches `ALARM` in at most 5 % of tests in which nothing acts.
    """
    n = len(values)
    hypotheses = _hypotheses(n)
    views = views_of(normal_scores(values, noise), hypotheses.basis)
    p = order_test(hypotheses, views, rng, permutations=_PERMUTATIONS).p_value
    return evidence_of(p, n / planned)


def evidence_of(p: float, share: float) -> float:
    """Return the evidence of a look's p-value after a ``share`` of the readings."""
    reached = -_NORMAL.inv_cdf(min(p, 0.5)) * share**0.5
    return ALARM * _NORMAL.cdf(-_BOUNDARY) / _NORMAL.cdf(-reached)


def normal_scores(values: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the normal scores of each channel's ranks, shape (n, channels)."""
    order = np.lexsort((noise, values), axis=0)
    return np.asarray(_scores(len(values))[np.argsort(order, axis=0)])


@cache
def _scores(n: int) -> FloatArray:
    return np.array([_NORMAL.inv_cdf((rank + 0.5) / n) for rank in range(n)])


@cache
def _hypotheses(n: int) -> HypothesisSet:
    """Return what the test compares after ``n`` readings."""
    rows: IntArray = np.arange(n)
    every = hypotheses_of(find_effects(), Conditions(rows + 1, {}))
    members = [member for member in every if member.test_weight]
    return build([m for m in members if m.ordered], rows, constant(n))
