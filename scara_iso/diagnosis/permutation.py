"""Is there an order in the cycles? An exact test by shuffling them.

Where there is nothing but scatter the cycles are exchangeable, whatever the distribution, rounding
and correlation of the axes; so the statistic of the cycles as measured ranks among those of
shuffled ones by chance. After a fit the residuals are shuffled (Freedman and Lane 1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.bank import Bank
from scara_iso.diagnosis.evidence import Views, joint_evidence, log_bayes
from scara_iso.diagnosis.levels import Sides
from scara_iso.run import FloatArray, IntArray

SHUFFLES = 999
ENOUGH = 50
"""So many orders with as large a statistic settle that p is above 0.05, whatever follows."""

_SIDES_SHARE = 0.08
"""Weight of sides that stay for some cycles over that of all other members of the bank."""

_EQUAL = 1e-9
_BLOCK = 32
"""Orders compared at once: as many as leave the work in the processor's cache."""


@dataclass(frozen=True, slots=True)
class OrderTest:
    """Statistic of the run, and the share of orders with one as large: its p-value."""

    statistic: float
    p_value: float
    at_floor: bool
    """No shuffle came as far: the chance is at most p."""


def order_test(
    bank: Bank,
    views: Views,
    rng: np.random.Generator,
    *,
    sides: Sequence[Sides] = (),
    shuffles: int = SHUFFLES,
) -> OrderTest:
    """Return the test of the views' cycles against ``shuffles`` random orders of them.

    ``sides`` are those of each axis that may show two levels.

    Axes stay together: one order serves all. Exact at any level when the bank's basis is the
    constant pose; p is at least 1 / (shuffles + 1). Shuffling ends with the ENOUGHth order whose
    statistic is as large, the l-th say: p = ENOUGH / l, no less valid for that (Besag and
    Clifford 1991), and below 0.05 just where all the orders would put it there.
    """
    n = len(views.columns)
    orders = np.array([np.arange(n), *(rng.permutation(n) for _ in range(shuffles))])
    sticky = _stickiness(sides, orders)
    observed = float(log_statistic(bank, views, orders[:1], sticky[:1])[0])
    as_large = np.zeros(0, dtype=bool)
    while len(as_large) < shuffles and as_large.sum() < ENOUGH:
        block = slice(1 + len(as_large), 1 + len(as_large) + _BLOCK)
        statistics = log_statistic(bank, views, orders[block], sticky[block])
        as_large = np.concatenate([as_large, statistics >= observed - _EQUAL])
    return OrderTest(observed, _p_value(as_large), not as_large.any())


def _stickiness(sides: Sequence[Sides], orders: IntArray) -> FloatArray:
    """Return the evidence that sides stay, for each order, beside that of the bank."""
    if not sides:
        return np.zeros(len(orders))
    return np.asarray(_SIDES_SHARE * np.mean([side.stickiness(orders) for side in sides], axis=0))


def _p_value(as_large: npt.NDArray[np.bool_]) -> float:
    reached = np.flatnonzero(as_large)
    if len(reached) >= ENOUGH:
        return ENOUGH / float(reached[ENOUGH - 1] + 1)
    return (1 + len(reached)) / (1 + len(as_large))


def log_statistic(
    bank: Bank, views: Views, orders: IntArray, sticky: FloatArray | float = 0.0
) -> FloatArray:
    """Return the log of the mean Bayes factor for each order of the cycles, shape (orders,).

    ``sticky`` is evidence that comes from outside the bank.
    """
    n, v = views.columns.shape
    shuffled = np.moveaxis(views.columns[orders], 0, 2).reshape(n, -1)
    if bank.basis.shape[1] > 1:
        shuffled = shuffled - bank.basis @ (bank.basis.T @ shuffled)
    log_bf = log_bayes(bank, shuffled).reshape(-1, v, len(orders))
    return np.asarray(np.log(bank.test_weights @ joint_evidence(log_bf, views) + sticky))
