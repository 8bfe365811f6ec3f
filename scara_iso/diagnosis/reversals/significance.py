"""Is it more than chance? The tests of reversals: any effect, a second one, what a fit leaves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scara_iso.diagnosis.reversals.fit import Family, Fitted, Reversals, over_all
from scara_iso.diagnosis.tuning import MISFIT_LEVEL, RIVAL, SWEEP_SIMULATIONS
from scara_iso.run import FloatArray

FLOOR = 1 / (1 + SWEEP_SIMULATIONS)
"""Smallest p-value that the simulations can give."""
_EXACT = 1e-4
"""A fit this close, as a share of the largest deviation, leaves only digits and grid."""


def p_value_of_scatter(
    data: Reversals, before: FloatArray, families: Sequence[Family], rng: np.random.Generator
) -> float:
    """Return how often eq. 16 with scatter alone fits some effect as much better.

    Of the ways in which the scatter may grow, the one that does so most often counts.
    """
    tried = np.concatenate([data.predict(over_all(family)) for family in families])
    observed = _gain(data, data.measured[np.newaxis], before, tried)[0]
    scatters, likely = data.scatters(before)
    chances = []
    for scatter in scatters[likely > RIVAL * likely.max()]:
        noise = rng.normal(size=(SWEEP_SIMULATIONS, len(before))) * scatter
        if np.isfinite(data.degrees):
            drawn = rng.chisquare(data.degrees, size=(SWEEP_SIMULATIONS, 1)) / data.degrees
            noise /= np.sqrt(drawn)
        pieces = np.array_split(before + noise, 10)
        gains = np.concatenate([_gain(data, piece, before, tried) for piece in pieces])
        chances.append((1 + (gains >= observed).sum()) / (1 + SWEEP_SIMULATIONS))
    return float(max(chances))


def _gain(
    data: Reversals, readings: FloatArray, before: FloatArray, tried: FloatArray
) -> FloatArray:
    """Return the log likelihood gained by the best of predictions (k, m), shape (readings,)."""
    alone = data.best_log_likelihood(readings, before[np.newaxis])
    return np.asarray(data.best_log_likelihood(readings, tried) - alone)


def second_p_value(data: Reversals, one: Sequence[Fitted], two: Sequence[Fitted]) -> float:
    """Return the chance that some pair fits as much better than every single effect (F test)."""
    from scipy.stats import f  # noqa: PLC0415 - heavy

    single = max(one, key=lambda fit: fit.log_best)
    chances = []
    for pair in two:
        more = max(1, free(pair) - free(single))
        gain, m = pair.log_best - single.log_best, len(data.rows)
        if data.uncertainty is not None:
            chances.append(f.sf(2 * gain / more, more, min(data.degrees, 1e6)))
        else:
            left = m - free(pair)
            chances.append(f.sf(np.expm1(2 * max(gain, 0.0) / m) * left / more, more, left))
    return float(min(1.0, len(chances) * min(chances)))


def free(fit: Fitted) -> int:
    """Return the number of parameters of a fit."""
    return sum(term.free for term in fit.family)


def misfits(data: Reversals, fit: Fitted) -> bool:
    """Return whether known uncertainties do not account for what a fit leaves."""
    from scipy.stats import f  # noqa: PLC0415 - heavy

    left = len(data.rows) - free(fit)
    if data.uncertainty is None or left < 1:
        return False
    chance = f.sf(-2 * fit.log_best / left, left, min(data.degrees, 1e6))
    return bool(chance < MISFIT_LEVEL)


def wanders(data: Reversals, fit: Fitted, rng: np.random.Generator) -> bool:
    """Return whether what a fit leaves follows the inertia, where the scatter is not known.

    Neighbours in the order of I_L differ less than they do when permuted (von Neumann 1941).
    """
    if data.uncertainty is not None:
        return False
    predicted = data.predict(fit.changes)[0]
    scatters, likely = data.scatters(predicted)
    left = data.measured[data.rows] - predicted
    if np.abs(left).max() < _EXACT * np.abs(predicted).max():
        return False
    left = left / scatters[int(np.argmax(likely))]
    (sweep,) = data.sweeps.values()
    left = left[np.argsort(sweep.I_L[data.rows], kind="stable")]
    permuted = rng.permuted(np.tile(left, (SWEEP_SIMULATIONS, 1)), axis=1)
    steps = (np.diff(np.vstack([left, permuted]), axis=1) ** 2).sum(axis=1)
    chance = (1 + (steps[1:] <= steps[0]).sum()) / (1 + SWEEP_SIMULATIONS)
    return bool(chance < MISFIT_LEVEL)
