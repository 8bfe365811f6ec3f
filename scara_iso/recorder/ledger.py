"""The ledger: which visits are on the disk, which are struck, and which is awaited."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from scara_iso.base.quantities import parse_unit
from scara_iso.rawfile import VOIDABLE, History
from scara_iso.recorder.events import CycleDone, Gross, Said, Stored, Voided, Waiting
from scara_iso.recorder.gauge import Gauge, Taken
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.plan import Job


class Ledger:
    """``visit`` is the one awaited, ``present`` the axes that have it; ``tell`` hears what is done.

    A reading is told only when it is safe on the disk. Raises `WriteError` where the disk fails.
    """

    def __init__(
        self,
        gauges: Mapping[str, Gauge],
        *,
        job: Job,
        journal: Journal,
        tell: Callable[[Said], None],
        earlier: History,
    ) -> None:
        self._gauges = gauges
        self._job = job
        self._tour = job.plan.tour
        self._journal = journal
        self._tell = tell
        self._latest = deque(earlier.latest, maxlen=VOIDABLE)
        self._stored_at: dict[str, float] = {}
        self.visit = earlier.visit
        self.asks = "v strikes the last reading" if self.is_full else ""
        """What is to be asked of the last visit before the recording ends."""
        self.present = set(earlier.present(self.visit))
        for axis, column in earlier.columns.items():
            for visit, one in column.shown.items():
                gauges[axis].shown.put(visit, one.text)

    @property
    def is_full(self) -> bool:
        """Whether every cycle is recorded."""
        return self.visit > self._job.plan.visits

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
        stored = []
        cycle, pose = self._tour.place(visit := self.visit)
        for taken in readings:
            axis, text = taken.gauge.axis, taken.reading.text
            unit = taken.reading.unit or taken.gauge.unit or ""
            stored.append(Stored(cycle, axis, parse_unit(unit).read(text), text, unit, pose))
            at = round(taken.time, 6)
            self._journal.append(
                "stored", **self._tour.state(visit), axis=axis, text=text, unit=unit, at=at
            )
            self._stored_at[axis] = taken.time
        self._journal.sync()
        for said in stored:
            self.present.add(said.axis)
            self._gauges[said.axis].shown.put(visit, said.text)
            self._latest.append((visit, said.axis))
            self._tell(said)
        if not self.missing:
            discarded = cycle == 1 and not self._job.all_count
            self._tell(CycleDone(cycle, discarded=discarded, pose=pose))
            self.visit += 1
            self.present.clear()
        self.asks = "; ".join(filter(None, [self._say_gross(said, visit) for said in stored]))
        self.say_waiting()

    def _say_gross(self, stored: Stored, visit: int) -> str:
        """Tell where a stored reading is far from the others, in the display's unit."""
        asks, unit = "", parse_unit(stored.unit)
        for far, value, distance in self._gauges[stored.axis].shown.gross(visit):
            how = "v strikes it" if far == visit else "v strikes the last, and again back to it"
            message = (
                f"{stored.axis} {value} {stored.unit} of {self._tour.name(far)} is "
                f"{distance:.1g} {stored.unit} from the others; {how}"
            )
            (cycle, pose), away = self._tour.place(far), unit.read(str(distance))
            self._tell(Gross(cycle, stored.axis, unit.read(str(value)), away, message, pose))
            asks = message if far == visit else asks
        return asks

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
