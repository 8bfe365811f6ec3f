"""How one axis comes to rest: the pose attained, and what happens before it is kept.

The stabilisation time runs from the first entry into the limit band about the attained pose, after
the farthest point of the motion, to the last; the overshoot is the largest distance beyond the
attained pose after that entry, 0 where it stays in the band. Clauses 7.4 and 7.5 as known in the
trade.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scara_iso.run import FloatArray

_NEAR_TOP = 0.9  # a swing differs there from a parabola by less than 0.1 % of it
_FEWEST_ON_PARABOLA = 4


@dataclass(frozen=True, slots=True)
class Settling:
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

    The largest of many samples would be read too large by a few times their scatter.
    """
    top = int(np.argmax(beyond))
    below = np.flatnonzero(beyond < _NEAR_TOP * beyond[top])
    k = int(np.searchsorted(below, top))
    first = int(below[k - 1]) + 1 if k else 0
    last = int(below[k]) if k < len(below) else len(beyond)
    if last - first < _FEWEST_ON_PARABOLA:
        return float(beyond[top])
    at = np.arange(first, last) - top
    bend, slope, height = np.polyfit(at, beyond[first:last], 2).tolist()
    return float(beyond[top]) if bend >= 0 else float(height - slope**2 / (4 * bend))


def _crossing(time: FloatArray, off: FloatArray, before: int, level: float) -> float:
    """Return when the line from sample ``before`` to the next crosses ``level``."""
    rise = off[before + 1] - off[before]
    share = float(np.clip((level - off[before]) / rise, 0, 1)) if rise else 1.0
    return float(time[before] + share * (time[before + 1] - time[before]))
