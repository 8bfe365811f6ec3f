"""What a session says, as JSON lines or on the live screen."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from shlex import quote
from typing import Any

import numpy as np

from scara_iso import iso9283, recorder, reporting
from scara_iso.base.errors import DataError, WriteError
from scara_iso.base.published import to_json, to_text
from scara_iso.base.quantities import unwrap
from scara_iso.commands.operator.keyboard import KEYS, Keys
from scara_iso.commands.operator.recording import Prepared
from scara_iso.commands.operator.watching import Announced
from scara_iso.commands.shared.output import settings
from scara_iso.diagnosis import Watched
from scara_iso.rawfile import ShownReading, Tour
from scara_iso.render import AxisView, LiveScreen, LiveView, open_console

REDRAW_S = 0.1
_BETWEEN_BELLS_S = 0.25
_FEWEST_FOR_RP = 5
"""From so many readings on `analyze` gives RP an interval: fewer say next to nothing of it."""
_ANGLES = ("deg", "rad", "arcmin", "arcsec")
_BELLS: Mapping[type, int] = {
    **dict.fromkeys((recorder.Stored, recorder.CycleDone), 1),
    **dict.fromkeys((recorder.Refused, recorder.Problem, recorder.Gross), 2),
}
_TYPED = "bring the arm to the pose, let it settle, type the reading, press Enter"
_NEXT = {
    "enter": "bring the arm to the pose, let it settle, press Enter",
    "data": "bring the arm to the pose, let it settle, press DATA on the indicator",
}


def write_line(said: Announced) -> None:
    """Write what was said as one JSON line; `WriteError` where nobody reads it any more."""
    try:
        sys.stdout.write(f"{to_text(to_json(said))}\n")
        sys.stdout.flush()
    except OSError as error:
        sys.stdout = None
        raise WriteError(
            f"standard output failed ({error.strerror})", remedy="continue with --resume"
        ) from error


class Screen:
    """Folds what is said into a view, and draws it at most every `REDRAW_S`.

    It is the session's operator too, so that it is called in every round of its loop.
    """

    def __init__(
        self,
        live: LiveScreen,
        operator: recorder.Operator,
        *,
        title: str,
        earlier: Mapping[str, Mapping[int, ShownReading]],
        place: Callable[[int, float | None], str] | None = None,
        following: str | None = None,
        quiet: bool = False,
    ) -> None:
        """``place`` says where a test is, from cycles stored and pace; ``following`` what comes.

        One bell says that a visit is stored, two that something was not taken, unless ``quiet``.
        """
        self._live = live
        self._operator = operator
        self._title = title
        self._place = place
        self._following = following
        self._trigger = ""
        self._tour = Tour()
        self._cycles = 0
        self._visit = 1
        self._waiting: tuple[str, ...] = ()
        self._stored = 0
        self._begun = (0, 0.0)
        self._readings = {axis: dict(readings) for axis, readings in earlier.items()}
        self._status = ("", "plain")
        self._troubles: Counter[str] = Counter()
        self._paused = False
        self._last = ""
        self._drawn = 0.0
        self._stale = True
        self._quiet = quiet
        self._bells: list[float] = []
        self._warning: tuple[str, ...] = ()

    def __enter__(self) -> Screen:
        self._live.__enter__()
        return self

    def __exit__(self, *raised: Any) -> None:
        if self._cycles:
            self._live.show(self._view(over=True))
        self._live.__exit__(*raised)

    def poll(self) -> recorder.Command | None:
        """Redraw if it is time to, and return the operator's command."""
        command = self._operator.poll()
        self._stale |= isinstance(self._operator, Keys) and bool(self._operator.prompt())
        self._redraw()
        if self._bells and time.monotonic() >= self._bells[0]:
            self._bells.pop(0)
            self._live.ring()
        return command

    def _redraw(self) -> None:
        if self._stale and time.monotonic() - self._drawn > REDRAW_S:
            self._live.show(self._view())
            self._drawn, self._stale = time.monotonic(), False

    def tell(self, said: Announced) -> None:
        """Take what the session says."""
        self._take(said)
        if isinstance(said, Watched):
            self._warn(said)
        self._ring(_BELLS.get(type(said), 0))
        self._stale = True
        self._redraw()

    def _ring(self, times: int) -> None:
        if times and not self._quiet:
            self._bells = [time.monotonic() + k * _BETWEEN_BELLS_S for k in range(times)]

    def _take(self, said: Announced) -> None:  # noqa: C901 - one case for each thing said
        match said:
            case recorder.Started():
                self._trigger, self._cycles = said.trigger, said.cycles
                self._tour = Tour(said.poses or ())
                self._visit = self._tour.visit(said.cycle, said.pose)
                self._stored = self._visit - 1
                self._begun = (self._stored, time.monotonic())
                self._readings = {axis: self._readings.get(axis, {}) for axis in said.gauges}
            case recorder.Waiting():
                self._visit = self._tour.visit(said.cycle, said.pose)
                self._waiting = said.missing
            case recorder.Stored():
                visit = self._tour.visit(said.cycle, said.pose)
                self._readings[said.axis][visit] = ShownReading(said.value, said.text, said.unit)
                of = self._tour.name(visit)
                self._status = (f"{said.axis} {said.text} {said.unit} of {of} STORED", "good")
            case recorder.CycleDone():
                self._stored = self._tour.visit(said.cycle, said.pose)
                note = ": recorded; analyze discards it" if said.discarded else ""
                self._status = (f"{self._tour.name(self._stored)} STORED{note}", "good")
            case recorder.Problem() | recorder.Gross() | recorder.Refused():
                self._troubles[said.event] += 1
                self._status = (_in_words(said), "bad")
            case recorder.Voided():
                visit = self._tour.visit(said.cycle, said.pose)
                self._stored = visit - 1
                for axis in said.axes:
                    self._readings[axis].pop(visit, None)
                self._status = (f"{self._tour.name(visit)} {' '.join(said.axes)} voided", "bad")
            case recorder.Noted(text=text):
                self._status = (f"note written: {text}", "quiet")
            case recorder.Noticed():
                self._status = (": ".join(filter(None, (said.axis, said.message))), "quiet")
            case recorder.Paused(on=on):
                self._paused = on
                self._status = ("paused" if on else "goes on", "plain")
            case recorder.Done():
                at = self._view()
                self._status = (f"{said.table}: {at.stored} of {at.planned} {at.counted}", "good")
                self._last = self._following or _next(said)

    def _warn(self, said: Watched) -> None:
        if said.says == "structure" and not self._warning:
            self._ring(2)
        self._warning = reporting.warning(said)

    def _view(self, *, over: bool = False) -> LiveView:
        return LiveView(
            title=self._title,
            place=self._place(self._stored, self._pace()) if self._place else "",
            large=not over,
            stored=self._stored,
            planned=self._cycles * len(self._tour),
            counted="visits" if self._tour.poses else "cycles",
            axes=[self._axis(name) for name in self._readings],
            status=self._status,
            troubles=", ".join(f"{n} {kind}" for kind, n in sorted(self._troubles.items())),
            warning=self._warning,
            next_step=self._next_step() if self._last or not over else "",
            keys="" if over or not isinstance(self._operator, Keys) else self._keys(),
            prompt=self._prompt(),
        )

    def _prompt(self) -> str:
        """Return what is typed, to a question that names what would be struck."""
        if not isinstance(self._operator, Keys):
            return ""
        visit = max((max(shown, default=0) for shown in self._readings.values()), default=0)
        last = [
            f"{axis} {shown[visit][1]}" for axis, shown in self._readings.items() if visit in shown
        ]
        together = self._trigger != "data" or len(self._readings) == 1
        named = ", ".join([self._tour.name(visit), *last])
        return self._operator.prompt(named) if last and together else self._operator.prompt()

    def _pace(self) -> float | None:
        """Return the seconds a visit of this session, from the third on."""
        stored = self._stored - self._begun[0]
        return (time.monotonic() - self._begun[1]) / stored if stored > 2 else None

    def _keys(self) -> str:
        return f"Enter take  {KEYS}" if self._trigger == "enter" else KEYS

    def _axis(self, name: str) -> AxisView:
        """Return what was shown last, and the readings at the pose of it."""
        readings, poses = self._readings[name], len(self._tour)
        last = max(readings, default=0)
        _, text, unit = readings.get(last, (0.0, "", ""))
        here = {v: shown[0] for v, shown in readings.items() if (v - last) % poses == 0}
        used = tuple(value for visit, value in here.items() if visit > poses)
        used = _on_one_turn(used) if unit in _ANGLES else used
        cycle, pose = self._tour.place(last) if last else (0, None)
        figures = "  ".join(part for part in (pose, _figures(used)) if part)
        return AxisView(name, text, unit, cycle, used, figures)

    def _next_step(self) -> str:
        if self._last:
            return f"Now: scara-iso {self._last}"
        if self._paused:
            return "Paused: press p to go on"
        if self._stored == self._cycles * len(self._tour):
            return "Every cycle is recorded: v strikes the last reading, q ends"
        missing = f" ({', '.join(self._waiting)})" if len(self._readings) > 1 else ""
        typed = isinstance(self._operator, Keys) and self._operator.takes_readings
        how = _TYPED if typed else _NEXT.get(self._trigger) or _how(self._trigger)
        if pose := self._tour.place(self._visit)[1]:
            how = how.replace("the pose", f"pose {pose}")
        visit = self._tour.name(self._visit)
        return f"{visit[0].upper()}{visit[1:]}{missing}: {how}"


def _in_words(said: recorder.Problem | recorder.Gross | recorder.Refused) -> str:
    match said:
        case recorder.Problem():
            return f"{said.axis}: {said.message}"
        case recorder.Refused():
            return f"{said.axis} {said.text} not taken: {said.reason}"
    return said.message


def make_screen(recording: Prepared, operator: recorder.Operator, *, quiet: bool) -> Screen:
    """Return the screen of a recording on standard output."""
    job, part, earlier = recording.job, recording.part, recording.earlier
    return Screen(
        LiveScreen(open_console(sys.stdout, no_color=settings.no_color)),
        operator,
        title=f"scara-iso record {job.table.name if part is None else job.table.parent}",
        earlier={axis: column.shown for axis, column in earlier.columns.items()} if earlier else {},
        place=None if part is None else part.said,
        quiet=quiet,
        following=None if part is None else f"test status {quote(str(job.table.parent))}",
    )


def _how(trigger: str) -> str:
    """Return what takes a reading, where it is none of `_NEXT`."""
    kind, _, seconds = trigger.partition(":")
    if kind == "timer":
        return f"read by the timer, every {seconds} s"
    if trigger.startswith("settled"):
        return f"read when the dial has come back to rest ({trigger})"
    return f"read when the robot says AT and the pose, on {trigger}"


def _on_one_turn(angles: tuple[float, ...]) -> tuple[float, ...]:
    """Return angles [deg] as the table will have them, as they are where it will be refused."""
    with suppress(DataError):
        return tuple(unwrap(np.array(angles)).tolist())
    return angles


def _next(done: recorder.Done) -> str:
    if done.cycles < done.planned:
        return f"record --resume {quote(str(done.table))}"
    cycles = f" --cycles {done.planned}" if done.planned != iso9283.CYCLES_RUN else ""
    return f"analyze {quote(str(done.table))}{cycles}"


def _figures(readings: tuple[float, ...]) -> str:
    """Return count and mean of at least two readings; RP with those of which it has an interval."""
    if len(readings) < 2:
        return ""
    values, n = np.array([readings]), len(readings)
    found, S = iso9283.repeatability(values), float(iso9283.standard_deviation(values)[0])
    mean = reporting.rounded(float(found.mean[0]), 2 * S / n**0.5)
    if n < _FEWEST_FOR_RP:
        return f"n {n}  mean {mean}"
    RP = float(found.RP)
    return f"n {n}  mean {mean}  RP {reporting.rounded(RP, reporting.U_of_scatter(RP, n))}"
