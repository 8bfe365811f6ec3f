"""The gauges of a session, looked at together: what arrives, and readings on request."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain

from scara_iso.base.errors import UsageError
from scara_iso.rawfile import LATE, SECOND, THEN, UNASKED, UNIT_ASKED, History
from scara_iso.recorder.events import Noticed, Problem, ProblemKind, Refused, Said
from scara_iso.recorder.gauge import Gauge, HaltError, Taken, no_unit
from scara_iso.recorder.indicators import KEYBOARD, DeviceNotice, Garbage, InstrumentFault
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.plan import Job
from scara_iso.recorder.ports.port import Clock, Port

SETTLING_S = 10.0
"""Longest time that a value may take to settle, under the rule of equal readings [s]."""
QUIET = 5.0
"""A gauge no longer owes an answer when its line was quiet for so many answer times."""
NEVER_QUIET = 2.0 * QUIET
LATER = 1.25
LINGER_S = 0.02
"""A second answer is awaited for `LATER` times the longest that one took, and so much more [s].

Two that differ are no answer: a frame sent twice may come behind the next request, and before
its answer. Of a gauge that tells its unit the answer to that question is awaited instead: it comes
behind every answer that the gauge still owed.
"""

_OF_USB = re.compile(r"(?:serial|location) [^\s()]+(?= location |\))")
_OTHERWISE = "another answer says otherwise"
_TYPE_ALL = "type all decimals in every reading, as 0.500"


class Bench:
    """Several gauges on one clock; what is not a reading is written down and told at once."""

    def __init__(
        self,
        gauges: Sequence[Gauge],
        *,
        journal: Journal,
        clock: Clock,
        tell: Callable[[Said], None],
    ) -> None:
        self.gauges = gauges
        self._journal = journal
        self._clock = clock
        self._tell = tell
        self._faulted = False
        self._opening = True
        self._unreadable: set[str] = set()
        self.last_problem = ""

    def open(self) -> None:
        """Wait until the indicators are powered, refuse what is under way, and learn the units.

        What comes meanwhile is noticed: no trouble of the recording. Raises `UsageError` where
        nobody states the unit of a gauge.
        """
        self.drain(max(gauge.port.settle_s for gauge in self.gauges), "sent before the session")
        self.learn_units(self.gauges)
        for gauge in self.gauges:
            if gauge.unit is None and gauge.dialect.units == (None,):
                raise no_unit(gauge)
        self._opening = False
        self._unreadable.clear()

    def learn_units(self, gauges: Sequence[Gauge]) -> list[Taken]:
        """Ask gauges for their unit, and return the readings that came meanwhile: refused.

        Raises `HaltError` where it is another than before.
        """
        asked = (gauge.ask_unit(self._journal, self._clock) for gauge in gauges)
        deadline = max(asked, default=-math.inf)
        meanwhile: list[Taken] = []
        while self._clock.now() < deadline:
            meanwhile += (came := self.receive())
            self.refuse(came, UNIT_ASKED)
            if not any(gauge.unit_asked for gauge in gauges):
                break
            self._clock.idle(deadline)
        for gauge in gauges:
            gauge.unit_asked = False
            gauge.expect_from_now()
        return meanwhile

    def confirm(self, taken: Sequence[Taken]) -> bool:
        """Say whether readings hold: each gauge shows the unit it said, and has said nothing else.

        Raises as `learn_units`.
        """
        texts = {one.gauge.axis: one.reading.text for one in taken}
        asked = [one.gauge for one in taken if one.gauge.tells_unit]
        came = self.learn_units(asked)
        holds = all(one.reading.text == texts[one.gauge.axis] for one in came if _answers(one))
        holds &= self._unreadable.isdisjoint(gauge.axis for gauge in asked)
        if not holds:
            self.refuse(taken, _OTHERWISE)
        return holds

    def receive(self) -> list[Taken]:
        """Look at every port once and return the readings that have arrived."""
        readings = []
        for gauge in self.gauges:
            for arrival in gauge.receive(self._journal, self._clock):
                match arrival:
                    case Taken():
                        readings.append(arrival)
                    case Garbage(reason=reason, raw=raw):
                        self._unreadable.add(gauge.axis)
                        typed = gauge.dialect.key == KEYBOARD.key
                        why = f"not a reading; {_TYPE_ALL}" if typed else reason
                        self.problem(gauge, "garbage", f"{why}: {repr(raw)[1:]}")
                    case InstrumentFault(code=code, message=message):
                        self._faulted = True
                        self._unreadable.add(gauge.axis)
                        self.problem(gauge, "fault", f"{code}: {message}")
                    case DeviceNotice(message=message, switched_on=on):
                        if on and gauge.shown and not self._opening:
                            raise HaltError(
                                gauge.axis,
                                f"the indicator was switched off and on ({message}): its zero "
                                "is gone",
                                remedy="check its unit and set the old zero",
                            )
                        self._tell(Noticed(gauge.axis, message))
        return readings

    def measure(self, stable: int) -> list[Taken] | None:
        """Return one reading of every gauge, or None after saying what went wrong.

        ``stable`` readings of each gauge in a row are equal.
        """
        series: list[list[Taken]] = []
        until = self._clock.now() + SETTLING_S
        while not series or self._clock.now() < until:
            taken = self._ask()
            if taken is None:
                return None
            series = [*series, taken][-stable:]
            restless = [
                each[-1].gauge
                for each in zip(*series, strict=True)
                if len({one.reading.value for one in each}) > 1
            ]
            if len(series) == stable and not restless:
                return taken
        for gauge in restless or self.gauges:
            self.problem(gauge, "unsettled", f"not {stable} equal readings in {SETTLING_S:g} s")
        return None

    def drain(self, seconds: float, reason: str) -> None:
        """Refuse what arrives for a while, and for as long as late answers may still come."""
        start = self._clock.now()
        end = start + max(
            [seconds, *(NEVER_QUIET * g.dialect.answer_time_s for g in self._owing())]
        )
        while (now := self._clock.now()) < end:
            until = max([start + seconds, *(g.quiet_after(QUIET) for g in self._owing())])
            if now >= until:
                break
            self.refuse(self.receive(), reason)
            self._clock.idle(until)
        for gauge in self._owing():
            if gauge.quiet_after(QUIET) <= self._clock.now() and (dropped := gauge.drop_pending()):
                self.problem(gauge, "garbage", dropped.reason)

    def doubt(self, readings: Iterable[Taken], visit: int) -> bool:
        """Say whether a display seems changed; `HaltError` at the second such answer.

        One of them may be a damaged frame, and is told.
        """
        for taken in readings:
            gauge = taken.gauge
            reason = gauge.shown.changed(taken.reading.text, visit)
            gauge.odd = gauge.odd + 1 if reason else 0
            if gauge.odd > 1 and gauge.dialect.key == KEYBOARD.key:
                remedy = f"{_TYPE_ALL}; where the one before was short, begin again"
                question = f"{_TYPE_ALL}; where the one before was short, v strikes it"
                raise HaltError(gauge.axis, reason, remedy=remedy, question=question)
            if gauge.odd > 1:
                raise HaltError(
                    gauge.axis,
                    f"unit or resolution of the display have changed: {reason}",
                    remedy="set unit, resolution and zero as they were",
                )
            if reason:
                self.problem(gauge, "changed", f"{reason}: asked again")
        return any(taken.gauge.odd for taken in readings)

    def take_damaged(self) -> list[str]:
        """Return the axes whose line could not be read, or was a fault, since the last call."""
        axes = sorted(self._unreadable)
        self._unreadable.clear()
        return axes

    def refuse(self, readings: Iterable[Taken], reason: str) -> None:
        """Write down and say that these readings are not taken."""
        for taken in readings:
            axis, text = taken.gauge.axis, taken.reading.text
            if self._opening or (taken.stale and not taken.gauge.shown):
                why = "the recording was not ready: press again" if self._opening else reason
                self.notice(taken.gauge, f"{text} not taken: {why}")
                continue
            self._journal.append("refused", axis=axis, text=text, reason=reason)
            self._tell(Refused(axis, text, reason))

    def problem(self, gauge: Gauge, kind: ProblemKind, message: str) -> None:
        """Write down and say that there is no reading."""
        if self._opening:
            self.notice(gauge, message)
            return
        self.last_problem = f"{gauge.axis}: {message}"
        self._journal.append(kind, axis=gauge.axis, message=message)
        self._tell(Problem(kind, gauge.axis, message))

    def notice(self, gauge: Gauge, message: str) -> None:
        """Write down and say what is not a problem."""
        self._journal.append("notice", axis=gauge.axis, message=message)
        self._tell(Noticed(gauge.axis, message))

    def _owing(self) -> list[Gauge]:
        return [gauge for gauge in self.gauges if gauge.outstanding]

    def _ask(self) -> list[Taken] | None:
        """Ask every gauge once, when none owes an answer; two that differ are none."""
        self.drain(0.0, LATE)
        self.refuse(self.receive(), UNASKED)
        for gauge in self._owing():
            self.problem(gauge, "timeout", "has not answered yet, and its line is not quiet")
            return None
        self._faulted = ambiguous = False
        self._unreadable.clear()
        asked = self._clock.now()
        deadline = max(gauge.ask(self._journal, self._clock) for gauge in self.gauges)
        taken: dict[str, Taken] = {}
        while self._clock.now() < self._listening(taken, asked, deadline):
            for one in self.receive():
                first = taken.setdefault(one.gauge.axis, one) if _answers(one) else one
                if first is not one or not _answers(one):
                    self.refuse([one], _why(one))
                    ambiguous |= _answers(one) and first.reading.text != one.reading.text
            if self._faulted:
                self.refuse(taken.values(), "a gauge of the same cycle is at fault")
                return None
            self._clock.idle(self._listening(taken, asked, deadline))
        return self._judge(taken, asked, ambiguous=ambiguous)

    def _listening(self, taken: Mapping[str, Taken], asked: float, deadline: float) -> float:
        """Return until when answers, or second ones, are awaited [s]."""
        if len(taken) < len(self.gauges) or any(gauge.doubtful for gauge in self.gauges):
            return deadline
        answers = [t for t in taken.values() if t.gauge.dialect.asks and not t.gauge.tells_unit]
        times = [max(t.gauge.slowest, t.time - asked) for t in answers]
        return min(deadline, asked + LATER * max(times) + LINGER_S) if times else -math.inf

    def _judge(
        self, taken: Mapping[str, Taken], asked: float, *, ambiguous: bool
    ) -> list[Taken] | None:
        damaged = [g for g in self.gauges if g.dialect.asks and g.axis in self._unreadable]
        for gauge in damaged:
            gauge.outstanding = 0
        silent = [gauge for gauge in self.gauges if gauge.axis not in taken]
        for gauge in silent:
            misread = gauge.misread() if gauge.axis in self._unreadable else None
            what = misread.what if misread else f"no answer in {gauge.dialect.answer_time_s:g} s"
            self.problem(gauge, "timeout", what)
        if silent or damaged or ambiguous:
            why = "another gauge is silent" if silent else _OTHERWISE
            self.refuse(taken.values(), why)
            return None
        for one in taken.values():
            one.gauge.slowest = max(one.gauge.slowest, one.time - asked)
            one.gauge.doubtful = False
        return [taken[gauge.axis] for gauge in self.gauges]


def _answers(one: Taken) -> bool:
    """Say whether the reading began after the request, and is of the channel asked for."""
    return not one.stale and not one.gauge.of_other_channel(one.reading)


def _why(one: Taken) -> str:
    if one.stale:
        return "begun before the request"
    if _answers(one):
        return SECOND
    return f"of channel {one.reading.channel}: give ?channel="


def refuse_other_gauges(job: Job, history: History, ports: Sequence[Port]) -> None:
    """Raise `UsageError` where a job goes on with other gauges, or poses, than were recorded."""
    recorded = {axis: gauge["dialect"] for axis, gauge in history.header["gauges"].items()}
    given = {gauge.axis: gauge.dialect.key for gauge in job.gauges}
    if recorded != given:
        before, now = (
            ", ".join(f"{axis}={key}" for axis, key in gauges.items())
            for gauges in (recorded, given)
        )
        raise UsageError(
            f"recorded with {before}, and now {now}",
            where=history.source,
            remedy="give the same `gauge=` options, or none",
        )
    poses, named = (",".join(tour.poses) for tour in (history.tour, job.plan.tour))
    if poses != named:
        raise UsageError(
            f"recorded at {poses or 'one pose without a name'}, and now at {named or 'one'}",
            where=history.source,
            remedy=f"give `pose={poses}`" if poses else "leave `pose=` out",
        )
    _refuse_exchanged(job, history, ports)


def _refuse_exchanged(job: Job, history: History, ports: Sequence[Port]) -> None:
    """Raise where the gauge of an axis was another axis' before.

    A device may get another name, and a cable another socket: the first sign decides that was not
    both this axis' and another's.
    """
    known = history.header["gauges"].items()
    before = {a: [*map(_signs, gauge["identity"].split(THEN))] for a, gauge in known}
    for spec, port in zip(job.gauges, ports, strict=True):
        for sign in _signs(port.identity):
            owners = [axis for axis, signs in before.items() if sign in chain(*signs)]
            if owners == [spec.axis]:
                break
            if owners and spec.axis not in owners:
                raise UsageError(
                    f"{spec.axis} is given the gauge that {owners[0]} had: {port.identity}",
                    where=history.source,
                    remedy="connect them as before, and give the same `gauge=` options, or none",
                )


def _signs(identity: str) -> list[str]:
    """Return what a gauge is known by: serial number and socket of its cable, and the port."""
    return [*_OF_USB.findall(identity), identity]
