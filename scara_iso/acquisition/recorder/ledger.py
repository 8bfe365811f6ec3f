"""The visits of a session on the disk: what is stored, what is struck, and what is awaited."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from scara_iso.acquisition.recorder.axis_readings import VOIDABLE
from scara_iso.acquisition.recorder.bench import Taken
from scara_iso.acquisition.recorder.events import CycleDone, Said, Stored, Voided, Waiting
from scara_iso.acquisition.recorder.gauge import Gauge
from scara_iso.acquisition.recorder.journal import Journal
from scara_iso.acquisition.recorder.plan import RecordingPlan
from scara_iso.acquisition.recorder.position import Position
from scara_iso.acquisition.recorder.shown import gross_reading
from scara_iso.quantities import parse_unit


class Ledger:
    """``visit`` is the one awaited, ``present`` the axes that have it; ``tell`` hears what is done.

    A reading is told only when it is safe on the disk. Raises `WriteError` where the disk fails.
    """

    def __init__(
        self,
        gauges: Mapping[str, Gauge],
        *,
        plan: RecordingPlan,
        journal: Journal,
        tell: Callable[[Said], None],
        position: Position,
    ) -> None:
        self._gauges = gauges
        self._plan = plan
        self._tour = plan.tour
        self._journal = journal
        self._tell = tell
        self._latest = deque(position.latest, maxlen=VOIDABLE)
        self._stored_at: dict[str, float] = {}
        self.visit = self.first_visit = position.visit
        self.present = set(position.present)

    @property
    def is_full(self) -> bool:
        """Whether every cycle is recorded."""
        return self.visit > self._plan.visits

    @property
    def can_void(self) -> bool:
        """Whether there is a reading that may still be struck out."""
        return bool(self._latest)

    @property
    def missing(self) -> tuple[str, ...]:
        """The axes that the visit awaited lacks."""
        return tuple(axis for axis in self._gauges if axis not in self.present)

    def stored_at(self, axis: str) -> float:
        """Return when the last stored reading of an axis arrived [s]."""
        return self._stored_at.get(axis, -math.inf)

    def store(self, readings: Sequence[Taken]) -> None:
        """Write readings of the visit, make them safe, and only then say so."""
        stored, gross = [], []
        cycle, pose = self._tour.place(self.visit)
        for taken in readings:
            gauge, text = taken.gauge, taken.reading.text
            unit = taken.reading.unit or gauge.unit or ""
            stored.append(Stored(cycle, gauge.axis, parse_unit(unit).read(text), text, unit, pose))
            if distance := gauge.shown.far(text, self.visit):
                gross.append(gross_reading(stored[-1], distance))
            self._journal.append(
                "stored",
                **self._tour.state(self.visit),
                axis=gauge.axis,
                text=text,
                unit=unit,
                at=round(taken.time, 6),
            )
            self._stored_at[gauge.axis] = taken.time
        self._journal.sync()
        for said in stored:
            self.present.add(said.axis)
            self._gauges[said.axis].shown.put(self.visit, said.text)
            self._latest.append((self.visit, said.axis))
            self._tell(said)
        self._finish_visit(cycle, pose)
        for found in gross:
            self._tell(found)
        self.say_waiting()

    def _finish_visit(self, cycle: int, pose: str | None) -> None:
        if not self.missing:
            self._tell(
                CycleDone(cycle, discarded=cycle == 1 and not self._plan.all_count, pose=pose)
            )
            self.visit += 1
            self.present.clear()

    def say_waiting(self) -> None:
        """Tell which visit is awaited, and of which axes."""
        if not self.is_full:
            cycle, pose = self._tour.place(self.visit)
            self._tell(Waiting(cycle, self.missing, pose))

    def void(self, reason: str, *, together: bool) -> None:
        """Strike out the last reading, or all of its visit where they were asked for together."""
        visit, axis = self._latest.pop()
        axes = [axis]
        while together and self._latest and self._latest[-1][0] == visit:
            axes.append(self._latest.pop()[1])
        self.strike(visit, axes, reason)

    def strike_last(self, axis: str, reason: str) -> None:
        """Strike out the last reading of an axis, and what was stored behind its visit."""
        for visit, name in reversed(self._latest):
            if name == axis:
                if visit != self.visit and self.present:
                    self.strike(self.visit, sorted(self.present), reason)
                self.strike(visit, [axis], reason)
                return

    def strike(self, visit: int, axes: Sequence[str], reason: str) -> None:
        """Strike readings out, and go on with the visit that lacks them."""
        for axis in axes:
            with suppress(ValueError):
                self._latest.remove((visit, axis))
        self._journal.append("void", **self._tour.state(visit), axes=axes, reason=reason)
        self._journal.sync()
        if visit != self.visit:
            self.visit, self.present = visit, set(self._gauges)
        self.present -= set(axes)
        for axis in axes:
            self._gauges[axis].shown.void(visit)
        cycle, pose = self._tour.place(visit)
        self._tell(Voided(cycle, tuple(axes), reason, pose))
        self.say_waiting()
