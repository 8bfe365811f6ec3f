"""Several levels of no name, wherever they change.

The hypotheses hold courses of three and of four levels on a grid of changes, which a run with such
levels hardly ever meets. Here the best ones of all are weighed as well: four levels pass for a bump
or for a drift with a step, and are neither.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import comb

import numpy as np

from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis, levels_of
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build
from scara_iso.diagnosis.problem import Remainder
from scara_iso.diagnosis.tuning import (
    BEST_LEVELS_SHARE,
    FEWEST_ON_A_LEVEL,
    LEVELS_WEIGHT,
    UNKNOWN,
)
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_DUST = 1e-12


def with_levels(hypotheses: HypothesisSet, left: Remainder, n: int) -> HypothesisSet:
    """Return the set with the best courses of several levels in what is left of a run as well."""
    own, more = hypotheses, build(several_levels(left, n), left.rows, left.basis)
    courses = len(own.first)
    return replace(
        own,
        members=(*own.members[:courses], *more.members, *own.members[courses:]),
        vectors=np.concatenate([own.vectors, more.vectors], axis=1),
        first=np.append(own.first, more.first + own.vectors.shape[1]),
        widths=np.append(own.widths, more.widths),
        shrink=np.append(own.shrink, more.shrink),
        penalty=np.append(own.penalty, more.penalty),
    )


def several_levels(left: Remainder, n: int) -> list[Hypothesis]:
    """Return the best courses of several levels in what is left of a run of n cycles.

    Each has the weight of one of all courses with so many levels.
    """
    found = []
    half = left.readings.half.max(axis=0)
    for changes in best_changes(left.values, half, max(LEVELS_WEIGHT)):
        k = len(changes)
        free = len(left.rows) - (k + 1) * (FEWEST_ON_A_LEVEL - 1)
        weight = BEST_LEVELS_SHARE * LEVELS_WEIGHT[k + 1] / comb(free - 1, k)
        found.append(Hypothesis(UNKNOWN, levels_of(n, left.rows[changes].tolist()), weight))
    return found


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
