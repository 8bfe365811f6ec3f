"""Where a stream is at rest: the windows in which no length moves more than a threshold.

The rule has two parameters: a window that slides over the stream, and the largest range of the
readings within it at rest. Unless the user states that threshold it is the one on which least
depends: the number of rests is counted under thresholds from the dial's division to the largest
range, and of the stretches of them with one number that span a factor of three the one with the
most rests is taken, at twice its low end. The most, since a dial that nothing touches is stiller
than one at a pose, and a threshold between the two would lose every visit. What comes or goes by
halving or doubling the threshold, and the other stretches, are for the caller to list.

An arrival is how one axis comes to rest: the pose attained, and what happens before it is kept. The
stabilisation time runs from the first entry into the limit band about the attained pose, after
the farthest point of the motion, to the last; the overshoot is the largest distance beyond the
attained pose after that entry, 0 where it stays in the band. Clauses 7.4 and 7.5 as known in the
trade.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from scara_iso.base.displayed import Displayed
from scara_iso.base.published import INTERNAL, Count, Size
from scara_iso.run import AxisKey, FloatArray, IntArray, Run

if TYPE_CHECKING:
    import pandas as pd


FEWEST_IN_WINDOW = 5
NARROWEST = 3.0  # benchmarks/visits.py
"""Factor over which the number of rests must not depend on the threshold."""
_FINENESS = 4 / 3
_GAP = 5.0
"""Sampling intervals between two samples beyond which some are missing."""


class Rest(NamedTuple):
    """A stretch at rest: samples ``first`` to ``last``, both of it."""

    first: int
    last: int


class Motion(NamedTuple):
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


class Plateau(NamedTuple):
    """Thresholds between ``low`` and ``high`` under which the stream has so many ``rests``."""

    low: float
    high: float
    rests: int


def plateaus(found: Motion, least: float, long: int) -> list[Plateau]:
    """Return the ranges of thresholds with one number of rests of ``long`` samples or more.

    Those with most rests come first, and only those that span `NARROWEST`. ``least`` is the
    smallest range distinguished from none: the dial's division. Thresholds are a third apart,
    and windows a quarter of a window.
    """
    step = max(1, found.window // 4)
    ranges = found.ranges[::step]
    known = ranges[np.isfinite(ranges)]
    if not len(known):
        return []
    steps = math.log(max(float(known.max()) / least, 1.0)) / math.log(_FINENESS)
    thresholds = least * _FINENESS ** np.arange(math.ceil(steps))
    need = (long - found.window) / step
    stretches = [_stretches(ranges <= threshold) for threshold in thresholds.tolist()]
    counts = [int(np.count_nonzero(np.diff(found) >= need)) for found in stretches]
    edges = [0, *(np.flatnonzero(np.diff(counts)) + 1).tolist(), len(counts)]
    made = [
        Plateau(float(thresholds[i]), float(thresholds[j - 1]) * _FINENESS, counts[i])
        for i, j in pairwise(edges)
        if i < j and counts[i] > 0
    ]
    wide = [one for one in made if one.high / one.low >= NARROWEST]
    return sorted(wide, key=lambda one: (-one.rests, -one.high / one.low))


def _stretches(quiet: npt.NDArray[np.bool_]) -> IntArray:
    """Return first sample and the one behind the last of each quiet stretch, shape (n, 2)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2)


def still_of(plateau: Plateau) -> float:
    """Return the threshold of a plateau: twice its low end, but not beyond its middle."""
    return float(f"{plateau.low * min(2.0, math.sqrt(plateau.high / plateau.low)):.2g}")


def find_rests(found: Motion, still: float) -> list[Rest]:
    """Return the stretches in which every window's range is at most ``still``, in order."""
    half, last = found.window // 2, len(found.ranges) - 1
    rests: list[Rest] = []
    for begin, end in _stretches(found.ranges <= still).tolist():
        rest = Rest(max(0, begin - half), min(last, end - 1 + half))
        if rests and rest.first <= rests[-1].last:  # windows at rest that share samples
            rest = Rest(rests.pop().first, rest.last)
        rests.append(rest)
    return rests


_NEAR_TOP = 0.9  # a swing differs there from a parabola by less than 0.1 % of it
_FEWEST_ON_PARABOLA = 4


class Settling(NamedTuple):
    """One arrival along one axis: times in s, lengths in mm, angles in degrees."""

    direction: int
    """+1 where the reading rose to the pose, -1 where it fell, 0 where it hardly moved."""
    settled: int | None
    """The sample from which the band is kept; None where it is left beyond the middle."""
    stabilisation_s: float | None
    overshoot: float | None


def middle(first: int, last: int) -> tuple[int, int]:
    """Return the first and the last sample of the middle half of a rest.

    Where the arrival's tail is over and the departure has not begun.
    """
    quarter = (last - first + 1) // 4
    return first + quarter, last - quarter


def arrive(time: FloatArray, readings: FloatArray, rest: int, pose: float, band: float) -> Settling:
    """Return the arrival of ``readings``, shape (n,): the motion, then from ``rest`` on the rest.

    They end where the middle half of the rest does; ``band`` is the half width of the limit band
    about ``pose``.
    """
    off = readings - pose
    far = int(np.argmax(np.abs(off[: rest + 1])))
    direction = 0 if abs(off[far]) <= band else -int(np.sign(off[far]))
    outside = np.flatnonzero(np.abs(off) > band)
    last = int(outside[-1]) if len(outside) else -1
    if last >= rest + 2 * (len(off) - rest) // 3:  # two thirds of three quarters: its middle
        return Settling(direction, None, None, None)
    if direction == 0:
        return Settling(0, last + 1, None, None)
    # Not the first sample in the band: a fast arrival crosses it between two samples.
    entry = far + int(np.argmax(direction * off[far:] >= -band))
    entered = _crossing(time, off, entry - 1, -direction * band)
    stays = _crossing(time, off, last, band if off[last] > 0 else -band)
    beyond = direction * off[entry:]
    overshoot = _peak(beyond) if beyond.max() > band else 0.0
    return Settling(direction, last + 1, max(stays - entered, 0.0), overshoot)


def _peak(beyond: FloatArray) -> float:
    """Return the height of the largest peak: of the parabola through what is near its top.

    The largest of many samples would be read too large by a few times their scatter. Of a slow
    stream few samples are near the top: there it is that of the swing about the pose through the
    highest sample and those on both sides.
    """
    top = int(np.argmax(beyond))
    below = np.flatnonzero(beyond < _NEAR_TOP * beyond[top])
    k = int(np.searchsorted(below, top))
    first = int(below[k - 1]) + 1 if k else 0
    last = int(below[k]) if k < len(below) else len(beyond)
    if last - first < _FEWEST_ON_PARABOLA:
        return _of_swing(beyond[max(top - 1, 0) : top + 2])
    at = np.arange(first, last) - top
    bend, slope, height = np.polyfit(at, beyond[first:last], 2).tolist()
    return float(beyond[top]) if bend >= 0 else float(height - slope**2 / (4 * bend))


def _of_swing(near: FloatArray) -> float:
    """Return the height of a cosine about 0 through three samples, the middle one the highest."""
    height = float(near.max())
    if len(near) < 3 or near[0] + near[2] <= 0 or near[0] + near[2] >= 2 * height:
        return height
    angle = math.acos(float(near[0] + near[2]) / (2 * height))
    return math.hypot(height, float(near[2] - near[0]) / (2 * math.sin(angle)))


def _crossing(time: FloatArray, off: FloatArray, before: int, level: float) -> float:
    """Return when the line from sample ``before`` to the next crosses ``level``."""
    rise = off[before + 1] - off[before]
    share = float(np.clip((level - off[before]) / rise, 0, 1)) if rise else 1.0
    return float(time[before] + share * (time[before + 1] - time[before]))


DOUBTS = (
    "begins-at-rest",
    "short-rest",
    "creeps",
    "interrupted",
    "long-rest",
    "threshold",
    "missing-samples",
    "does-not-settle",
)
Seconds: TypeAlias = Annotated[float, ("unit", "s")]
Duration: TypeAlias = Annotated[float, ("unit", "s"), ("minimum", 0)]
SizeByAxis: TypeAlias = Mapping[AxisKey, Size]


@dataclass(frozen=True, slots=True)
class Visit:
    """One stay at a pose; times in s of the stream, lengths in mm, angles in degrees."""

    start: Seconds
    """First sample at rest."""
    settled: Seconds
    """From here on every axis keeps the limit band."""
    end: Seconds
    """Last sample at rest."""
    averaged: tuple[Seconds, Seconds]
    """First and last sample of the reading."""
    samples: Count
    """Of the mean."""
    mean: Mapping[AxisKey, float]
    """By axis, over `averaged`: the reading."""
    scatter: SizeByAxis
    """Their standard deviation, by axis."""
    approach: Mapping[AxisKey, Annotated[int, ("enum", (-1, 0, 1))]]
    """By axis: +1 where the reading rose to the pose, -1 where it fell, 0 where it hardly moved."""
    stabilisation_s: Mapping[AxisKey, Duration | None]
    """By axis; null where it cannot be told."""
    overshoot: Mapping[AxisKey, Size | None]
    """By axis; null, as `stabilisation_s`, where it hardly moved or the stream is too slow."""
    pose: str | None
    """Label; null where the stream has one pose."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """A stretch of the stream that is not plainly a visit, or a visit that is not plainly one."""

    code: Annotated[str, ("enum", DOUBTS)]
    """Kind of doubt, a word."""
    start: Seconds
    """Begin of the stretch."""
    end: Seconds
    """End of the stretch."""
    message: str
    """What is doubtful, in a sentence."""
    counted: bool
    """Whether it is among the visits nevertheless."""


@dataclass(frozen=True, slots=True)
class Rule:
    """The parameters by which rest is distinguished from motion, as used; lengths in mm."""

    dwell_s: Duration
    """Shortest rest that is a visit."""
    window_s: Duration
    """Length of the sliding window."""
    samples_in_window: Count
    """How many samples the window holds."""
    still: Size
    """Largest range of the readings within a window at rest."""
    still_stated: bool
    """Whether the user stated it; else the one on which the number of rests depends least."""
    band: SizeByAxis
    """Half width of the limit band, by axis."""
    band_stated: bool
    """Whether the user stated it; else it is made of the scatter at rest."""


@dataclass(frozen=True, eq=False, slots=True)
class SegmentedStream(Displayed):
    """The visits of a stream, and the table that they are."""

    run: Run = field(metadata=INTERNAL)
    """A row for each visit, with time_s, approach and what the stream's head stated."""
    visits: tuple[Visit, ...] = field(metadata=INTERNAL)
    """In the order of time, one for each row of `run`."""
    doubts: tuple[Doubt, ...]
    """What is not plainly a visit."""
    rule: Rule
    """What distinguished rest from motion."""
    samples: Count
    """Of the whole stream."""
    rate_hz: Annotated[float, ("unit", "Hz"), ("minimum", 0)]
    """Samples a second, the median."""
    notes: tuple[str, ...]
    """What else is to be known of the reading, in words."""

    def to_frame(self) -> pd.DataFrame:
        """Return the visits as a pandas table, a row for each."""
        return self.run.to_frame()

    def __repr__(self) -> str:
        of_it = f"{type(self).__name__} of {self.run.origin.source or 'a stream'}"
        return f"<{of_it}: {len(self.visits)} visits, {len(self.doubts)} doubts>"
