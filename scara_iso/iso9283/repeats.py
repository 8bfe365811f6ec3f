"""Rows that say again what the row before them says: visits that are written several times."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from scara_iso.run import Run

REPEATED_BY_CHANCE = 1e-3
"""Probability below which rows that say the same again are no coincidence."""

FloatArray = npt.NDArray[np.float64]

_LAGS = 3
_NEAR = 1.5  # divisions; less than two, more than one and rounding
_MANY_NEAR = 0.6  # benchmarks/repeats.py: a drift in stairs, and sides by turns, have 1
_FEWEST_CHANGES = 3
_FEW_ROWS = 1000  # where there are more, the stretches tell


@dataclass(frozen=True, slots=True)
class Repeats:
    """How many rows are the row before them again, and how likely that is by chance at most."""

    rows: int
    visits: int
    """Rows that are left when each stretch of equal ones is taken once."""
    p_value: float

    @property
    def repeated(self) -> int:
        """Number of rows that add nothing."""
        return self.rows - self.visits

    @property
    def share(self) -> float:
        """Repeated rows of all."""
        return self.repeated / self.rows

    @property
    def said(self) -> str:
        """The numbers in words."""
        return f"{self.repeated} of {self.rows} rows repeat every reading of the row before them"


def repeats_in(run: Run, rows: npt.NDArray[np.intp]) -> Repeats:
    """Return which of the rows of one pose say again what the row before them says."""
    axes = run.axes.values()
    divisions = [axis.resolution or 0.0 for axis in axes]
    return find_repeats(np.stack([a.readings[rows] for a in axes], axis=1), np.array(divisions))


def find_repeats(readings: FloatArray, division: FloatArray) -> Repeats:
    """Return what of readings of shape (n, axes) is written again in the row below.

    ``division`` of the dial of each axis, shape (axes,), 0 where not known. A dial with few levels
    says the same in neighbouring rows by itself, and then says nearly the same in rows a little
    apart. The share of near rows (all axes within one division) among stretches one, two or three
    apart, the largest of these, is therefore the most that chance gives a row to be followed by its
    equal; the number of stretches of two or more has a binomial tail under it. A channel that is
    stuck for a while is one stretch, a slow drift moves by single divisions, and sides by turns
    come back. Where few rows are near, readings that change at every k-th row only tell as well.
    The smaller of both probabilities is doubled. docs/tables.md has what it finds and what not.
    """
    changed = np.any(readings[1:] != readings[:-1], axis=1)
    begins = np.concatenate([[0], np.flatnonzero(changed) + 1])
    lengths = np.diff(begins, append=len(readings))
    visits = readings[begins]
    step = np.where(division > 0, division, _smallest_steps(readings))
    near = [
        np.all(np.abs(visits[lag:] - visits[:-lag]) <= _NEAR * step, axis=1)
        for lag in range(1, min(_LAGS, len(visits) - 1) + 1)
    ]
    pooled = (sum(int(one.sum()) for one in near) + 1) / (sum(map(len, near)) + 1)
    share = max([pooled, *(float(one.mean()) for one in near)])
    p_value = _tail(int((lengths > 1).sum()), len(visits), share)
    if share < _MANY_NEAR:
        p_value = min(p_value, _every_kth(begins[1:], len(readings)))
    return Repeats(len(readings), len(visits), min(1.0, 2 * p_value))


def _smallest_steps(readings: FloatArray) -> FloatArray:
    steps = np.diff(np.sort(readings, axis=0), axis=0)
    smallest = np.where(steps > 0, steps, np.inf).min(axis=0, initial=np.inf)
    return np.where(np.isfinite(smallest), smallest, 0.0)


def _every_kth(changes: npt.NDArray[np.intp], rows: int) -> float:
    """Return how likely changes at random places, as many, are all k rows apart or multiples of it.

    k is the greatest that holds for ``changes``, or any larger one.
    """
    if len(changes) < _FEWEST_CHANGES or rows > _FEW_ROWS:
        return 1.0
    every, among = int(np.gcd.reduce(np.diff(changes))), rows - 1
    if every == 1:
        return 1.0
    ways = 0
    for k in range(every, among):
        places, more = divmod(among, k)
        ways += more * math.comb(places + 1, len(changes))
        ways += (k - more) * math.comb(places, len(changes))
    return min(1.0, ways / math.comb(among, len(changes)))


def _tail(successes: int, trials: int, share: float) -> float:
    """Return the probability of so many successes or more (binomial), at most."""
    if successes <= trials * share:
        return 1.0
    # Chernoff's bound (Hoeffding 1963, theorem 1): the sum itself is slow for a million rows.
    part = successes / trials
    exponent = part * math.log(part / share)
    if part < 1:
        exponent += (1 - part) * math.log((1 - part) / (1 - share))
    return math.exp(-trials * exponent)
