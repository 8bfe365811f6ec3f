"""Do unseen states persist? How likely each order of the cycles is under a hidden Markov model.

Levels and scatter are those that the readings show in any order, so that this is part of the test
of the order; `two_state` integrates over them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.likelihood.two_state import log_likelihood
from scara_iso.diagnosis.tuning import FEWEST_ON_A_LEVEL, LEAST_SCATTER
from scara_iso.effects import Chain
from scara_iso.run import FloatArray, IntArray


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
