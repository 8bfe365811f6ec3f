"""What the recorder's tests share: a scripted instrument, a session run to its end."""

from __future__ import annotations

import math
from pathlib import Path

from disks import UnsyncedDisk

from scara_iso.base.errors import InstrumentError
from scara_iso.iso9283 import past_due
from scara_iso.rawfile import Tour, raw_path, read_history
from scara_iso.recorder import (
    Job,
    RecordingPlan,
    Stored,
    parse_gauges,
    parse_trigger,
    record,
    recording as recording_module,
)
from scara_iso.recorder.ports.port import Port, StreamClock


class Script(Port):
    """A port whose k-th request is answered by ``answer(k)``: pairs of delay [s] and bytes.

    The first of the pairs is its own answer: which unit it shows is said behind it.
    """

    def __init__(
        self,
        clock,
        *,
        answer=lambda k: [],
        pushes=(),
        lost_at=math.inf,
        settle_s=0.0,
        shows=b"MM\r",
    ):
        self.address = self.identity = "script"
        self.settle_s = settle_s
        self._clock = clock
        self._answer = answer
        self._waiting = sorted(pushes)
        self._lost_at = lost_at
        self._shows = shows
        self.requests = []
        self._busy = 0.0
        clock.watch(lambda: self._waiting[0][0] if self._waiting else math.inf)

    @property
    def ended(self):
        return not self._waiting and self._answer(len(self.requests)) is None

    def read(self):
        if self._clock.now() >= self._lost_at:
            raise InstrumentError("the port is lost", where="script")
        if self._waiting and self._waiting[0][0] <= self._clock.now():
            return self._waiting.pop(0)[1]
        return b""

    def write(self, data):
        if data == b"UNI?\r" and self._shows is not None:
            self._waiting.insert(0, (max(self._clock.now(), self._busy), self._shows))
            self._waiting.sort()
            return
        answers = self._answer(len(self.requests)) or []
        self.requests.append(data)
        self._busy = self._clock.now() + (answers[0][0] if answers else 0.0)
        self._waiting += [(self._clock.now() + delay, frame) for delay, frame in answers]
        self._waiting.sort()

    def pulse(self, pulse):
        self.write(b"(pulse)")


class Orders:
    """An operator who gives the n-th command in the n-th round that asks for one."""

    def __init__(self, *commands):
        self._commands = list(commands)

    def poll(self):
        return self._commands.pop(0) if self._commands else None


def run_session(
    folder: Path,
    gauges: dict[str, str] | list[str],
    *,
    ports=None,
    trigger="timer:1",
    cycles=3,
    stable=1,
    rearm_s=None,
    operator=None,
    disk=None,
    resume=False,
    monkeypatch=None,
    clock=None,
    table="run.csv",
    metadata=None,
    tell=None,
    attended=False,
    poses=(),
):
    """Record; return what was said. ``ports`` (axis to a function of the clock) replaces them."""
    clock = clock or StreamClock(paced=False)
    if rearm_s is None:
        rearm_s = 0.0 if trigger == "enter" else 0.5
    said = []
    if ports is not None:
        made = {axis: make(clock) for axis, make in ports.items()}
        monkeypatch.setattr(
            recording_module, "open_port", lambda *a, axis, **k: made[axis], raising=True
        )
    job = Job(
        folder / table,
        parse_gauges(gauges),
        RecordingPlan(parse_trigger(trigger), cycles, stable, rearm_s, Tour(tuple(poses))),
        metadata or {},
        resume,
    )

    def hear(event):
        said.append(event)
        if tell:
            tell(event)

    run_session.said = said
    record(
        job, disk=disk or UnsyncedDisk(), clock=clock, operator=operator or Orders(), tell=hear,
        attended=attended,
        remarks=past_due,
    )  # fmt: skip
    return said


def stored(said, axis="X"):
    """Return the stored texts of an axis by cycle, in the order they were announced."""
    return [(s.cycle, s.text) for s in said if isinstance(s, Stored) and s.axis == axis]


def kept(folder: Path, axis="X", table="run.csv"):
    """Return the readings by cycle that the raw file holds."""
    return read_history(raw_path(folder / table)).readings().get(axis, {})
