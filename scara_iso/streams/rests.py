"""Where a stream is at rest: the windows in which no length moves more than a threshold.

The rule has two parameters: a window that slides over the stream, and the largest range of the
readings within it at rest. Unless the user states that threshold it is the one on which least
depends: the number of rests is counted under thresholds from the dial's division to the largest
range, and of the stretches of them with one number that span a factor of three the one with the
most rests is taken, at twice its low end. The most, since a dial that nothing touches is stiller
than one at a pose, and a threshold between the two would lose every visit. What comes or goes by
halving or doubling the threshold, and the other stretches, are for the caller to list.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from scara_iso.run import FloatArray

FEWEST_IN_WINDOW = 5
NARROWEST = 3.0  # benchmarks/visits.py
"""Factor over which the number of rests must not depend on the threshold."""
_FINENESS = 4 / 3
_GAP = 5.0
"""Sampling intervals between two samples beyond which some are missing."""


@dataclass(frozen=True, slots=True)
class Rest:
    """A stretch at rest: samples ``first`` to ``last``, both of it."""

    first: int
    last: int


@dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """The range of the readings in the window around each sample, and where samples miss."""

    ranges: FloatArray
    """Shape (n,): the largest of the axes', in their unit; infinite across missing samples."""
    window: int
    """Samples in a window, an odd number."""
    gaps: tuple[int, ...]
    """Samples behind which others are missing."""


def motion(time: FloatArray, readings: list[FloatArray], window_s: float) -> Motion:
    """Return how far the ``readings``, shape (n,) each, move within a window of ``window_s``."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d  # noqa: PLC0415 - 0.1 s

    step = np.diff(time)
    interval = float(np.median(step))
    size = max(FEWEST_IN_WINDOW, 2 * round(window_s / interval / 2) + 1)
    ranges = np.zeros(len(time))
    for values in readings:
        highest, lowest = maximum_filter1d(values, size), minimum_filter1d(values, size)
        np.maximum(ranges, highest - lowest, out=ranges)
    gaps = np.flatnonzero(step > _GAP * interval).tolist()
    for gap in gaps:
        ranges[max(0, gap - size // 2 + 1) : gap + size // 2 + 1] = math.inf
    return Motion(ranges, size, tuple(gaps))


@dataclass(frozen=True, slots=True)
class Plateau:
    """Thresholds between ``low`` and ``high`` under which the stream has ``count`` rests."""

    low: float
    high: float
    count: int

    @property
    def factor(self) -> float:
        """How far it reaches."""
        return self.high / self.low


def plateaus(found: Motion, least: float, long: int) -> list[Plateau]:
    """Return the ranges of thresholds with one number of rests of ``long`` samples or more.

    Those with most rests come first, and only those that span `NARROWEST`. ``least`` is the
    smallest range distinguished from none: the dial's division. Thresholds are a third apart,
    and windows a quarter of a window.
    """
    step = max(1, found.window // 4)
    ranges = found.ranges[::step]
    known = ranges[np.isfinite(ranges)]
    steps = math.log(max(float(known.max()) / least, 1.0)) / math.log(_FINENESS)
    thresholds = least * _FINENESS ** np.arange(math.ceil(steps))
    need = (long - found.window) / step
    counts = [_count(ranges <= threshold, need) for threshold in thresholds.tolist()]
    edges = [0, *(np.flatnonzero(np.diff(counts)) + 1).tolist(), len(counts)]
    made = [
        Plateau(float(thresholds[i]), float(thresholds[j - 1]) * _FINENESS, counts[i])
        for i, j in pairwise(edges)
        if i < j and counts[i] > 0
    ]
    wide = [one for one in made if one.factor >= NARROWEST]
    return sorted(wide, key=lambda one: (-one.count, -one.factor))


def _count(quiet: npt.NDArray[np.bool_], need: float) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]]).astype(np.int8)))
    return int(np.count_nonzero(edges[1::2] - edges[::2] >= need))


def still_of(plateau: Plateau) -> float:
    """Return the threshold of a plateau: twice its low end, but not beyond its middle."""
    return float(f"{plateau.low * min(2.0, math.sqrt(plateau.factor)):.2g}")


def find_rests(found: Motion, still: float) -> list[Rest]:
    """Return the stretches in which every window's range is at most ``still``, in order."""
    quiet = np.concatenate([[False], found.ranges <= still, [False]])
    edges = np.flatnonzero(np.diff(quiet.astype(np.int8)))
    half, last = found.window // 2, len(found.ranges) - 1
    rests: list[Rest] = []
    for begin, end in edges.reshape(-1, 2).tolist():
        rest = Rest(max(0, begin - half), min(last, end - 1 + half))
        if rests and rest.first <= rests[-1].last:  # windows at rest that share samples
            rest = Rest(rests.pop().first, rest.last)
        rests.append(rest)
    return rests
