"""The robot says when: a line each way on a socket or a serial line of its own.

    robot: AT P3 cycle=5 T1=31.2   arrived at P3 and at rest; the numbers are columns of the visit
    robot: HELLO program=3f2a91c0 poses=5 cycles=31    optional, first; checked against the plan
    robot: END                         the program is over
    tool:  OK 5                        every axis of this visit of cycle 5 is on the disk
    tool:  NO reason                   nothing was stored

Behind a HELLO that was refused no visit of its connection is taken, until one is right; behind a
pause that an alarm made, HELLO goes on: a person has started the program again. A line that names
another pose than the one awaited is not taken, and neither is one that came while a reading was
being taken: the arm had left since. A visit with ``cycle=`` that is on the disk already is answered
``OK`` and not read again, so a lost answer neither costs nor doubles a visit. What arrives is text
of a stranger: bounded, never a path, never markup.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType
from typing import NamedTuple

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.base.quantities import parse_number
from scara_iso.recorder import events
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.plan import Job, RobotLine, refuse_unreadable
from scara_iso.recorder.ports.port import Clock, Connection, Port, is_device
from scara_iso.recorder.programs import program_id

LONGEST = 200
"""A longer line is none [characters]."""
MOST_WAITING = 10_000
"""A robot waits for its answers, and a script may say a whole test at once: more is a flood."""
LINGER_S, FAREWELL_S = 10.0, 1.0
"""How long a robot that said HELLO may ask for the last answer again, behind a test that is
complete; and how long one that did not may say END [s]."""
_END = re.compile(rb"[\r\n]+")
_POSE = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")
_PAIR = re.compile(r"([A-Za-z][A-Za-z0-9_]{0,30})=(\S+)")
_COUNT = re.compile(r"[0-9]{1,7}")
_SHOWN = 60
_OWN = ("time_s", "cycle", "pose")
"""Columns that the recorder writes."""
_HELLO = ("program", "poses", "cycles")


class RobotSaid(NamedTuple):
    """A line of the robot: ``AT`` a pose and at rest, ``HELLO`` of its program, or its ``END``."""

    verb: str
    pose: str = ""
    cycle: int | None = None
    stated: Mapping[str, str] = MappingProxyType({})
    """The columns of this visit, or what HELLO states, as written."""


class LineError(ValueError):
    """A line that cannot be taken; its text is the reason that the robot is answered."""


def parse_robot_line(text: str) -> RobotSaid:
    """Return what a robot's line says; `LineError` for one that says nothing known."""
    verb, *words = (text.split() if len(text) <= LONGEST else ()) or ("",)
    match verb.upper():
        case "AT" if words and _POSE.fullmatch(words[0]):
            values = _pairs(words[1:])
            cycle = values.pop("cycle", None)
            for name, value in values.items():
                if parse_number(value) is None:
                    raise LineError(f"{name}={value} is not a number")
            return RobotSaid("AT", words[0], _cycle(cycle), values)
        case "HELLO":
            stated = _pairs(words)
            if unknown := [name for name in stated if name not in _HELLO]:
                raise LineError(f"{unknown[0]}= is unknown: HELLO states {', '.join(_HELLO)}")
            return RobotSaid("HELLO", stated=stated)
        case "END" if not words:
            return RobotSaid("END")
    raise LineError("no line such as AT P3")


def _pairs(words: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for word in words:
        pair = _PAIR.fullmatch(word)
        if pair is None:
            raise LineError(f"{word} is not name=number")
        if pair[1] in found:
            raise LineError(f"{pair[1]} is stated twice")
        found[pair[1]] = pair[2]
    return found


def _cycle(text: str | None) -> int | None:
    if text is not None and not (_COUNT.fullmatch(text) and int(text)):
        raise LineError(f"cycle={text} is not a whole number from 1 on")
    return None if text is None else int(text)


def split_lines(begun: bytes, data: bytes) -> tuple[list[str], bytes]:
    """Return the lines that have ended, and the one begun; of an overlong one only its begin."""
    *lines, begun = _END.split(begun + data)
    texts = (line[: LONGEST + 1].decode("ascii", "backslashreplace").strip() for line in lines)
    return [text for text in texts if text], begun[: LONGEST + 1]


class RobotOperator:
    """An operator that the robot is, next to the one at the keyboard.

    The pose of a recording at one pose is that of the job's head, or the first one named.
    ``names`` are the columns stated before. Recorded and simulated gauges have every line taken in
    its turn.
    """

    def __init__(
        self,
        port: Port,
        operator: events.Operator,
        *,
        job: Job,
        journal: Journal,
        tell: Callable[[events.Said], None],
        names: Iterable[str] = (),
    ) -> None:
        self._port = port
        self._operator = operator
        self._journal = journal
        self._tell = tell
        self._job = job
        self._plan = job.plan
        self._tour = job.plan.tour
        self._pose = job.metadata.get("pose")
        self._program = job.program or program_id(self._tour.poses, self._plan.cycles)
        self._recorded = job.recorded
        self._in_order = not any(is_device(gauge.address) for gauge in job.gauges)
        self._begun = b""
        trigger = job.plan.trigger
        self._waiting = trigger.heard if isinstance(trigger, RobotLine) else deque[str]()
        self._awaited = 1
        self._names = dict.fromkeys(names)
        self._taking = self._unplaced = False
        self._pause = events.Paused(on=False)
        self._linger = FAREWELL_S
        self._elsewhere = 0
        """Cycles of the program that the robot runs, where that is recorded already."""
        self._problem = self._stranger = ""  # the latter: why this robot's HELLO was refused
        self._lost: InstrumentError | None = None

    def poll(self) -> events.Command | None:
        """Return the operator's command, or what a line of the robot asks for."""
        came = self._receive() or []
        self._waiting += self._without_late(came) if self._taking else came
        command = self._operator.poll()
        if isinstance(command, events.Take):
            if self._unplaced:
                self._notice(f"the arm stands at {self._name_of_awaited()}, as the operator says")
            self._unplaced = False
        elif command is not None:
            return command
        while self._waiting:
            if asked := self._accept(self._waiting.popleft()):
                self._taking = isinstance(asked, events.Take)
                return asked
        if self._lost is not None:
            raise self._lost
        return events.Quit() if self._port.ended and not self._taking else None

    def told(self, said: events.Said) -> None:
        """Answer the robot when its visit is on the disk or is not, and hand on to the listener."""
        match said:
            case events.CycleDone(cycle=cycle, pose=pose):
                self._awaited = self._tour.visit(cycle, pose) + 1
                self._answer_visit(f"OK {cycle}")
            case events.Waiting(cycle=cycle, pose=pose):
                self._awaited = self._tour.visit(cycle, pose)
                self._answer_visit(f"NO {self._problem or 'no reading'}")
            case events.Problem(message=message):
                self._problem = message
            case events.Paused(on=on):
                self._pause = said
                if on:
                    self._answer_visit(f"NO {self._problem or self._why_paused()}")
        self._tell(said)

    def finish(self, clock: Clock) -> None:
        """Answer behind a complete test: the last answer may be lost, and asked for again."""
        end = clock.now()
        while clock.now() < end + self._linger and self._is_full and not self._port.ended:
            self._waiting += self._receive() or ()
            while self._waiting:
                if self._is_of_the_next(self._waiting[0]):
                    return  # of which the next recording hears
                self._accept(self._waiting.popleft())
            if self._lost is not None:
                return
            clock.idle(math.inf)

    def _is_of_the_next(self, line: str) -> bool:
        """Return whether a line is of another recording.

        That is the HELLO of what is neither recorded nor just was; where none is said, all but END.
        """
        with suppress(LineError):
            said = parse_robot_line(line)
            if self._linger < LINGER_S:
                return said.verb != "END"
            known = {self._program, *self._recorded}
            return said.verb == "HELLO" and said.stated.get("program", self._program) not in known
        return False

    def _why_paused(self) -> str:
        return ": ".join(filter(None, ("paused", self._pause.reason)))

    def leave(self) -> None:
        """Tell a robot that waits for an answer that none comes any more."""
        if self._taking:
            with suppress(InstrumentError):
                self._port.write(b"NO the recording has ended\r\n")

    @property
    def _is_full(self) -> bool:
        return self._awaited > self._plan.visits

    def _answer_visit(self, text: str) -> None:
        """Answer the robot that waits; what it said meanwhile came too soon.

        One that left meanwhile asks again: it would take this answer for that of its next line.
        """
        if not self._taking:
            return
        late = [*self._waiting]
        for _ in range(MOST_WAITING):
            if (came := self._receive()) is None:
                break
            late += came
        self._waiting.clear()
        if self._taking:
            self._answer(text)
        self._taking, self._problem = False, ""
        self._waiting += self._without_late(late)

    def _answer(self, text: str) -> None:
        sent = text.encode("ascii", "replace")[:LONGEST]
        with suppress(InstrumentError):  # a robot that left needs none; reading will say so
            self._port.write(sent + b"\r\n")
        self._journal.append("answer", text=sent.decode("ascii"))

    def _receive(self) -> list[str] | None:
        """Return the lines that have come, None where nothing has."""
        try:
            data = b"" if self._lost else self._port.read()
        except InstrumentError as error:  # what was said before still counts
            self._lost = error
            return None
        for change in self._port.changes():
            self._take_change(change)
        if not data:
            return None
        self._journal.append("robot", port=self._port.address, hex=data.hex())
        came, self._begun = split_lines(self._begun, data)
        if len(self._waiting) + len(came) > MOST_WAITING:
            self._refuse(came[0], f"more than {MOST_WAITING} lines, and no answer waited for")
            return []
        return came

    def _take_change(self, change: Connection) -> None:
        """Say who came, went or was refused; a line that was begun is not gone on with."""
        said = " ".join(filter(None, (f"robot {change.peer} {change.state}", change.why)))
        self._journal.append("connection", state=change.state, peer=change.peer, why=change.why)
        self._notice(said)
        if change.state == "lost":
            self._begun, self._stranger = b"", ""
            self._unplaced, self._taking = True, False

    def _name_of_awaited(self) -> str:
        return self._tour.name(min(self._awaited, self._plan.visits))

    def _accept(self, line: str) -> events.Command | None:
        """Return what a line asks of the session, and answer it where that is nothing."""
        try:
            said = parse_robot_line(line)
            if said.verb == "AT":
                if self._stranger:
                    raise LineError(self._stranger)
                return events.Take() if self._is_awaited(said) else None
            if said.verb == "HELLO":
                return self._greet(said.stated)
            self._end()
        except LineError as error:
            self._refuse(line, str(error))
        return None

    def _without_late(self, came: list[str]) -> list[str]:
        """Answer lines that came during a reading; return those that are taken in their turn."""
        if self._in_order:
            return came
        for line in came:
            with suppress(LineError):
                said = parse_robot_line(line)
                if said.verb == "AT" and self._is_stored(said):
                    self._answer(f"OK {said.cycle}")
                    continue
            self._refuse(line, "came while a reading was being taken")
        return []

    def _is_stored(self, at: RobotSaid) -> bool:
        if at.cycle is None:
            return False
        if self._elsewhere:
            return at.cycle <= self._elsewhere
        if at.cycle > self._plan.cycles:
            raise LineError(f"{self._plan.cycles} cycles are recorded")
        return self._tour.visit(at.cycle, self._pose_of(at)) < self._awaited

    def _pose_of(self, at: RobotSaid) -> str | None:
        """Return the pose of the tour that a line names, None for the only one."""
        if not self._tour.poses:
            self._pose = self._pose or at.pose.upper()
            if at.pose.upper() != self._pose.upper():
                raise LineError(f"{self._pose} is awaited")
            return None
        named = {pose.upper(): pose for pose in self._tour.poses}
        if at.pose.upper() not in named:
            raise LineError(f"{self._tour.place(self._awaited)[1]} is awaited")
        return named[at.pose.upper()]

    def _is_awaited(self, at: RobotSaid) -> bool:
        """Return whether a reading is to be taken now; raise `LineError` with what is wrong."""
        if self._is_stored(at):
            self._answer(f"OK {at.cycle}")
            return False
        pose, awaited = self._pose_of(at), self._tour.place(self._awaited)
        if self._elsewhere or self._is_full:
            raise LineError("all of it is recorded")
        if at.cycle is None and self._unplaced:
            raise LineError("reconnected: state cycle=, or the operator confirms the place (Enter)")
        if at.cycle is None and pose != awaited[1]:
            raise LineError(f"{awaited[1]} is awaited")
        if at.cycle is not None and (at.cycle, pose) != awaited:
            raise LineError(f"{self._name_of_awaited()} is awaited")
        if self._pause.on:
            raise LineError(self._why_paused())
        self._unplaced = False
        self._take_values(at.stated)
        return True

    def _take_values(self, values: Mapping[str, str]) -> None:
        """Put the numbers of a visit into the raw file; raise `LineError` for no column's name."""
        new = [name for name in values if name not in self._names]
        taken = {name.upper() for name in (*_OWN, *self._names)}
        for k, name in enumerate(new, 1):
            if name.upper() in taken or not self._is_readable([*self._names, *new[:k]]):
                raise LineError(f"{name} cannot be the name of a column")
        self._names |= dict.fromkeys(new)
        if new and self._awaited > 1:
            self._notice(f"{', '.join(new)}: not stated before {self._name_of_awaited()}")
        if self._names:
            stated = self._tour.state(self._awaited)
            self._journal.append("covariates", **stated, values=dict(values))

    def _is_readable(self, columns: Iterable[str]) -> bool:
        try:
            refuse_unreadable(self._job, columns)
        except UsageError:
            return False
        return True

    def _greet(self, stated: Mapping[str, str]) -> events.Command | None:
        """Compare a program with the plan, and answer how many cycles are on the disk.

        A pause that an alarm made is over: a person has started the program again.
        """
        program = stated.get("program", self._program)
        self._stranger = ""
        self._elsewhere = self._recorded.get(program, 0) if program != self._program else 0
        self._linger = max(self._linger, FAREWELL_S)
        if self._elsewhere:
            self._answer(f"OK {self._elsewhere}")
            return None
        planned = (self._program, str(len(self._tour)), str(self._plan.cycles))
        wanted = dict(zip(_HELLO, planned, strict=True))
        for name, text in {**stated, "program": program}.items():
            if text.lower() != wanted[name]:
                raise LineError(f"{name}={text}, and {wanted[name]} is to be recorded")
        self._linger = LINGER_S
        self._answer(f"OK {(self._awaited - 1) // len(self._tour)}")
        return events.Pause() if self._pause.on and self._pause.reason is not None else None

    def _end(self) -> None:
        self._linger = self._linger if self._elsewhere else 0.0
        if self._elsewhere or self._is_full:
            self._answer(f"OK {self._elsewhere or self._plan.cycles}")
            self._elsewhere = 0
            return
        left = self._plan.visits - self._awaited + 1
        missing = f"{left} visits are missing, from {self._name_of_awaited()} on"
        self._notice(f"the robot's program is over, and {missing}")
        self._answer(f"NO {missing}")

    def _notice(self, message: str) -> None:
        self._journal.append("notice", axis="", message=message)
        self._journal.sync()
        self._tell(events.Noticed("", message))

    def _refuse(self, line: str, reason: str) -> None:
        if line[:5].upper() == "HELLO":
            self._stranger = reason
        self._notice(f"the robot says {line[:_SHOWN]!r}, not taken: {reason}")
        self._answer(f"NO {reason}")
