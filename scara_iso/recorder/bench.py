"""The gauges of a session, looked at together: what arrives, and readings on request."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from scara_iso.indicators import Garbage, InstrumentFault, Notice, Reading
from scara_iso.ports import Clock
from scara_iso.recorder.events import Kind, Noticed, Problem, Refused, Said
from scara_iso.recorder.gauge import Gauge, no_unit
from scara_iso.recorder.journal import Journal

SETTLING_S = 10.0
"""Longest time that a value may take to settle, under the rule of equal readings [s]."""


@dataclass(frozen=True, slots=True)
class Taken:
    """A reading of a gauge and when its last byte arrived [s]; ``stale`` began too early."""

    gauge: Gauge
    reading: Reading
    time: float
    stale: bool


class Bench:
    """Several gauges on one clock; what is no reading is written down and told at once."""

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
        self.last_problem = ""

    def open(self) -> None:
        """Let powers come up, refuse what is under way, and learn the units.

        Raises `UsageError` where nobody states the unit of a gauge.
        """
        self.drain(max(gauge.port.settle_s for gauge in self.gauges), "sent before the session")
        deadline = max(gauge.ask_unit(self._journal, self._clock) for gauge in self.gauges)
        while self._clock.now() < deadline:
            self.refuse(self.receive(), "the unit was asked for")
            if not any(gauge.outstanding for gauge in self.gauges):
                break
            self._clock.idle(deadline)
        for gauge in self.gauges:
            if gauge.unit is None and gauge.dialect.units == (None,):
                raise no_unit(gauge)
            gauge.outstanding = 0
            gauge.expect_from_now()

    def receive(self) -> list[Taken]:
        """Look at every port once and return the readings that have arrived."""
        readings = []
        for gauge in self.gauges:
            for arrival in gauge.receive(self._journal, self._clock):
                match arrival.event:
                    case Reading() as reading:
                        readings.append(Taken(gauge, reading, arrival.time, arrival.stale))
                    case Garbage(reason=reason, raw=raw):
                        self.problem(gauge, "garbage", f"{reason}: {raw!r}")
                    case InstrumentFault(code=code, message=message):
                        self._faulted = True
                        self.problem(gauge, "fault", f"{code}: {message}")
                    case Notice(message=message):
                        self._tell(Noticed(gauge.axis, message))
        return readings

    def measure(self, stable: int) -> list[Taken] | None:
        """Return one reading of every gauge, or None after saying what went wrong.

        ``stable`` readings in a row lie within one count of the last place.
        """
        series: list[list[Taken]] = []
        until = self._clock.now() + SETTLING_S
        while not series or self._clock.now() < until:
            taken = self._ask()
            if taken is None:
                return None
            series = [*series, taken][-stable:]
            if len(series) == stable and all(map(_settled, zip(*series, strict=True))):
                return taken
        for gauge in self.gauges:
            self.problem(gauge, "unsettled", f"not {stable} equal readings in {SETTLING_S:g} s")
        return None

    def drain(self, seconds: float, reason: str) -> None:
        """Refuse what arrives for a while, and for as long as late answers may still come.

        The time of a late answer is the dialect's answer time once more; `_ask` meets one that
        comes later still as a second answer.
        """
        start = self._clock.now()
        while self._clock.now() < start + max([seconds, *self._slow()]):
            self.refuse(self.receive(), reason)
            self._clock.idle(start + max([seconds, *self._slow()]))
        for gauge in self.gauges:
            if gauge.outstanding and (dropped := gauge.forget_partial()):
                self.problem(gauge, "garbage", dropped.reason)

    def refuse(self, readings: Iterable[Taken], reason: str) -> None:
        """Write down and say that these readings are not taken."""
        for taken in readings:
            axis, text = taken.gauge.axis, taken.reading.text
            self._journal.append("refused", axis=axis, text=text, reason=reason)
            self._tell(Refused(axis, text, reason))

    def problem(self, gauge: Gauge, kind: Kind, message: str) -> None:
        """Write down and say that there is no reading."""
        self.last_problem = f"{gauge.axis}: {message}"
        self._journal.append(kind, axis=gauge.axis, message=message)
        self._tell(Problem(gauge.axis, kind, message))

    def _slow(self) -> list[float]:
        return [gauge.dialect.answer_time_s for gauge in self.gauges if gauge.outstanding]

    def _ask(self) -> list[Taken] | None:
        """Ask every gauge once; a gauge that owes an answer is listened to until its time is up."""
        self.refuse(self.receive(), "not asked for")
        self._faulted = ambiguous = False
        owing = {gauge.axis for gauge in self.gauges if gauge.outstanding}
        deadline = max(gauge.ask(self._journal, self._clock) for gauge in self.gauges)
        taken: dict[str, Taken] = {}
        while self._clock.now() < deadline and (owing or len(taken) < len(self.gauges)):
            for one in self.receive():
                axis = one.gauge.axis
                if one.stale or axis in taken or one.gauge.of_other_channel(one.reading):
                    self.refuse([one], _why(one, taken))
                    ambiguous |= axis in taken and axis in owing
                else:
                    taken[axis] = one
            if self._faulted:
                self.refuse(taken.values(), "a gauge of the same cycle is at fault")
                return None
            self._clock.idle(deadline if len(taken) < len(self.gauges) or owing else 0.0)
        return self._answers(taken, ambiguous=ambiguous)

    def _answers(self, taken: Mapping[str, Taken], *, ambiguous: bool) -> list[Taken] | None:
        silent = [gauge for gauge in self.gauges if gauge.axis not in taken]
        for gauge in silent:
            self.problem(gauge, "timeout", f"no answer in {gauge.dialect.answer_time_s:g} s")
        if silent or ambiguous:
            why = "two answers after a missed one" if ambiguous else "another gauge is silent"
            self.refuse(taken.values(), why)
            return None
        for gauge in self.gauges:
            gauge.outstanding = 0
        return [taken[gauge.axis] for gauge in self.gauges]


def _why(one: Taken, taken: Mapping[str, Taken]) -> str:
    if one.stale:
        return "begun before the request"
    if one.gauge.axis in taken:
        return "a second answer to one request"
    return f"of channel {one.reading.channel}: give ?channel="


def _settled(series: Sequence[Taken]) -> bool:
    """Say whether the readings of one gauge lie within one count of the last place."""
    values = [taken.reading.value for taken in series]
    return max(values) - min(values) <= series[-1].reading.resolution
