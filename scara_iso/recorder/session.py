"""The session: from bytes on the ports to readings on the disk, visit by visit.

One loop looks at every port and at the operator in turn; nothing waits for one of them, so a
lost cable or a key is met within milliseconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress

from scara_iso.base.errors import InstrumentError
from scara_iso.base.quantities import parse_unit
from scara_iso.rawfile import LATE, UNASKED, History
from scara_iso.recorder import events
from scara_iso.recorder.bench import Bench
from scara_iso.recorder.gauge import Gauge, HaltError, Taken
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.plan import Job, RobotLine, Settled, Timer
from scara_iso.recorder.ports.port import Clock
from scara_iso.recorder.visits import AtRest, Heard, Ledger, Visits

ATTEMPTS = 3
"""How often a gauge is asked for one cycle before the session gives up."""
RETRY_S = 0.2
WATCH_S = 0.1
"""Time between two looks at a dial that is to come to rest."""

STANDS_S = 2.0
"""So long an arm is taken to stand at a pose of a tour that a timer paces [s]."""

_LOST_FRAME = (
    "a frame that is lost shifts the poses of all that follow: see that the pose awaited is where "
    "the arm stands; the robot's line (`trigger=line:PORT`) names the pose and loses none"
)


class Session:
    """Records visits until the plan is full, the operator quits, or a recorded stream ends.

    ``earlier`` is what was recorded before. `run` raises `InstrumentError` where a port is lost, a
    gauge stays silent or a unit changes, `UsageError` where a unit is unknown, and `WriteError`
    where the disk fails. ``tell`` hears of a stored reading only when it is on the disk. Where the
    unit or the zero of a gauge is lost, who sits at the terminal (``attended``) is asked; otherwise
    it is an `InstrumentError`.
    """

    def __init__(
        self,
        gauges: Sequence[Gauge],
        *,
        job: Job,
        journal: Journal,
        clock: Clock,
        operator: events.Operator,
        tell: Callable[[events.Said], None],
        earlier: History,
        attended: bool = False,
    ) -> None:
        self._gauges = {gauge.axis: gauge for gauge in gauges}
        self._attended = attended
        self._bench = Bench(gauges, journal=journal, clock=clock, tell=tell)
        self._plan = job.plan
        self._tour = job.plan.tour
        self._journal = journal
        self._clock = clock
        self._operator = operator
        self._tell = tell
        self._ledger = Ledger(self._gauges, job=job, journal=journal, tell=tell, earlier=earlier)
        self._visits = self._new_visits()
        self._due = 0.0
        self._pressed = -math.inf
        self._paused = self._stopped = False
        trigger = job.plan.trigger
        rule = trigger if isinstance(trigger, Settled) else Settled()
        self._period = trigger.seconds if isinstance(trigger, Timer) else math.inf
        """The timer's [s]; without one no reading comes too late."""
        self._stands = self._period / 2
        if len(self._tour) > 1 and isinstance(trigger, Timer):
            self._stands = min(self._stands, STANDS_S)
        self._at_rest = AtRest(rule, _places(earlier))
        self._unread, self._seen = 0, math.inf

    def run(self) -> None:
        """Record."""
        gauges = {a: f"{g.dialect.key} at {g.port.identity}" for a, g in self._gauges.items()}
        cycle, pose = self._tour.place(self._ledger.visit)
        trigger, poses = str(self._plan.trigger), self._tour.poses or None
        self._tell(events.Started(gauges, cycle, self._plan.cycles, trigger, pose, poses))
        if self._plan.trigger == "data" and len(self._tour) > 1 == len(self._gauges):
            self._tell(events.Noticed("", _LOST_FRAME))
        self._bench.open()
        self._due = self._clock.now()
        self._ledger.say_waiting()
        step = self._listen if self._plan.trigger == "data" else self._attend
        if isinstance(self._plan.trigger, Settled):
            step = self._look
        while not self._stopped and (not self._ledger.is_full or self._strikes_last()):
            try:
                step()
            except HaltError as halt:
                self._ask_what_to_do(halt)

    def _strikes_last(self) -> bool:
        """Say whether who sits there strikes the last reading, where there is a doubt about it.

        A robot or a timer goes on by itself, and is waited for by nobody.
        """
        asks = self._ledger.asks
        if not (asks and self._attended and self._plan.trigger in ("enter", "data")):
            return False
        self._tell(events.Noticed("", f"every cycle is recorded; {asks}, q ends"))
        while self._ledger.is_full and not self._stopped:
            if self._obey(self._operator.poll()):
                return False
            with suppress(InstrumentError):  # all is recorded: a cable may be pulled
                self._bench.refuse(self._bench.receive(), "every cycle is recorded")
            self._clock.idle(math.inf)
        return not self._ledger.is_full

    def _ask_what_to_do(self, halt: HaltError) -> None:
        """Pause until somebody put it right; raise where nobody is there."""
        axis, gauge = halt.axis, self._gauges[halt.axis]
        if gauge.tells_unit and self._ledger.stored_at(axis) > gauge.unit_stated:
            self._ledger.strike_last(axis, f"{halt.what}: asked again")
        self._journal.append(halt.kind, axis=axis, message=halt.what)
        self._journal.sync()
        if not self._attended:
            self._tell(events.Problem(halt.kind, axis, halt.what))
            raise halt
        self._paused = True
        self._tell(events.Paused(True))
        self._tell(
            events.Problem(
                halt.kind, axis, f"{halt.what}; {halt.question}, then p goes on, or q ends"
            )
        )
        for one in self._gauges.values():
            one.odd = 0
        self._visits = self._new_visits()

    def _new_visits(self) -> Visits:
        """Return where a visit stands, without what was heard before."""
        return Visits(
            self._gauges,
            present=self._ledger.present,
            timed=self._plan.rearm_s > 0,
            one_pose=len(self._tour) == 1,
        )

    def _listen(self) -> None:
        arrivals = self._bench.receive()
        for axis in self._bench.take_damaged():
            self._keep_place(self._visits.hear(axis, self._clock.now(), None), axis)
        for taken in arrivals:
            self._take_or_refuse(taken)
        self._obey(self._operator.poll())
        if not arrivals:
            self._stopped |= self._ended()
            if not self._stopped:
                self._clock.idle(math.inf)

    def _take_or_refuse(self, taken: Taken) -> None:
        """Store a reading that came by itself, or say why not."""
        axis, text = taken.gauge.axis, taken.reading.text
        if reason := self._why_not(taken):
            self._bench.refuse([taken], reason)
            return
        heard = self._visits.hear(axis, taken.time, text)
        if heard.refused or (heard.doubt and len(self._tour) > 1):
            self._bench.refuse([taken], heard.refused or heard.doubt)
        self._keep_place(heard, axis)
        if heard.refused:
            return
        if self._bench.doubt([taken], self._ledger.visit):
            self._visits.forget(axis)
        else:
            self._ledger.store([taken])
            if taken.gauge.tells_unit:
                taken.gauge.ask_unit(self._journal, self._clock)

    def _why_not(self, taken: Taken) -> str:
        """Return why a reading that came by itself is refused, or nothing."""
        gauge, axis, channel = taken.gauge, taken.gauge.axis, taken.reading.channel
        elapsed = taken.time - self._ledger.stored_at(axis)
        reasons = {
            "every cycle is recorded": self._ledger.is_full,
            "paused": self._paused,
            "began before the session": taken.stale,
            f"of channel {channel}: give ?channel=": gauge.of_other_channel(taken.reading),
            f"came within {self._plan.rearm_s:g} s of the one before": elapsed < self._plan.rearm_s,
        }
        return next((reason for reason, holds in reasons.items() if holds), "")

    def _keep_place(self, heard: Heard, axis: str) -> None:
        """Strike what is of another visit than a frame of ``axis``.

        In a tour nothing is taken then until somebody has seen where the arm stands: every later
        frame would be given to the wrong pose.
        """
        ledger, why = self._ledger, heard.doubt or heard.refused
        halts = len(self._tour) > 1 and bool(why)
        kept = frozenset[str]() if halts else heard.kept
        reason = f"{why or 'another frame of the visit was damaged'}: asked again"
        whole = heard.back and not ledger.present
        if others := sorted(ledger.present - kept):
            ledger.strike(ledger.visit, others, reason)
        if heard.back:
            again = kept if whole else frozenset()
            ledger.strike(ledger.visit - 1, sorted(set(self._gauges) - again), reason)
        if halts:
            self._lose_place(f"{why}: a frame was lost or sent twice", axis)

    def _attend(self) -> None:
        if not self._await_trigger():
            return
        tick = self._due - self._period
        for attempt in range(ATTEMPTS):
            if attempt:
                self._bench.drain(RETRY_S, LATE)
                self._bench.learn_units([g for g in self._bench.gauges if g.odd or g.doubtful])
            if attempt and self._missed(tick):
                self._lose_place("no reading came while the timer's visit lasted")
                break
            if self._read() or self._stopped:
                return
        if isinstance(self._plan.trigger, Timer) and self._unread >= ATTEMPTS:
            raise self._silent()
        self._ledger.say_waiting()

    def _read(self) -> bool:
        """Ask every gauge once; return whether their readings are stored."""
        taken = self._bench.measure(self._plan.stable)
        doubted = taken is None or self._bench.doubt(taken, self._ledger.visit)
        if taken is not None and not doubted and self._bench.confirm(taken):
            self._pressed, self._unread = self._clock.now(), 0
            self._store_missing(taken)
            return True
        self._unread += 1
        self._stopped |= self._ended()
        return False

    def _missed(self, tick: float) -> bool:
        """Say whether a reading taken now may be of another visit than that of a timer's tick."""
        return self._clock.now() > tick + self._stands

    def _lose_place(self, why: str, axis: str = "") -> None:
        """Halt in a tour: a visit that nobody saw gives every later reading to another pose."""
        if len(self._tour) > 1:
            visit = self._tour.name(self._ledger.visit)
            raise HaltError(
                axis or self._ledger.missing[0],
                f"{why}, and where the arm stands is not known",
                remedy=f"bring the arm to {visit} and continue with `resume=True`; a robot that "
                "says where it is (`trigger=line:PORT`) loses no place",
                kind="place",
                question=f"bring the arm to {visit}",
            )

    def _look(self) -> None:
        """Look at every gauge again and again, and take the readings of a dial at rest."""
        if not self._paused:
            taken = self._bench.measure(1)
            if taken:
                if self._unread and self._clock.now() > self._seen + self._at_rest.rule.rest:
                    self._seen = math.inf
                    self._lose_place("no reading came while a visit may have passed")
                self._seen = self._clock.now()
            self._unread = 0 if taken else self._unread + 1
            if self._unread >= ATTEMPTS:
                raise self._silent()
            self._take_at_rest(taken or ())
        until = self._clock.now() + WATCH_S
        while self._clock.now() < until and not self._stopped:
            self._bench.refuse(self._bench.receive(), UNASKED)
            self._obey(self._operator.poll())
            self._stopped |= self._ended()
            self._clock.idle(until)

    def _take_at_rest(self, taken: Sequence[Taken]) -> None:
        visit, values, divisions = self._ledger.visit, dict[str, float](), dict[str, float]()
        for one in taken:
            unit = parse_unit(one.reading.unit or one.gauge.unit or "mm")
            values[one.gauge.axis] = unit.read(one.reading.text)
            divisions[one.gauge.axis] = unit.to_base(float(one.reading.resolution))
        pose = self._tour.place(visit)[1]
        if not taken or not self._at_rest.arrived(taken[0].time, values, divisions, pose):
            return
        if not self._bench.doubt(taken, visit) and self._bench.confirm(taken):
            self._store_missing(taken)
            self._at_rest.stored(values, pose)

    def _store_missing(self, taken: Sequence[Taken]) -> None:
        missing = self._ledger.missing
        self._ledger.store([one for one in taken if one.gauge.axis in missing])

    def _silent(self) -> InstrumentError:
        what = f"no reading of {self._tour.name(self._ledger.visit)} after {ATTEMPTS} requests"
        for misread in filter(None, (gauge.misread() for gauge in self._bench.gauges)):
            misread.what = f"{what}; {misread.what}"
            return misread
        return InstrumentError(
            f"{what}; at last {self._bench.last_problem}",
            remedy="check cable, settings and that the indicator is on",
        )

    def _await_trigger(self) -> bool:
        """Return True when the cycle is to be taken, False when the session ends instead."""
        timed = isinstance(self._plan.trigger, Timer)
        while True:
            self._skip_missed()
            due = self._due if timed and not self._paused else math.inf
            arrivals = self._bench.receive()
            self._bench.refuse(arrivals, UNASKED)
            taken = self._obey(self._operator.poll())
            self._stopped |= self._ended()
            if self._stopped:
                return False
            if not self._paused and (taken or self._clock.now() >= due):
                self._due += self._period
                return True
            if not arrivals:
                self._clock.idle(due)

    def _skip_missed(self) -> None:
        """Keep to the timer's grid: a visit that has passed is not caught up."""
        if not self._paused and self._missed(self._due):
            late = self._clock.now() - self._due - self._stands
            self._due += math.ceil(late / self._period) * self._period
            self._lose_place("a reading took longer than the timer's visit")

    def _ended(self) -> bool:
        return any(self._gauges[axis].port.ended for axis in self._ledger.missing)

    def _obey(self, command: events.Command | None) -> bool:
        """Do as the operator says; return True where a reading is to be taken."""
        match command:
            case events.Take() if self._plan.trigger == "enter":
                return not self._bounced()
            case events.Take() if isinstance(self._plan.trigger, RobotLine):
                return True
            case events.Void(reason=reason) if self._ledger.can_void:
                self._ledger.void(reason, together=self._plan.trigger != "data")
                self._visits = self._new_visits()
            case events.Note(text=text):
                self._journal.append("note", text=text)
                self._journal.sync()
                self._tell(events.Noted(text))
            case events.Pause(reason=reason):
                self._paused = not self._paused
                self._due, self._unread = self._clock.now(), 0
                said = {} if reason is None else {"reason": reason}
                self._journal.append("paused" if self._paused else "continued", **said)
                self._tell(events.Paused(self._paused, reason))
            case events.Quit():
                self._stopped = True
        return False

    def _bounced(self) -> bool:
        """Say whether a key was held down, or pressed again before the reading was seen."""
        since, self._pressed = self._clock.now() - self._pressed, self._clock.now()
        rearm = self._plan.rearm_s
        if since < rearm:
            self._tell(events.Noticed("", f"Enter not taken: within {rearm:g} s of the one before"))
        return since < rearm


def _places(earlier: History) -> dict[str | None, dict[str, float]]:
    """Return the latest readings at each pose, by axis [mm or deg]; the last visit is the last."""
    readings = earlier.readings()
    found: dict[str | None, dict[str, float]] = {}
    for visit in sorted(earlier.times):
        if here := {axis: r[visit] for axis, r in readings.items() if visit in r}:
            pose = earlier.tour.place(visit)[1]
            found[pose] = found.pop(pose, {}) | here
    return found
