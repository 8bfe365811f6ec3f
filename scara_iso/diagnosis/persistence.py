"""Do unseen states persist? How likely each order of the cycles is under a hidden Markov model.

Levels and scatter are those that the readings show in any order, so that this is part of the test
of the order; `two_state` integrates over them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scara_iso.diagnosis.tuning import FEWEST_ON_A_LEVEL, LEAST_SCATTER
from scara_iso.diagnosis.two_state import log_likelihood
from scara_iso.effects import Chain
from scara_iso.frozen import dataclass
from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True)
class Emissions:
    """Likelihood (n,) of each reading in the lower and the upper state, the larger of them 1.

    Levels and scatter are those of the best split of the sorted readings, which no order changes.
    """

    lower: FloatArray
    upper: FloatArray
    chains: Sequence[Chain]

    def persistence(self, orders: IntArray) -> FloatArray:
        """Return how much likelier states under the chains make each order (m, n), shape (m,).

        Against states drawn anew in each cycle: the mean likelihood ratio over the chains.
        """
        weight = np.array([chain.weight for chain in self.chains])
        p = np.array([chain.leave_lower for chain in self.chains])
        q = np.array([chain.leave_upper for chain in self.chains])
        log_order = log_likelihood(self.lower[orders.T], self.upper[orders.T], p, q)
        start = (q / (p + q))[:, np.newaxis]
        none = np.log(start * self.lower + (1 - start) * self.upper).sum(axis=1, keepdims=True)
        return np.asarray(weight / weight.sum() @ np.exp(log_order - none))


def emissions_of(y: FloatArray, division: float, chains: Sequence[Chain]) -> Emissions:
    """Return how likely each of the readings y (n,) is in either state.

    The scatter is at least 0.6 divisions: that of a finer one would be the dial's alone.
    """
    ranked = np.sort(y - y.mean())
    n, below = len(y), np.arange(FEWEST_ON_A_LEVEL, len(y) - FEWEST_ON_A_LEVEL + 1)
    between = np.cumsum(ranked)[below - 1] ** 2 * n / (below * (n - below))
    k = below[np.argmax(between)]
    within = max(float((ranked**2).sum() - between.max()), 1e-12 * float(ranked @ ranked))
    scatter = max(np.sqrt(within / (n - 2)), LEAST_SCATTER * division)
    levels = np.array([ranked[:k].mean(), ranked[k:].mean()])[:, np.newaxis]
    density = -0.5 * ((y - y.mean() - levels) / scatter) ** 2
    lower, upper = np.exp(density - density.max(axis=0))
    return Emissions(lower, upper, chains)
