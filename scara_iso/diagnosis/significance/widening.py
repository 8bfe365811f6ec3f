"""Scatter that changes from some cycle on, by ranks: what the test of the order adds for it.

Each reading's distance from the median has the exponential score of its rank, -ln(1 - r / (n + 1))
(Savage 1956), which no tail makes large. The scores from a cycle on against those before it give a
standard deviate z; a Bayes factor of it against z of unit variance is averaged over the cycles. The
axes count together, by the sum of their scores, as much as each alone.
"""

from __future__ import annotations

import numpy as np

from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

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
