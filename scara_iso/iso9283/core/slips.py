"""Rows that no robot made: written again, copied from others, or exchanged between axes."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scara_iso.run import Axis, FloatArray, IntArray, Run

REPEATED_BY_CHANCE = 1e-3
"""Probability below which rows that say the same again are no coincidence."""

_LAGS = 3
_NEAR = 1.5  # divisions; less than two, more than one and rounding
_MANY_NEAR = 0.6  # benchmarks/repeats.py: a drift in stairs, and sides by turns, have 1
_FEWEST_CHANGES = 3
_FEW_ROWS = 1000  # where there are more, the stretches tell
_EXCHANGED = 10  # times less spread once exchanged back; two swings in mirror image have 5
_FEWEST_TYPED, _MOST_TYPED = 5, 1000  # rows
_GOES_ON = 3.5  # standard errors, of 30 cycles once in 2,000
_OWN_LAG = 6  # copies farther behind leave too few rows to see whether such a lag is usual
_FEWEST_COPIED = 4  # rows


class Copied(NamedTuple):
    """Rows that say again, one after the other, what as many rows before them say."""

    first: int
    """Place of the first of them among the rows."""
    rows: int
    behind: int
    """So many rows behind the ones that they repeat: 1 where all say the same."""
    p_value: float

    def in_words(self, cycle: IntArray) -> str:
        """Return in words which of the rows of ``cycle``, shape (n,), are copied."""
        last, first = self.first + self.rows - 1, self.first - self.behind
        at = f"cycles {cycle[self.first]} to {cycle[last]} repeat every reading of"
        if self.behind == 1:
            return f"{at} cycle {cycle[first]}"
        return f"{at} cycles {cycle[first]} to {cycle[first + self.rows - 1]}"


class Repeats(NamedTuple):
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
    def said(self) -> str:
        """The numbers in words."""
        return f"{self.repeated} of {self.rows} rows repeat every reading of the row before them"


def repeats_in(run: Run, rows: npt.NDArray[np.intp]) -> Repeats:
    """Return which of the rows of one pose say again what the row before them says."""
    return find_repeats(*_shown(run, rows))


def _shown(run: Run, rows: npt.NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
    axes = run.axes.values()
    readings = np.stack([axis.readings[rows] for axis in axes], axis=1)
    return readings, np.array([axis.resolution or 0.0 for axis in axes])


def copied_in(run: Run, rows: npt.NDArray[np.intp]) -> Copied | None:
    """Return the longest stretch of rows of one pose that is another again, by no chance."""
    found = find_copied(*_shown(run, rows))
    return found if found is not None and found.p_value < REPEATED_BY_CHANCE else None


def find_copied(readings: FloatArray, division: FloatArray) -> Copied | None:
    """Return the longest stretch of ``readings`` (n, axes) that stands again behind itself.

    ``division`` as of `find_repeats`. The chance of such a stretch is at most that of as many near
    rows one after the other, at any two places. How often rows are near, the other rows tell: all
    pairs of them, neighbours, and those as far apart as the stretch is from its copy, the largest
    of these. Readings that go on in turns, or are few, are no copies, as sides by turns. Of more
    than a thousand rows nothing is said: nobody copied them by hand.
    """
    n = len(readings)
    if not _FEWEST_TYPED <= n <= _MOST_TYPED:
        return None
    _, alike = np.unique(readings, axis=0, return_inverse=True)
    rows, first, behind = _longest_again(alike.ravel())
    few = 2 * len(set(alike.ravel()[first : first + rows].tolist())) < rows
    if rows < _FEWEST_COPIED or (behind > 1 and (behind < rows or few)):
        return None
    rest = np.delete(readings, np.s_[first : first + rows], axis=0)
    step = np.where(division > 0, division, _smallest_steps(readings))
    near = np.all(np.abs(rest[:, np.newaxis] - rest) <= _NEAR * step, axis=2)
    pairs = [near[np.triu_indices(len(rest), 1)], np.diagonal(near, 1)]
    if behind <= _OWN_LAG:
        pairs.append(np.diagonal(near, behind) if behind < len(rest) else np.empty(0))
    share = max((float(one.sum()) + 1) / (len(one) + 1) for one in pairs)
    return Copied(first, rows, behind, min(1.0, n**2 / 2 * share**rows))


def _longest_again(alike: IntArray) -> tuple[int, int, int]:
    """Return rows, first place and distance of the longest stretch of labels that comes again."""
    ends = np.zeros(len(alike) + 1, dtype=np.intp)
    longest = (0, 0, 0)
    for k in range(1, len(alike)):
        ends[1:] = (ends[:-1] + 1) * (alike == alike[k - 1])
        follows = (ends[:k] + 1) * (alike[:k] == alike[k])
        at = int(np.argmax(follows))
        if follows[at] > longest[0]:
            longest = (int(follows[at]), k + 1 - int(follows[at]), k - at)
    return longest


def exchanged_in(cycle: IntArray, a: Axis, b: Axis, rows: IntArray) -> str:
    """Return in words where two axes change places in ``rows`` of ``cycle``, else nothing.

    Of all stretches of rows, the one is taken that leaves the least spread when exchanged back.
    Both axes must then go on within it where they were outside of it. Of more than a thousand rows
    nothing is said: nobody typed them.
    """
    n = len(rows)
    if a.dimension != b.dimension or not _FEWEST_TYPED <= n <= _MOST_TYPED:
        return ""
    readings = np.stack([a.readings[rows], b.readings[rows]])
    readings = readings - readings.mean()
    sums = readings.sum(axis=1)
    moved = np.concatenate([[0.0], np.cumsum(readings[1] - readings[0])])
    by = moved[None, :] - moved[:, None]  # from a row to before another
    spread = float((readings**2).sum())
    left = spread - ((sums[0] + by) ** 2 + (sums[1] - by) ** 2) / n
    left[np.tril_indices(n + 1)] = np.inf
    left[0] = np.inf  # the rows behind say the same
    first, behind = np.unravel_index(np.argmin(left), left.shape)
    within = np.zeros(n, dtype=bool)
    within[first:behind] = True
    back = np.where(within, readings[::-1], readings)
    division = max(a.resolution or 0.0, b.resolution or 0.0)
    scatter = np.maximum(_scatter_of(back, within), division / math.sqrt(12))
    error = scatter * math.sqrt(1 / within.sum() + 1 / (n - within.sum()))
    away = np.abs(back[:, within].mean(axis=1) - back[:, ~within].mean(axis=1))
    before = spread - float((sums**2).sum()) / n
    if before <= _EXCHANGED * n * float((scatter**2).sum()) or np.any(away > _GOES_ON * error):
        return ""
    since = cycle[first]
    when = f"from cycle {since} on" if behind == n else f"at cycles {since} to {cycle[behind - 1]}"
    when = f"at cycle {since}" if behind - first == 1 else when
    return f"{when} {a.name} lies where {b.name} was, and {b.name} where {a.name} was"


def _scatter_of(readings: FloatArray, within: npt.NDArray[np.bool_]) -> FloatArray:
    """Return the standard deviation of rows (k, n) about their means within and without."""
    parts = [readings[:, within], readings[:, ~within]]
    squares = sum(((part - part.mean(axis=1, keepdims=True)) ** 2).sum(axis=1) for part in parts)
    return np.asarray(np.sqrt(squares / (len(within) - 2)))


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
