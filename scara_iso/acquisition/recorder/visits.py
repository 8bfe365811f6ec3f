"""Which readings that come by themselves are of one visit of the pose.

In a visit every gauge speaks once. One that speaks again has begun the next; so has one that
comes after half the time that lies between two visits. A damaged frame spoils its visit. One
that comes behind a whole visit, within that half of the gauge's last, was sent twice.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from statistics import median

_GAPS = 31


@dataclass(frozen=True, slots=True)
class Heard:
    """What a frame means: ``broken`` says why the visit before it stays without its readings.

    ``refused`` says why the frame itself is not a reading of a visit, or nothing.
    """

    broken: str
    refused: str
    mixed: int = 0
    """How many visits, the last ones, were taken for whole before one of them proved not to be."""


class Visits:
    """Follows gauges that send by themselves; ``timed`` where the time between frames counts."""

    def __init__(self, axes: Iterable[str], *, present: Iterable[str], timed: bool) -> None:
        self._axes = frozenset(axes)
        self._spoke = set(present)
        self._timed = timed
        self._began = math.inf
        self._spoilt = ""
        self._last: dict[str, tuple[float, list[str]]] = {}
        self._done = False
        self._gaps: dict[int, deque[float]] = {}
        """Time from one visit to the next [s], by the pose of the next."""
        self._untimed: list[float] = []
        """How long the visits took before the time between them was known [s]."""

    def hear(self, axis: str, time: float, *, whole: bool, pose: int = 0) -> Heard:
        """Take a frame of a gauge, ``whole`` or damaged, at ``time`` [s].

        ``pose`` is the number of the one that is awaited: the ways between poses differ.
        """
        half = self._half(pose)
        if self._done and axis in self._last and time - self._last[axis][0] < half:
            return Heard(
                "", f"{axis} sent twice, or not in turn: visits are {2 * half:.1f} s apart"
            )
        self._measure(axis, time, pose)
        half = half or self._half(pose)
        mixed = self._take_mixed(half)
        broken = self._next_visit(axis, time, half)
        if broken:
            self._end()
        if not self._spoke:
            self._began = time
        self._spoke.add(axis)
        if not whole:
            self._spoilt = axis
            broken = broken or f"the frame of {axis} was damaged"
        refused = f"the frame of {self._spoilt} was damaged: send all again" if self._spoilt else ""
        self._done = self._spoke == self._axes and not refused
        if self._done and not half:
            self._untimed.append(time - self._began)
        if self._spoke == self._axes:
            self._end()
        return Heard(broken, refused, mixed)

    def judged(self) -> None:
        """Leave the visits so far as they are: the operator has looked at them."""
        self._untimed.clear()

    def _half(self, pose: int) -> float:
        gaps = self._gaps.get(pose)
        return median(gaps) / 2 if self._timed and gaps else 0.0

    def _take_mixed(self, half: float) -> int:
        """Return how many visits were untimed, once, if one of them took too long to be one."""
        if not half:
            return 0
        lasted, self._untimed = self._untimed, []
        return len(lasted) if max(lasted, default=0.0) > half else 0

    def _next_visit(self, axis: str, time: float, half: float) -> str:
        if axis in self._spoke:
            missing = ", ".join(sorted(self._axes - self._spoke))
            return f"{axis} has sent again, and {missing} had sent none"
        if self._spoke and 0 < half < time - self._began:
            return f"{axis} came {time - self._began:.1f} s later, as of the next visit"
        return ""

    def _measure(self, axis: str, time: float, pose: int) -> None:
        """Take the time of a visit since the gauge spoke last, if every other one spoke between."""
        before, others = self._last.get(axis, (0.0, []))
        if others and set(others) == self._axes - {axis}:
            gaps = self._gaps.setdefault(pose, deque(maxlen=_GAPS))
            gaps.append((time - before) / max(map(others.count, others)))
        for name, (_, spoke) in self._last.items():
            if name != axis:
                spoke.append(axis)
        self._last[axis] = (time, [])

    def _end(self) -> None:
        self._spoke.clear()
        self._spoilt = ""
