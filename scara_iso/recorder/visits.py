"""Visits of the pose: when readings are those of one, and what of them is on the disk.

Readings are of gauges that send by themselves, or of a dial that is watched.

In a visit every gauge speaks once, in any order, and no gap within it is as long as the pause
after it, or as two thirds of the pauses between the visits before it. Where frames contradict this
they are parted at the longest gap: what lies before it is of another visit. A damaged frame spoils
its visit.

By the rule of ``settled`` a visit is a movement and then a rest. The dial has moved when it showed
more than ``away`` from where it rested last (at the first visit: from where it stood when the
session began). It rests when all readings of the last ``rest`` seconds, three or more, lie within
``within`` divisions. A free plunger stands still too: the first visit to a pose is not a rest
within ``away`` of where the dial stood when the session began, and each later one is within
``away`` of the visit to that pose before. So the session begins while the arm is off the dial.

The ledger keeps which visits are on the disk, which are struck, and which is awaited.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

from scara_iso.base.quantities import parse_unit
from scara_iso.rawfile import TWICE, VOIDABLE, History
from scara_iso.recorder.events import CycleDone, Gross, Said, Stored, Voided, Waiting
from scara_iso.recorder.gauge import Gauge, Taken
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.plan import Job, Settled

_PAUSES = 5
"""How many of the latest count."""
_SHARE = 2 / 3
"""Of a pause; both by benchmarks/line_faults.py (frames that miss in a row) and tours.py (none)."""


@dataclass(frozen=True, slots=True)
class Heard:
    """What a frame means for the readings that there are."""

    kept: frozenset[str]
    """The axes that have spoken in the same visit."""
    doubt: str = ""
    """Why readings of other axes, stored behind the last whole visit, are of another visit."""
    back: bool = False
    """Whether the last visit that was whole is in doubt too."""
    refused: str = ""
    """Why the frame itself is not a reading of a visit."""


class _Frame(NamedTuple):
    gap: float
    """Since the frame before it in the same visit [s]."""
    text: str | None
    """What it says, None of a damaged one."""


class Visits:
    """Follows gauges that send by themselves; ``timed`` where the time between frames counts.

    ``one_pose`` takes a frame that says in one visit what its gauge has said for the same reading
    sent twice: at one pose it may stand for either.
    """

    def __init__(
        self, axes: Iterable[str], *, present: Iterable[str], timed: bool, one_pose: bool
    ) -> None:
        self._axes = frozenset(axes)
        self._timed = timed
        self._one_pose = one_pose
        self._frames = dict.fromkeys(present, _Frame(0.0, ""))
        self._before: dict[str, str | None] = {}
        self._pauses: deque[float] = deque(maxlen=_PAUSES)
        """Between whole visits [s]; each doubt takes away the shortest."""
        self._last: float | None = None

    def hear(self, axis: str, time: float, text: str | None) -> Heard:
        """Take a frame of a gauge at ``time`` [s]; ``text`` is None where it was damaged."""
        gap = time - self._last if self._timed and self._last is not None else 0.0
        whole, fits = self._frames.keys() == self._axes, self._fits(axis, gap)
        if not fits and self._one_pose and self._repeats(axis, text, gap, whole=whole):
            return Heard(frozenset(self._frames), refused=f"{axis} {TWICE}")
        self._last = time
        doubt, back = "", False
        if not fits:
            doubt = self._reason(axis, gap, whole=whole)
            back = self._part(axis, gap, whole=whole)
        elif whole:
            self._begin(gap)
        self._frames[axis] = _Frame(gap if self._frames else 0.0, text)
        refused = self._spoilt()
        kept = frozenset[str]() if refused else frozenset(self._frames) - {axis}
        return Heard(kept, doubt, back=back, refused=refused)

    def forget(self, axis: str) -> None:
        """Take the last frame of a gauge for unsaid: it is asked for again."""
        del self._frames[axis]

    def _pause(self) -> float:
        return min(self._pauses, default=math.inf)

    def _spoilt(self) -> str:
        damaged = [axis for axis, frame in self._frames.items() if frame.text is None]
        return f"the frame of {damaged[0]} was damaged: send all again" if damaged else ""

    def _fits(self, axis: str, gap: float) -> bool:
        """Say whether a frame begins the next visit, or goes on with this one."""
        if self._frames.keys() == self._axes:
            longest = max(frame.gap for frame in self._frames.values())
            return not self._timed or gap > longest or bool(self._spoilt())
        near = axis not in self._frames and gap < _SHARE * self._pause()
        return near or not self._frames  # its only frame was asked for again

    def _repeats(self, axis: str, text: str | None, gap: float, *, whole: bool) -> bool:
        said = self._frames[axis].text if axis in self._frames else None
        return text is not None and text == said and (whole or gap < _SHARE * self._pause())

    def _reason(self, axis: str, gap: float, *, whole: bool) -> str:
        if whole:
            return f"{axis} came {gap:.1f} s later: a frame of another visit was among them"
        if axis in self._frames:
            missing = ", ".join(sorted(self._axes - self._frames.keys()))
            return f"{axis} has sent again, and {missing} had sent none"
        return f"{axis} came {gap:.1f} s later, as of the next visit"

    def _begin(self, gap: float) -> None:
        if self._timed and not self._spoilt():
            self._pauses.append(gap)
        self._before = {axis: frame.text for axis, frame in self._frames.items()}
        self._frames.clear()

    def _part(self, axis: str, gap: float, *, whole: bool) -> bool:
        """Leave the frames behind the longest gap; return whether a whole visit is in doubt too.

        That is this one, or the one before where what is left out lay much nearer to it: then a
        frame sent twice may have stood in it for one of these.
        """
        names, gaps = list(self._frames), [*(f.gap for f in self._frames.values()), gap]
        cut = max(range(1, len(gaps)), key=lambda k: (gaps[k], k))
        others = any(self._before.get(a) != frame.text for a, frame in self._frames.items())
        near = bool(self._pauses) and self._pauses[-1] < gap / 2
        back = whole or (cut == len(names) and others and near)
        left = [name for name in names[cut:] if name != axis]
        self._frames = {name: self._frames[name] for name in left}
        if left:
            self._frames[left[0]] = self._frames[left[0]]._replace(gap=0.0)
        if self._pauses:  # one that was none, as of a visit sent twice, is believed once only
            self._pauses.remove(self._pause())
        return back


FEWEST = 3
_SLACK = 1e-6
"""Of a division: what rounding in binary adds to a difference of decimals."""


class AtRest:
    """Follows all axes together; values in mm or degrees, times in seconds."""

    def __init__(self, rule: Settled, visits: Mapping[str | None, Mapping[str, float]]) -> None:
        """``visits`` are those before this session, the latest of each pose, the very last last."""
        self.rule = rule
        self._places = dict(visits)
        self._last = next(reversed(self._places.values()), {})
        self._begun: dict[str, float] = {}
        self._moved = False
        self._window: deque[tuple[float, Mapping[str, float]]] = deque()

    def arrived(
        self,
        time: float,
        values: Mapping[str, float],
        divisions: Mapping[str, float],
        pose: str | None = None,
    ) -> bool:
        """Take readings of every axis; return whether they are a visit to ``pose``."""
        self._begun = self._begun or dict(values)
        self._moved = self._moved or self._is_away(values, self._last or self._begun)
        if not self._moved:
            return False
        window = self._window
        window.append((time, values))
        while len(window) > FEWEST and time - window[1][0] >= self.rule.rest:
            window.popleft()
        while not self._is_still(divisions):
            window.popleft()
        if len(window) < FEWEST or time - window[0][0] < self.rule.rest - _SLACK:
            return False
        if pose in self._places:
            return not self._is_away(values, self._places[pose])
        return self._is_away(values, self._begun)

    def stored(self, values: Mapping[str, float], pose: str | None = None) -> None:
        """Go on from a visit that is on the disk: the next one needs a movement."""
        self._last = self._places[pose] = dict(values)
        self._moved = False
        self._window.clear()

    def _is_away(self, values: Mapping[str, float], place: Mapping[str, float]) -> bool:
        both = values.keys() & place.keys()
        return any(abs(values[axis] - place[axis]) > self.rule.away for axis in both)

    def _is_still(self, divisions: Mapping[str, float]) -> bool:
        reach = self.rule.within + _SLACK
        shown = {axis: [values[axis] for _, values in self._window] for axis in divisions}
        return all(max(x) - min(x) <= reach * divisions[axis] for axis, x in shown.items())


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
