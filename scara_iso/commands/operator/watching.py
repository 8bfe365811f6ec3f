"""The watch over a recording: it hears what a session says, and adds what the readings say.

Nothing of the recording depends on it: no reading, no file, no answer on a line.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from itertools import product
from typing import Any, TypeAlias

from scara_iso import diagnosis, recorder
from scara_iso.base.quantities import Dimension, parse_unit, within_half_a_turn
from scara_iso.diagnosis import Watched
from scara_iso.rawfile import History

Announced: TypeAlias = recorder.Said | Watched
"""What a listener hears: the session, and the watch over it."""
_Channel: TypeAlias = tuple[str | None, str]
"""Pose and axis."""


class Watcher:
    """A listener that hands on what it hears, and says after each cycle what is known then.

    As the operator, next to the one there is, it pauses at its first alarm.

    Ties on the dial are broken by a seed that is a hash of the recording's own head (axes, poses,
    planned cycles, metadata), so that the same readings always say the same.
    """

    def __init__(
        self,
        job: recorder.Job,
        earlier: History | None,
        tell: Callable[[Announced], None],
        operator: recorder.Operator | None = None,
    ) -> None:
        """``earlier`` is what a recording that is resumed holds."""
        self._tell = tell
        self._operator = operator or recorder.Unattended()
        self._pause: recorder.Pause | None = None
        self._head = _head(job, earlier)
        poses = self._head["poses"] or [None]
        self._channels: list[_Channel] = list(product(poses, self._head["axes"]))
        self._values: dict[int, dict[_Channel, float]] = {}
        self._first: dict[_Channel, float] = {}
        self._stood: set[int] = set()
        """How many cycles were complete before each pause."""
        self._monitor: diagnosis.Monitor | None = None
        self._due = self._failed = self._alarmed = False
        if earlier is not None:
            self._remember(earlier)

    def poll(self) -> recorder.Command | None:
        """Return the pause that is due, else the operator's command."""
        pause, self._pause = self._pause, None
        return pause or self._operator.poll()

    def hear(self, said: Announced) -> None:
        """Hear what is said; a cycle is judged once everything about it is said and answered."""
        if isinstance(said, recorder.Done):
            self._judge(said)
        self._tell(said)
        if isinstance(said, recorder.Stored):
            angle = parse_unit(said.unit).dimension is Dimension.ANGLE
            self._put(said.cycle, (said.pose, said.axis), said.value, angle=angle)
        elif not isinstance(said, recorder.CycleDone | recorder.Done):
            self._judge(said)
        self._due |= isinstance(said, recorder.CycleDone)
        if said == recorder.Paused(on=False) and self._monitor is not None:
            self._stood.add(self._monitor.cycles)

    def _put(self, cycle: int, channel: _Channel, value: float, *, angle: bool) -> None:
        first = self._first.setdefault(channel, value)
        near = first + within_half_a_turn(value - first) if angle else value
        self._values.setdefault(cycle, {})[channel] = near

    def _remember(self, earlier: History) -> None:
        self._stood.update(earlier.pauses)
        for axis, readings in earlier.readings().items():
            angle = earlier.columns[axis].dimension is Dimension.ANGLE
            for visit, value in readings.items():
                cycle, pose = earlier.tour.place(visit)
                self._put(cycle, (pose, axis), value, angle=angle)

    def _judge(self, said: Announced) -> None:
        """Take the cycles that are complete, and say what is known; never end a recording."""
        if self._failed or not (self._due or isinstance(said, recorder.Started | recorder.Voided)):
            return
        self._due = False
        try:
            found = self._judged(said)
        except Exception as error:  # noqa: BLE001 - the recording goes on, whatever it is
            self._failed = True
            self._tell(recorder.Noticed("", f"the watch has ended: {error}"))
            return
        if found is not None:
            self._tell(found)
            alarm = found.says == "structure"
            if alarm and not self._alarmed:
                self._pause = recorder.Pause(f"{found.effect} since cycle {found.since}")
            self._alarmed = alarm

    def _judged(self, said: Announced) -> Watched | None:
        """Return what is known where other cycles are complete than before."""
        monitor = self._monitor or self._begun()
        before = monitor.cycles
        if isinstance(said, recorder.Voided):
            self._strike(said, monitor)
        while len(self._values.get(monitor.cycles + 1, {})) == len(self._channels):
            if monitor.cycles in self._stood:
                monitor.pause()
            values = self._values[monitor.cycles + 1]
            monitor.take([values[channel] for channel in self._channels])
        if monitor.cycles in (0, before):
            return None
        known = monitor.watched()
        return None if isinstance(said, recorder.Started) and known.says == "nothing yet" else known

    def _begun(self) -> diagnosis.Monitor:
        digest = hashlib.sha256(json.dumps(self._head, sort_keys=True).encode("ascii")).digest()
        of_drift = self._head["metadata"].get("test", "").strip().lower() == "drift"
        planned = None if of_drift else self._head["cycles"]  # the length of a drift test is open
        self._monitor = diagnosis.Monitor(planned=planned, seed=int.from_bytes(digest[:8], "big"))
        return self._monitor

    def _strike(self, said: recorder.Voided, monitor: diagnosis.Monitor) -> None:
        for axis in said.axes:
            self._values.get(said.cycle, {}).pop((said.pose, axis), None)
        self._stood = {min(before, said.cycle - 1) for before in self._stood}
        if said.cycle <= monitor.cycles:
            monitor.strike(said.cycle)


def _head(job: recorder.Job, earlier: History | None) -> dict[str, Any]:
    """Return axes, poses, planned cycles and metadata, as the recording began."""
    begun = (earlier.first_header if earlier else None) or {
        "gauges": [gauge.axis for gauge in job.gauges],
        "poses": job.plan.tour.poses,
        "cycles": job.plan.cycles,
        "metadata": job.metadata,
    }
    return {
        "axes": sorted(begun["gauges"]),
        "poses": list(map(str, begun.get("poses", ()))),
        "cycles": int(begun["cycles"]),
        "metadata": {key: str(text) for key, text in begun["metadata"].items()},
    }
