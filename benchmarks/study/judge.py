"""An independent judgement of a statement, by the readings it was made of and those that came next.

No code of the program has a part in it. A *course* is how readings go. Every course of a list is
fitted to the test and, going on as it would, to the readings after it, by BIC and the likelihood of
readings rounded to whole divisions. A course may also end with the test: the next readings are then
fitted by themselves, at odds of 20 to 1 against it. Two courses act at once
only where the program named two.

A statement is *right* if its course beats every other by odds of RIGHT, *wrong* if another beats it
by odds of WRONG, else *undecided*.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.study import courses
from benchmarks.study.courses import Array

RIGHT, WRONG, ENDS = 3.0, 20.0, 20.0
CLOSEST = 24
"""So many designs, the closest by least squares, are fitted as rounded."""
SCATTER = {"constant", "heavy tails"}
NAMES: Mapping[str, tuple[set[str], set[str]]] = {
    "linear_drift": ({"line", "slow"}, set()),
    "warm_up": ({"exponential", "slow"}, set()),
    "onset": ({"onset"}, set()),
    "step": ({"step"}, {"two states"}),
    "periodic": ({"sine"}, set()),
    "transient": ({"bump"}, {"two states"}),
    "outlier": ({"outlier"}, set()),
    "random_walk": ({"walk"}, {"free", "memory"}),
    "autocorrelated": ({"memory"}, {"walk", "free"}),
    "overcorrection": ({"taken back"}, {"alternation"}),
    "contact_side": ({"two states", "alternation"}, set()),
    "scatter_change": ({"scatter"}, set()),
}
"""The courses that an effect's name means, and those that decide nothing against it."""
NOTHING, UNEXPLAINED = "nothing", "unexplained"


@dataclass(frozen=True)
class Judgement:
    """What came of a statement."""

    verdict: str
    """right, wrong, undecided, or unjudged."""
    goes_on: bool
    """The next readings go on from the test rather than anew."""


@dataclass(frozen=True)
class Library:
    """Courses with a mean as columns (d, n + m), each with its label and the numbers it takes."""

    labels: Array
    columns: Array
    numbers: Array


@cache
def library(n: int, m: int) -> Library:
    """Return the courses of a test of n readings, gone on with for m more."""
    found = list(courses.means(n, m))
    labels, columns, numbers = zip(*found, strict=True)
    return Library(np.array(labels), np.stack(columns), np.array(numbers))


def judged(statement: str, y: Array, z: Array, second: str | None = None) -> Judgement:
    """Return what readings y (n,) and the next, z (m,), in whole divisions, say of a statement.

    It is an effect's name, NOTHING or UNEXPLAINED. What has no course here is not judged. Where a
    ``second`` effect was named, the first may act beside it, and two others are its rivals too.
    """
    every = {*(course for own, _ in NAMES.values() for course in own), "free"}
    meant = {**NAMES, NOTHING: (SCATTER, set()), UNEXPLAINED: (every, set())}
    if statement not in meant:
        return Judgement("unjudged", goes_on=False)
    own, neutral = meant[statement]
    level = np.round(np.median(y))
    labels = library(len(y), len(z)).labels
    wanted = _sides(own, neutral, NAMES.get(second or "", (set(), set()))[0], labels)
    return compared(own, neutral, wanted, y - level, z - level)


def compared(
    own: set[str], neutral: set[str], wanted: Mapping[str, Array], y: Array, z: Array
) -> Judgement:
    """Return the judgement of courses ``own`` against those neither own nor ``neutral``.

    ``wanted`` (d, d) marks the pairs of columns of either side.
    """
    both, end = np.concatenate([y, z]), 2 * np.log(ENDS)
    hidden = courses.hidden(y, z)
    ended, gone_on = {}, {}
    for side, pairs in wanted.items():
        named = [
            bic
            for course, bic in hidden.items()
            if (course in own if side == "own" else course not in own | neutral)
        ]
        ended[side] = min([best_bic(y, 0, pairs), *(a for a, _ in named)])
        gone_on[side] = min([best_bic(both, len(z), pairs), *(b for _, b in named)])
    anew = end + by_themselves(z)
    apart = (min(gone_on["others"], ended["others"] + anew)
             - min(gone_on["own"], ended["own"] + anew))  # fmt: skip
    sure = "wrong" if apart <= -2 * np.log(WRONG) else "undecided"
    return Judgement("right" if apart >= 2 * np.log(RIGHT) else sure,
                     goes_on=bool(gone_on["own"] <= ended["own"] + anew))  # fmt: skip


def _sides(own: set[str], neutral: set[str], second: set[str], labels: Array) -> dict[str, Array]:
    """Return which pairs of columns (d, d) are the statement's, and which are its rivals."""
    alone = np.eye(len(labels), dtype=bool)
    is_own, kept = np.isin(labels, list(own)), ~np.isin(labels, list(own | neutral))
    beside = np.isin(labels, list(second))
    pairs = (is_own[:, None] & beside) | (beside[:, None] & is_own)
    return {
        "own": pairs | (alone & is_own),
        "others": (alone | beside.any()) & kept & kept[:, None],
    }


def by_themselves(z: Array) -> float:
    """Return the least BIC of readings about a constant or a line."""
    labels = library(len(z), 0).labels
    line = np.diag(labels == "line")
    return min(best_bic(z, 0, line), *(a for a, _ in courses.constants(z, z[:0]).values()))


def best_bic(y: Array, after: int, wanted: Array) -> float:
    """Return the least BIC of readings, the last ``after`` of them later than the test.

    ``wanted`` (d, d) marks the pairs of courses; one with itself is that course alone.
    """
    lib, n = library(len(y) - after, after), len(y)
    i, j = np.nonzero(wanted & _together(lib.labels))
    if not len(i):
        return np.inf
    gain, left = _gain(y, lib.columns, i, j)
    numbers = lib.numbers[i] + np.where(i == j, 0, lib.numbers[j])
    score = n * np.log(np.maximum(left - gain, 0) / n + courses.LEAST**2) + numbers * np.log(n)
    at = np.argsort(score)[:CLOSEST]
    second = np.where((i == j)[at, None], 0.0, lib.columns[j[at]])
    X = np.stack([np.ones_like(second), lib.columns[i[at]], second], axis=-1)
    likelihood = courses.rounded_likelihood(y, X)
    return float((-2 * likelihood + (2 + numbers[at]) * np.log(n)).min())


def _gain(y: Array, columns: Array, i: Array, j: Array) -> tuple[Array, float]:
    """Return the squares that pairs i, j of columns (d, n) take of those about the mean."""
    unit = columns - columns.mean(axis=1, keepdims=True)
    unit /= np.maximum(np.linalg.norm(unit, axis=1, keepdims=True), 1e-12)
    left = y - y.mean()
    r, gain, pair = unit @ left, np.zeros(len(i)), i != j
    gain[~pair] = r[i[~pair]] ** 2
    if pair.any():
        a, b = i[pair], j[pair]
        rho = (unit @ unit.T)[a, b]
        with np.errstate(divide="ignore", invalid="ignore"):
            two = (r[a] ** 2 + r[b] ** 2 - 2 * rho * r[a] * r[b]) / (1 - rho**2)
        gain[pair] = np.where(np.abs(rho) < 0.999, two, 0.0)
    return gain, float(left @ left)


def _together(labels: Array) -> Array:
    """Return which pairs (d, d) are fitted: each once, and a curve only where it bends a line."""
    curve, line = labels == "curve", labels == "line"
    bent = (curve[:, None] & line) | (line[:, None] & curve)
    return np.triu(~(curve[:, None] | curve) | bent)
