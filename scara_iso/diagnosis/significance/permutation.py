"""Is there an order in the cycles? An exact test by permuting them.

Where there is nothing but scatter the cycles are exchangeable, whatever the distribution, rounding
and correlation of the axes; so the statistic of the cycles as measured ranks among those of
permuted ones by chance. After a fit the residuals are permuted (Freedman and Lane 1983).

For scatter that changes from some cycle on ranks are added: each reading's distance from the
median has the exponential score of its rank, -ln(1 - r / (n + 1)) (Savage 1956), which no tail
makes large.
The scores from a cycle on against those before it give a standard deviate z; a Bayes factor of it
against z of unit variance is averaged over the cycles. The axes count together, by the sum of their
scores, as much as each alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.likelihood.evidence import (
    Views,
    bayes_factors,
    largest_evidence,
    mean_evidence,
)
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet
from scara_iso.diagnosis.likelihood.two_state import Emissions
from scara_iso.diagnosis.tuning import (
    ENOUGH,
    ENOUGH_FURTHER,
    PERMUTATIONS,
    PERSISTENCE_SHARE,
    UNKNOWN_SHARE,
    WIDENING_SHARE,
)
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_EQUAL = 1e-9
_AT_FIRST = 128
"""Most tables are decided after as many orders; what comes next is as many as all before."""
_COLUMNS = 288
"""Views of orders compared at once: as many as leave the work in the processor's cache."""
ROUGH = 0.02
"""More than a statistic in single precision is off by, which is 0.0003 at most."""


@dataclass(frozen=True, eq=False, slots=True)
class OrderTest:
    """Statistic of the run, and the share of orders with one as large: its p-value."""

    statistic: float
    p_value: float
    at_floor: bool
    """No permutation came as far: the chance is at most p."""
    of_orders: FloatArray = field(default_factory=lambda: np.empty(0))
    """Statistics of the orders that were looked at, to five digits unless near that of the run."""

    def limit(self, level: float) -> float:
        """Return the statistic that a share ``level`` of the orders reach."""
        return float(np.quantile(self.of_orders, 1 - level)) if len(self.of_orders) else -np.inf


def order_test(
    hypotheses: HypothesisSet,
    views: Views,
    rng: np.random.Generator,
    *,
    emissions: Emissions | None = None,
    spreading: FloatArray | None = None,
    permutations: int = PERMUTATIONS,
    further: bool = False,
) -> OrderTest:
    """Return the test of the views' cycles against ``permutations`` of them.

    ``emissions`` are those of the axes that may show two states, ``spreading`` (n, axes) the
    residuals whose scatter may change.

    Axes stay together: one order serves all. Exact at any level when the set's basis is the
    constant pose; p is at least 1 / (permutations + 1). It ends with the ENOUGHth order whose
    statistic is as large, the l-th say: p = ENOUGH / l, no less valid for that (Besag and
    Clifford 1991), and below 0.05 just where all the orders would put it there. Of a ``further``
    effect ENOUGH_FURTHER are enough.
    """
    observed = order_statistic(hypotheses, views, emissions, spreading)
    enough = ENOUGH_FURTHER if further else ENOUGH
    exact = hypotheses, views
    rough = hypotheses.in_single_precision(), views.in_single_precision()
    found: list[FloatArray] = []
    reached, at_once = 0, max(1, _COLUMNS // views.columns.shape[1])
    for orders in _drawn(rng, len(views.columns), permutations):
        beside = _beside(emissions, spreading, orders)
        for block in (slice(k, k + at_once) for k in range(0, len(orders), at_once)):
            if reached < enough:
                found.append(_compared(exact, rough, orders[block], beside[block], observed))
                reached += int((found[-1] >= observed - _EQUAL).sum())
        if reached >= enough:
            break
    of_orders = np.concatenate(found)
    as_large = of_orders >= observed - _EQUAL
    return OrderTest(observed, _p_value(as_large, enough), not reached, of_orders)


def _compared(
    exact: tuple[HypothesisSet, Views],
    rough: tuple[HypothesisSet, Views],
    orders: IntArray,
    beside: FloatArray,
    observed: float,
) -> FloatArray:
    """Return the `log_statistic` of orders, in double precision where it is near ``observed``."""
    with np.errstate(all="ignore"):
        found = log_statistic(*rough, orders, beside)
    near = ~np.isfinite(found) | (np.abs(found - observed) < ROUGH)
    if near.any():
        found[near] = log_statistic(*exact, orders[near], beside[near])
    return found


def _drawn(rng: np.random.Generator, n: int, count: int) -> Iterator[IntArray]:
    """Yield ``count`` orders of n cycles, shape (orders, n), some of them at once."""
    for first in range(0, count, PERMUTATIONS):
        state = json.dumps(rng.bit_generator.state)
        orders, rng.bit_generator.state = _orders(state, n, min(PERMUTATIONS, count - first))
        parts = np.split(orders, [_AT_FIRST, 2 * _AT_FIRST, 4 * _AT_FIRST])
        yield from (part for part in parts if len(part))


@lru_cache(maxsize=2)
def _orders(state: str, n: int, count: int) -> tuple[IntArray, Mapping[str, Any]]:
    """Return the orders that a generator in this state draws, and the state behind them.

    Tables of one length and seed share them.
    """
    rng = np.random.default_rng()
    rng.bit_generator.state = json.loads(state)
    orders = np.array([rng.permutation(n) for _ in range(count)])
    orders.flags.writeable = False
    return orders, rng.bit_generator.state


def order_statistic(
    hypotheses: HypothesisSet,
    views: Views,
    emissions: Emissions | None = None,
    spreading: FloatArray | None = None,
) -> float:
    """Return the statistic of `order_test` of the cycles as they are."""
    as_is = np.arange(len(views.columns))[np.newaxis]
    beside = _beside(emissions, spreading, as_is)
    return float(log_statistic(hypotheses, views, as_is, beside)[0])


def _beside(
    emissions: Emissions | None, spreading: FloatArray | None, orders: IntArray
) -> FloatArray:
    """Return the evidence beside that of the set: that states persist, and that scatter changes."""
    evidence = np.zeros(len(orders))
    if emissions is not None:
        evidence += PERSISTENCE_SHARE * emissions.persistence(orders)
    if spreading is not None:
        evidence += WIDENING_SHARE * widening(spreading, orders)
    return evidence


def _p_value(as_large: npt.NDArray[np.bool_], enough: int) -> float:
    reached = np.flatnonzero(as_large)
    if len(reached) >= enough:
        return enough / float(reached[enough - 1] + 1)
    return (1 + len(reached)) / (1 + len(as_large))


def log_statistic(
    hypotheses: HypothesisSet,
    views: Views,
    orders: IntArray,
    beside: FloatArray | float = 0.0,
) -> FloatArray:
    """Return the log of the mean Bayes factor for each order of the cycles, shape (orders,).

    That of the likeliest course of unknown form counts as much as the mean of all hypotheses.

    ``beside`` is evidence that comes from outside the set.
    """
    n, v = views.columns.shape
    permuted = np.moveaxis(views.columns[orders], 0, 2).reshape(n, -1)
    if hypotheses.basis.shape[1] > 1:
        permuted = permuted - hypotheses.basis @ (hypotheses.basis.T @ permuted)
    bf = bayes_factors(hypotheses, permuted).reshape(-1, v, len(orders))
    unknown = UNKNOWN_SHARE * largest_evidence(bf[hypotheses.by_largest], views)
    return np.asarray(np.log(mean_evidence(hypotheses.test_weights, bf, views) + unknown + beside))


_LEAST_CYCLES = 4
_GAIN = 8.0
"""Prior variance of z beside that of chance (undeclared.py, scatter_doubles)."""
_DIGITS = 9


def widening(columns: FloatArray, orders: IntArray) -> FloatArray:
    """Return the evidence that scatter changes, for each of the ``orders`` (m, n), shape (m,).

    ``columns`` (n, axes) are residuals; their mean evidence over all orders is about 1.
    """
    n, axes = columns.shape
    if not axes or n < 2 * _LEAST_CYCLES:
        return np.zeros(len(orders))
    scores = savage_scores(columns)
    scores = np.concatenate([scores.sum(axis=1, keepdims=True), scores], axis=1)
    spread = np.maximum(scores.std(axis=0, ddof=1), 1e-9)
    standard = (scores - scores.mean(axis=0)) / spread
    before = np.arange(_LEAST_CYCLES, n - _LEAST_CYCLES + 1)
    sums = np.cumsum(standard[orders], axis=1)[:, before - 1]
    z = sums / np.sqrt(before * (n - before) / n)[:, np.newaxis]
    evidence = (np.exp(z**2 / 2 * _GAIN / (1 + _GAIN)) / np.sqrt(1 + _GAIN)).mean(axis=1)
    return np.asarray((evidence[:, 0] + evidence[:, 1:].mean(axis=1)) / 2)


def savage_scores(columns: FloatArray) -> FloatArray:
    """Return the scores (n, axes) of the ranks of distances from the median.

    Equal distances share the mean of their ranks.
    """
    distance = np.abs(columns - median(columns, axis=0)).round(_DIGITS)
    smaller = (distance[:, np.newaxis] > distance).sum(axis=1)
    equal = (distance[:, np.newaxis] == distance).sum(axis=1)
    rank = smaller + (equal + 1) / 2
    return np.asarray(-np.log1p(-rank / (len(columns) + 1)))
