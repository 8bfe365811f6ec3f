"""95 % intervals of figures that are made of several variances and a mean.

A generalized pivotal quantity puts the variance of a chi-square and the mean of a Gaussian in the
place of each estimate, and the figure is computed of them as of the readings; the interval is that
of 95 % of such draws (Weerahandi 1993; Hamada and Weerahandi 2000 for studies of measuring
systems). How often they hold the true value: benchmarks/gauge_study.py.
"""

from __future__ import annotations

import math

import numpy as np

from scara_iso.published import Interval
from scara_iso.run import FloatArray

DRAWS = 20_000
CONFIDENCE = 0.95


def drawn_variance(variance: float, freedom: int, rng: np.random.Generator) -> FloatArray:
    """Return draws of what a variance estimated with ``freedom`` is of, shape (DRAWS,)."""
    return np.asarray(variance * freedom / rng.chisquare(freedom, DRAWS))


def drawn_mean(mean: float, variances: FloatArray, n: int, rng: np.random.Generator) -> FloatArray:
    """Return draws of what the mean of ``n`` readings is of, shape as ``variances``."""
    return np.asarray(mean + rng.standard_normal(len(variances)) * np.sqrt(variances / n))


def between(draws: FloatArray) -> Interval:
    """Return the 95 % interval of draws."""
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(draws, [tail, 1 - tail])
    return float(low), float(high)


def interval_of_mean(mean: float, s: float, n: int) -> Interval:
    """Return Student's interval of a mean of ``n`` readings with standard deviation ``s``."""
    from scipy.special import stdtrit  # noqa: PLC0415 - scipy for studies only

    half = float(stdtrit(n - 1, (1 + CONFIDENCE) / 2)) * s / math.sqrt(n)
    return mean - half, mean + half


def interval_of_s(s: float, freedom: int) -> Interval:
    """Return the chi-square interval of a standard deviation with that many degrees of freedom."""
    from scipy.special import chdtri  # noqa: PLC0415 - likewise

    tail = (1 - CONFIDENCE) / 2
    low, high = (s * math.sqrt(freedom / float(chdtri(freedom, q))) for q in (tail, 1 - tail))
    return low, high


def p_of_t(t: float, freedom: int) -> float:
    """Return the two-sided p-value of Student's t."""
    from scipy.special import stdtr  # noqa: PLC0415 - likewise

    return float(2 * stdtr(freedom, -abs(t)))
