"""One indicator on one axis: its port, its decoder, the unit it is read in, what it showed before.

What it shows is compared as it was shown, in the unit of the display; no statement about the unit
is needed. Cycle 1 says nothing of the others: `analyze` discards it. Each pose has a level of its
own.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Iterator
from decimal import Decimal
from statistics import median
from typing import Literal, NamedTuple

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.base.quantities import parse_unit
from scara_iso.recorder.indicators import (
    Decoder,
    DeviceNotice,
    Event,
    Garbage,
    InstrumentFault,
    Reading,
    diagnose_parity,
    find_dialects,
)
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.plan import GaugeSpec
from scara_iso.recorder.ports.port import PULSE, Clock, Port

INCH = Decimal("25.4")
_LOOK_BACK = 100
_FEWEST = 4
_LIKE = Decimal("0.1")
"""A step is one of 25.4 within this share: what the arm scatters, and the rounding of inches."""
_COUNTS = 50
"""A level of fewer counts of the last place is near zero: any ratio may come by chance."""
_RANGES = 8
_GROSS_COUNTS = 10


class HaltError(InstrumentError):
    """Recording cannot go on until somebody at the bench puts something right; exit code 69.

    ``question`` is what who sits at the terminal is asked to do. ``changed`` are the unit, the
    resolution or the zero of an indicator, ``place`` is where the arm stands in a tour.
    """

    def __init__(
        self,
        axis: str,
        what: str,
        *,
        remedy: str,
        kind: Literal["changed", "place"] = "changed",
        question: str = "put it right",
    ) -> None:
        super().__init__(what, where=f"gauge {axis}", remedy=remedy)
        self.axis, self.kind, self.question = axis, kind, question


class Shown:
    """The latest readings of one gauge by visit; every cycle visits all ``poses``."""

    def __init__(self, *, fixed_decimals: bool, poses: int = 1) -> None:
        self._fixed = fixed_decimals
        self._poses = poses
        self._values: deque[tuple[int, Decimal]] = deque(maxlen=_LOOK_BACK * poses)

    def __bool__(self) -> bool:
        return bool(self._values)

    def put(self, visit: int, text: str) -> None:
        """Take the reading of a visit."""
        self._values.append((visit, Decimal(text)))

    def void(self, visit: int) -> None:
        """Forget a visit."""
        left = [one for one in self._values if one[0] != visit]
        self._values = deque(left, maxlen=self._values.maxlen)

    def _at_pose(self, visit: int) -> dict[int, Decimal]:
        """Return the readings at the pose of a visit."""
        return {v: x for v, x in self._values if (v - visit) % self._poses == 0}

    def changed(self, text: str, visit: int) -> str:
        """Return why unit or resolution of the display seem changed at a visit, or nothing."""
        if not self._values:
            return ""
        value, before, now = Decimal(text), _decimals(self._values[-1][1]), _decimals(Decimal(text))
        if self._fixed and before != now:
            return f"{text} has {now} decimal{'s' * (now != 1)}, the reading before had {before}"
        values = [x for v, x in self._at_pose(visit).items() if v != visit]
        level = median(values) if values else Decimal(0)
        if not values or max(values) - min(values) > abs(level) * 3 * _LIKE:
            return ""
        for name, expected in (("1/25.4", level / INCH), ("25.4", level * INCH)):
            counts = min(abs(level), abs(expected) * INCH).scaleb(before)
            if counts >= _COUNTS and abs(value - expected) <= abs(expected) * _LIKE:
                return f"{text} is {name} of the readings before, as of mm and inch"
        return ""

    def gross(self, visit: int) -> Iterator[tuple[int, Decimal, Decimal]]:
        """Yield visit, value and distance from the others' median where that of a visit is far.

        Of the first readings that are enough to tell, each is looked at.
        """
        known = {v: x for v, x in self._at_pose(visit).items() if v > self._poses}
        for one, value in known.items():
            if one == visit or len(known) == _FEWEST + 1:
                distance = self.far(str(value), one)
                if distance is not None:
                    yield one, value, distance

    def far(self, text: str, visit: int) -> Decimal | None:
        """Return how far a gross reading is from the median of the others, None where it is not."""
        others = [x for v, x in self._at_pose(visit).items() if v > self._poses and v != visit]
        if len(others) < _FEWEST:
            return None
        value = Decimal(text)
        count = Decimal(1).scaleb(-_decimals(value))
        limit = max(_RANGES * (max(others) - min(others)), _GROSS_COUNTS * count)
        distance = abs(value - median(others))
        return distance if distance > limit else None


def _decimals(value: Decimal) -> int:
    return max(0, -int(value.as_tuple().exponent))


_LINE = re.compile(rb"([^\r\n\0\x8d\x8a]+)([\r\n\x8d\x8a]+)")
_LINE_END = re.compile(rb"[\r\n\x8d\x8a]")
"""CR and LF, also with a parity in bit 8, where the decoder ends a line too."""


class Taken(NamedTuple):
    """A reading of a gauge and when its last byte arrived [s]; ``stale`` began too early."""

    gauge: Gauge
    reading: Reading
    time: float
    stale: bool


class Gauge:
    """Reads one indicator; everything received and sent goes to the journal first.

    Its unit is a recording's or a simulation's own, that of the option, or the one ``before``, of
    the session before; without one `unit` is None until it states it. `outstanding` counts
    requests that nothing answered: while it is not zero, the next frame may be the answer to an
    earlier one. `doubtful` holds where a pending answer was dropped and none came alone since;
    `slowest` is the longest time that an answer took [s]; `odd` counts the latest answers of a
    display that seems to have changed. `tells_unit` holds where it has answered which unit it
    shows; `unit_stated` is when [s].
    """

    def __init__(self, spec: GaugeSpec, port: Port, *, before: str | None, poses: int) -> None:
        self.axis = spec.axis
        self._spec = spec
        self.dialect = spec.dialect
        self.port = port
        self.unit_from, self.unit = _stated_unit(spec, port, before)
        self.outstanding = 0
        self.unit_asked = self.doubtful = self.tells_unit = False
        self.unit_stated = -math.inf
        self.slowest = 0.0
        self.shown = Shown(fixed_decimals=spec.dialect.fixed_decimals, poses=poses)
        self.odd = 0
        self._active = -math.inf
        self._channel: str | None = None
        self._decoder = Decoder(spec.dialect)
        self._within_line = False
        self._stale = False
        self._latest = b""

    def receive(self, journal: Journal, clock: Clock) -> list[Taken | Event]:
        """Return the events of what has arrived, at once.

        Raises `InstrumentError` where the port is lost, `HaltError` where the unit is another than
        before, and `UsageError` for a reading whose unit nobody states.
        """
        data = self.port.read()
        if not data:
            return []
        journal.append("in", axis=self.axis, port=self.port.address, hex=data.hex())
        self._latest = (self._latest + data)[-80:]  # the last line may be quoted
        now = self._active = clock.now()
        came: list[tuple[Event, bool]] = []
        if self._stale and (end := _LINE_END.search(data)):
            begun, data = data[: end.end()], data[end.end() :]
            came = [(event, True) for event in self._decoder.feed(begun)]
            self._stale = self._within_line = False
        if data:
            self._within_line = _LINE_END.match(data[-1:]) is None
            came += [(event, False) for event in self._decoder.feed(data)]
        before = self.unit_stated
        for event, stale in came:
            self._check(event, now, stale=stale)
        if before == -math.inf < self.unit_stated:
            journal.append("unit", axis=self.axis, unit=self.unit)
        return [Taken(self, e, now, stale) if isinstance(e, Reading) else e for e, stale in came]

    def ask(self, journal: Journal, clock: Clock) -> float:
        """Ask for a reading and return when it must be there [s].

        An indicator that only sends by itself is not asked: its next whole line counts.
        """
        self.expect_from_now()
        if self.dialect.asks:
            self._note_sent(self.dialect.request or PULSE, journal)
            self.port.ask(self.dialect)
        self.outstanding += self.dialect.asks
        self._active = clock.now()
        return self._active + self.dialect.answer_time_s

    def ask_unit(self, journal: Journal, clock: Clock) -> float:
        """Ask which unit the display shows, also where it was stated; as `ask`.

        A recording or a simulation is not asked.
        """
        if self.port.unit or self.dialect.unit_request is None or self.dialect.request_line:
            return -math.inf
        self._note_sent(self.dialect.unit_request, journal)
        self.port.write(self.dialect.unit_request)
        self.unit_asked = True
        return clock.now() + self.dialect.answer_time_s

    def misread(self) -> InstrumentError | None:
        """Return what the latest line is, where its driver does not read it, and which one does."""
        line, end = (_LINE.findall(self._latest) or [(b"", b"")])[-1]
        if not line or self.dialect.parse(line):
            return None
        own, asked = self.dialect.key, (self.dialect.request, end)
        known = find_dialects().items()
        keys = [k for k, d in known if (d.request, d.terminator) == asked and d.parse(line)]
        named = " or ".join(f"`gauge={self._spec.text.replace(own, key, 1)}`" for key in keys)
        todo = f"{named} reads it" if named else "scara-iso ports `dialects=` lists others"
        what, where = f"{own} does not read what comes: {repr(line)[1:]}", f"gauge {self.axis}"
        return InstrumentError(what, where=where, remedy=diagnose_parity(line) or todo)

    def expect_from_now(self) -> None:
        """Mark a line that is under way as begun too early."""
        self._stale = self._within_line

    def quiet_after(self, answer_times: float) -> float:
        """Return when the line will have been quiet for so many answer times [s]."""
        return self._active + answer_times * self.dialect.answer_time_s

    def drop_pending(self) -> Garbage | None:
        """Await no answer to what was asked; drop a line whose end never came, and return it."""
        self.outstanding = 0
        self.doubtful = True
        self._within_line = self._stale = False
        return self._decoder.drop_partial()

    def _note_sent(self, data: bytes, journal: Journal) -> None:
        journal.append("out", axis=self.axis, port=self.port.address, hex=data.hex())

    def _check(self, event: Event, time: float, *, stale: bool) -> None:
        match event:
            case Reading(unit=unit, channel=channel):
                self._answered(stale=stale)
                self._check_unit(unit, time)
                self._channel = self._channel or channel
            case DeviceNotice(unit=str(unit)):
                self.tells_unit |= self.unit_asked
                self.unit_asked = False
                self._check_unit(unit, time)
            case InstrumentFault():
                self._answered(stale=stale)

    def _answered(self, *, stale: bool) -> None:
        """Count a line as the answer to what is owed; one begun too early answers nothing."""
        if self.unit_asked:
            self.unit_asked = False
        elif not stale:
            self.outstanding = max(0, self.outstanding - 1)

    def of_other_channel(self, reading: Reading) -> bool:
        """Say whether the reading is of another channel than the first one was."""
        return reading.channel not in (None, self._channel)

    def _check_unit(self, stated: str | None, time: float) -> None:
        stated = stated and parse_unit(stated).name
        if stated and self.unit not in (None, stated):
            raise HaltError(
                self.axis,
                f"the indicator shows {stated}, and {self.unit_from or 'it'} said {self.unit}",
                remedy="set the indicator or the option right; check readings already stored",
            )
        self.unit = self.unit or stated
        if stated:
            self.unit_stated = time
        if self.unit is None:
            raise no_unit(self)


def no_unit(gauge: Gauge) -> UsageError:
    """Return the error for an indicator whose unit nobody states."""
    return UsageError(
        f"{gauge.dialect.key} does not send its unit",
        where=f"gauge {gauge.axis}",
        remedy=f"look at the display and give `unit=mm`, or {gauge.axis}={gauge.dialect.key}"
        f"?unit=mm@{gauge.port.address}",
    )


def _stated_unit(spec: GaugeSpec, port: Port, before: str | None) -> tuple[str, str | None]:
    """Return who states the unit, and which; `UsageError` where two differ."""
    own = "the simulation" if port.address.startswith("sim:") else "the recording"
    units = {own: port.unit, "the option": spec.unit, "the session before": before}
    known = [(who, unit) for who, unit in units.items() if unit]
    for who, unit in known:
        if parse_unit(unit) != parse_unit(known[0][1]):
            raise UsageError(
                f"{known[0][0]} says {known[0][1]}, and {who} {unit}",
                where=f"gauge {spec.axis}",
                remedy="leave the option out, or give sim:?unit=",
            )
    return known[0] if known else ("", None)
