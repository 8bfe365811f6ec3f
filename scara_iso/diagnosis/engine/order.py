"""Is there an order in the cycles? An exact test by permuting them.

Where there is nothing but scatter the cycles are exchangeable, whatever the distribution, rounding
and correlation of the axes; so the statistic of the cycles as measured, the mean evidence of all
hypotheses, ranks among those of permuted ones by chance. After a fit the residuals are permuted
(Freedman and Lane 1983).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from scara_iso.diagnosis.engine.evidence import (
    LARGEST_LOG,
    HypothesisSet,
    Views,
    joint_evidence,
    log_bayes,
)
from scara_iso.diagnosis.engine.two_levels import Emissions
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_EQUAL = 1e-3
"""Statistics as near as this are one: more than single precision is off by."""
_COARSE = 4  # readings for each that is not another: a dial of as many levels as show scatter
_TEMPERED_BY = 64  # orders; benchmarks/beside_quiet.py
_COLUMNS = 288
"""Views of orders compared at once: as many as leave the work in the processor's cache."""

PERMUTATIONS = 999
ENOUGH = 50
"""So many orders with as large a statistic settle that p is above 0.05, whatever follows."""
ENOUGH_FURTHER = 10
"""The same of FURTHER_LEVEL."""

PERSISTENCE_SHARE = 0.08
"""Weight of states that persist over that of all hypotheses (table *power*, sticky)."""

GROSS = 3.0
"""Robust standard deviations beyond which the test of order draws a reading in."""


class OrderTest(NamedTuple):
    """Statistic of the run, and the share of orders with one as large: its p-value."""

    statistic: float
    p_value: float
    at_floor: bool
    """No permutation came as far: the chance is at most p."""
    of_orders: FloatArray = np.empty(0)
    """Statistics of the orders that were looked at."""
    temper: FloatArray | None = None
    """As of `log_statistic`."""

    def limit(self, level: float) -> float:
        """Return the statistic that a share ``level`` of the orders reach."""
        return float(np.quantile(self.of_orders, 1 - level)) if len(self.of_orders) else -np.inf


def order_test(
    hypotheses: HypothesisSet,
    views: Views,
    rng: np.random.Generator,
    *,
    emissions: Emissions | None = None,
    permutations: int = PERMUTATIONS,
    further: bool = False,
) -> OrderTest:
    """Return the test of the views' cycles against ``permutations`` of them.

    ``emissions`` are those of the axes that may show two states. Axes stay together: one order
    serves all. Exact at any level when the set's basis is the constant pose; p is at least
    1 / (permutations + 1). It ends with the ENOUGHth order whose statistic is as large, the l-th
    say: p = ENOUGH / l, no less valid for that (Besag and Clifford 1991), and below 0.05 just where
    all the orders would put it there. Of a ``further`` effect ENOUGH_FURTHER are enough.
    """
    temper = _temper(hypotheses, views, rng)
    observed = log_statistic(hypotheses, views, None, emissions, temper).item()
    enough = ENOUGH_FURTHER if further else ENOUGH
    of_orders = np.empty(0)
    for orders in _drawn(rng, len(views.columns), permutations, views.columns.shape[1]):
        found = log_statistic(hypotheses, views, orders, emissions, temper)
        of_orders = np.append(of_orders, found)
        as_large = np.flatnonzero(of_orders >= observed - _EQUAL)
        if len(as_large) >= enough:
            p_value = enough / float(as_large[enough - 1] + 1)
            return OrderTest(observed, p_value, False, of_orders, temper)
    p_value = (1 + len(as_large)) / (1 + len(of_orders))
    return OrderTest(observed, p_value, not len(as_large), of_orders, temper)


def drawn_in(values: FloatArray, least: FloatArray | float = 0.0) -> FloatArray:
    """Return values (n, axes) with gross ones drawn in, so that none hides an order of the others.

    Their robust deviation is taken as ``least`` (axes,) at least. The limit does not depend on the
    order of the cycles, so the test stays exact.
    """
    middle = median(values, axis=0)
    robust = 1.4826 * median(np.abs(values - middle), axis=0)
    limit = np.where(robust > 0, GROSS * np.maximum(robust, least), np.inf)
    return np.clip(values, middle - limit, middle + limit)


def _temper(hypotheses: HypothesisSet, views: Views, rng: np.random.Generator) -> FloatArray | None:
    """Return to which power (v,) each axis speaks beside others, where one shows few readings.

    A fit to a few levels may leave nothing over: in one order of twenty such an axis alone has
    evidence of e^10 and more, which hides what another shows. By chance a Bayes factor comes to 20
    in one of twenty at most (Markov); an axis that goes beyond is brought back to that. Orders of
    their own tell, so the test stays exact.
    """
    n, v = views.columns.shape
    few = any(len(np.unique(column)) <= n / _COARSE for column in views.columns.T[: views.axes])
    if views.axes == 1 or not few:
        return None
    orders = np.concatenate([*_drawn(rng.spawn(1)[0], n, _TEMPERED_BY, v)])
    found = _log_bayes(hypotheses, views, orders).astype(np.float64)
    single = np.exp(np.minimum(found, LARGEST_LOG / v))
    alone = np.log(np.tensordot(hypotheses.test_weights, single, 1))
    by_chance = math.log(20)
    return np.asarray(by_chance / np.maximum(np.quantile(alone, 0.95, axis=1), by_chance))


def _drawn(rng: np.random.Generator, n: int, count: int, views: int) -> Iterator[IntArray]:
    """Yield ``count`` orders of n cycles, shape (orders, n), of so many ``views`` some at once."""
    at_once = max(1, _COLUMNS // views)
    for first in range(0, count, PERMUTATIONS):
        drawn = range(min(PERMUTATIONS, count - first))
        orders = np.array([rng.permutation(n) for _ in drawn])
        yield from (orders[k : k + at_once] for k in range(0, len(orders), at_once))


def log_statistic(
    hypotheses: HypothesisSet,
    views: Views,
    orders: IntArray | None,
    emissions: Emissions | None = None,
    temper: FloatArray | None = None,
) -> FloatArray:
    """Return the log of the mean Bayes factor for each order of the cycles, shape (orders,).

    None is that in which they came. In single precision; ``temper`` is the power (v,) to which
    each view speaks, None where each does in full.
    """
    if orders is None:
        orders = np.arange(len(views.columns))[np.newaxis]
    log_bf = _log_bayes(hypotheses, views, orders)
    if temper is not None:
        log_bf = log_bf * temper[:, np.newaxis].astype(np.float32)
    evidence = hypotheses.test_weights @ joint_evidence(log_bf, views)
    if emissions is not None:
        evidence += PERSISTENCE_SHARE * emissions.persistence(orders)
    return np.log(evidence)


def _log_bayes(hypotheses: HypothesisSet, views: Views, orders: IntArray) -> FloatArray:
    n, v = views.columns.shape
    permuted = np.moveaxis(views.columns[orders], 0, 2).reshape(n, -1)
    if hypotheses.basis.shape[1] > 1:
        permuted = permuted - hypotheses.basis @ (hypotheses.basis.T @ permuted)
    return log_bayes(hypotheses, permuted.astype(np.float32)).reshape(-1, v, len(orders))
