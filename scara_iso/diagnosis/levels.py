"""Several levels of no name, wherever they change.

The hypotheses hold courses of three and of four levels on a grid of changes, which a run with such
levels hardly ever meets. Here the best ones of all are weighed as well: four levels pass for a bump
or for a drift with a step, and are neither.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import comb

import numpy as np

from scara_iso.diagnosis.choice import Weighed
from scara_iso.diagnosis.evidence import joint_evidence, log_bayes_amplified
from scara_iso.diagnosis.hypotheses import Hypothesis, levels_of
from scara_iso.diagnosis.hypothesis_set import build
from scara_iso.diagnosis.problem import Remainder
from scara_iso.diagnosis.rounded import course_beside
from scara_iso.diagnosis.tuning import (
    AMPLITUDES,
    BEST_LEVELS_SHARE,
    FEWEST_ON_A_LEVEL,
    LEVELS_WEIGHT,
    UNKNOWN,
)
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_DUST = 1e-12


def several_levels(left: Remainder, n: int) -> list[Weighed]:
    """Return the best courses of several levels in what is left of a run of n cycles.

    Each has the weight of one of all courses with so many levels.
    """
    found = []
    half = left.readings.half.max(axis=0)
    for changes in best_changes(left.values, half, max(LEVELS_WEIGHT)):
        k = len(changes)
        form = levels_of(n, left.rows[changes].tolist())
        free = len(left.rows) - (k + 1) * (FEWEST_ON_A_LEVEL - 1)
        weight = BEST_LEVELS_SHARE * LEVELS_WEIGHT[k + 1] / comb(free - 1, k)
        member = Hypothesis(UNKNOWN, form, weight)
        if evidence := _evidence(member, left):
            seen = course_beside(left.basis, form.columns[left.rows], k)
            found.append(Weighed(UNKNOWN, form, evidence, on_dial=seen))
    return found


def _evidence(member: Hypothesis, left: Remainder) -> float:
    """Return that of one member over all amplitudes, prior weight included; 0 if it is fitted."""
    alone = build([member], left.rows, left.basis)
    if not alone.members:
        return 0.0
    log_bf = log_bayes_amplified(alone, left.views.columns, left.views.known)
    joint = [joint_evidence(one[:, :, np.newaxis], left.views)[0, 0] for one in log_bf]
    return member.weight * float(np.dot([share for _, share in AMPLITUDES], joint))


def best_changes(values: FloatArray, half: FloatArray, most: int) -> Iterator[IntArray]:
    """Yield the rows at which the best courses of 3 to ``most`` levels change.

    ``values`` (n, axes) change together, each axis by as much as it likes; ``half`` (axes,) is half
    a division of each. Least squares over all changes, no level of fewer readings than
    FEWEST_ON_A_LEVEL (segment neighbourhood, Auger and Lawrence 1989).
    """
    cost = _costs(values / _scatter(values, half))
    ending, begun = cost[0], []
    for levels in range(2, most + 1):
        every = ending[:-1, np.newaxis] + cost[1:]
        begun.append(every.argmin(axis=0) + 1)
        ending = every.min(axis=0)
        if levels > 2 and np.isfinite(ending[-1]):
            yield _traced(begun)


def _costs(scaled: FloatArray) -> FloatArray:
    """Return the sum of squares of readings i to j about their mean (n, n), infinite if few."""
    n = len(scaled)
    sums = np.vstack([np.zeros_like(scaled[:1]), scaled.cumsum(axis=0)])
    squares = np.append(0.0, (scaled**2).sum(axis=1).cumsum())
    count = np.arange(1, n + 1) - np.arange(n)[:, np.newaxis]
    between = ((sums[np.newaxis, 1:] - sums[:-1, np.newaxis]) ** 2).sum(axis=2)
    cost = squares[1:] - squares[:-1, np.newaxis] - between / np.maximum(count, 1)
    return np.asarray(np.where(count < FEWEST_ON_A_LEVEL, np.inf, cost))


def _traced(begun: list[IntArray]) -> IntArray:
    """Return the rows at which the best course over all readings changes."""
    changes = [len(begun[0])]
    for first in reversed(begun):
        changes.insert(0, int(first[changes[0] - 1]))
    return np.array(changes[:-1])


def _scatter(values: FloatArray, half: FloatArray) -> FloatArray:
    """Return that of each axis, by the differences of neighbours; not below the dial's."""
    robust = 1.4826 * median(np.abs(np.diff(values, axis=0)), axis=0) / np.sqrt(2)
    return np.asarray(np.maximum(np.maximum(robust, 2 * half / np.sqrt(12)), _DUST))
