"""What the tests of one robot amount to over months: what `history` publishes, all frozen.

What was done to the robot stands between them: a table with the columns date and what.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from scara_iso.base.displayed import Displayed
from scara_iso.base.published import ALWAYS, INTERNAL, Interval, Unit, fill, published, row_of
from scara_iso.comparison.charts import Cusum, Ewma, Individuals, LimitCrossing, Trend
from scara_iso.comparison.decision import Comparison
from scara_iso.iso9283 import Analysis, Conformity, parse_moment
from scara_iso.run import FloatArray, frame_of
from scara_iso.tables import ColumnNames, read_columns

if TYPE_CHECKING:
    import pandas as pd

_SECONDS = 86400
_FIRST, _LAST = 1950, 2150  # years


def is_plausible(when: datetime) -> bool:
    """Return whether a robot can have been tested then: a slip of the pen is no date."""
    return _FIRST <= when.year <= _LAST


def day_of(when: datetime) -> float:
    """Return days since 1970-01-01, as local time reads them."""
    midnight = when.replace(hour=0, minute=0, second=0, microsecond=0)
    start = date(1970, 1, 1).toordinal()
    return when.toordinal() - start + (when - midnight).total_seconds() / _SECONDS


def moment_said(when: datetime) -> str:
    """Return ``2026-05-12``, with the time of day where there is one: ``2026-05-12T14:30``."""
    day, time = when.date().isoformat(), when.time()
    if not any((time.hour, time.minute, time.second, time.microsecond)):
        return day
    return when.isoformat(timespec="seconds" if time.second or time.microsecond else "minutes")


_COLUMNS = ColumnNames(
    what="service events",
    needed=("date", "what"),
    remedy="two columns: date,what and lines such as 2026-05-12,belt of joint 2 renewed",
    labels=frozenset({"date", "what"}),
    aliases={"datum": "date", "day": "date"}
    | dict.fromkeys(("was", "event", "service", "ereignis", "maßnahme"), "what"),
)
_LONGEST = 200


@dataclass(frozen=True, slots=True)
class ServiceEvent:
    """Something that was done to the robot; tests of that day count as behind it."""

    when: datetime = field(metadata=published("date", by=moment_said))
    """With the time of day where one is stated."""
    what: str
    """What was done."""


def read_events(path: str | Path) -> tuple[ServiceEvent, ...]:
    """Return the events of a table in time order; raises as `read_columns`."""
    table = read_columns(path, _COLUMNS)
    events = []
    for line, date_, what in zip(
        table.lines, *(table.labels[n] for n in _COLUMNS.needed), strict=True
    ):
        when = parse_moment(date_)
        if when is None or not is_plausible(when):
            table.faults.add(f"{date_[:60]!r} is not a date", line, 1, remedy=_COLUMNS.remedy)
        else:
            events.append(ServiceEvent(when, what[:_LONGEST]))
    table.faults.check()
    return tuple(sorted(events, key=lambda event: event.when))


def cycles_counted(test: Analysis) -> int:
    """Return how many cycles count."""
    return test.cycles.used


@dataclass(frozen=True, slots=True)
class DatedAnalysis:
    """One test."""

    when: datetime = field(metadata=published("date", by=moment_said))
    """With the time of day where one is stated."""
    analysis: Analysis = field(metadata=published("cycles", by=cycles_counted))
    """Its figures and findings; of these the cycles that count."""
    source: str = field(init=False)
    """Name of its table."""

    def __post_init__(self) -> None:
        fill(self, source=self.analysis.source)


@dataclass(frozen=True, slots=True)
class TestFigure:
    """One figure of one test."""

    __test__ = False  # no test of ours

    when: datetime = field(metadata=published("date", by=moment_said))
    """When it was measured."""
    source: str
    """Name of its table."""
    value: float
    """In the unit of the history."""
    interval: Interval | None
    """95 %; None where so few cycles allow none."""
    n: int
    """Cycles that count."""
    error: float
    """Standard error by sampling: of the logarithm of a figure of scatter, of a mean itself."""
    verdict: Conformity | None = field(default=None, metadata=ALWAYS)
    """Against the limit that was given."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class SpreadHistory:
    """RP, or 3 S of an angle, at one pose over the tests."""

    pose: str | None
    """Label; None where no table names one."""
    figure: str
    """``X``, ``XY`` and so on."""
    quantity: Literal["RP", "three_sigma"]
    """What is followed."""
    unit: Unit
    """Of every value."""
    tests: tuple[TestFigure, ...]
    """In time order."""
    sampling: float
    """Standard error of a figure's logarithm, by sampling alone."""
    sigma: float
    """As neighbouring tests differ; never less than `sampling`."""
    standardised: FloatArray
    """Each test against those before it since the last service, shape (tests,)."""
    ewma: Ewma | None = field(default=None, metadata=ALWAYS)
    """None for fewer than five tests, or where a figure is 0."""
    cusum: Cusum | None = field(default=None, metadata=ALWAYS)
    """Likewise."""
    trend: Trend | None = field(default=None, metadata=ALWAYS)
    """Since the last service; None for fewer than five tests, or where they break off."""
    limit: float | None = field(metadata=INTERNAL)
    """That was given; None without."""
    crossing: LimitCrossing | None = field(default=None, metadata=INTERNAL)
    """When the limit is met; None without limit or trend."""
    since_service: int = field(metadata=INTERNAL)
    """First test, from 0, behind the last service."""
    breaks: tuple[int, ...] = field(default=(), metadata=INTERNAL)
    """Tests, from 0, whose figure is many times, or a small part of, that of the test before."""
    service_date: str = field(init=False, metadata=published("since_service"))
    """Date of the first test behind the last service."""
    crossed: bool = field(init=False, metadata=INTERNAL)
    """Whether, since the last service, a test broke the limit, or the last lies above it."""
    limit_crossing: LimitCrossing | None = field(init=False, metadata=published("limit"))
    """None where no limit was given."""

    def __post_init__(self) -> None:
        later = self.tests[self.since_service :]
        fill(self, crossed=False, limit_crossing=None, service_date=moment_said(later[0].when))
        if self.limit is not None:
            crossed = bool(self.broken) or self.tests[-1].value > self.limit
            found = self.crossing or LimitCrossing(self.limit)
            fill(self, crossed=crossed, limit_crossing=replace(found, crossed=crossed))

    @property
    def broken(self) -> tuple[TestFigure, ...]:
        """The tests since the last service that broke the limit."""
        later = self.tests[self.since_service :]
        return tuple(test for test in later if test.verdict is Conformity.FAIL)

    @property
    def is_proven(self) -> bool:
        """Whether the last test proves the limit kept, as `analyze` decides it."""
        return self.tests[-1].verdict in (None, Conformity.PASS)

    @property
    def alarms(self) -> tuple[int, ...]:
        """Tests, from 0, at which a chart speaks."""
        charts = [chart.alarms for chart in (self.ewma, self.cusum) if chart is not None]
        return tuple(sorted({k for alarms in charts for k in alarms}))


@dataclass(frozen=True, eq=False, slots=True)
class MeanHistory:
    """The mean of one axis at one pose over the tests: robot, fixture and zero of the dial."""

    pose: str | None
    """Label; None where no table names one."""
    figure: str
    """Name of the axis."""
    unit: Unit
    """Of every value."""
    tests: tuple[TestFigure, ...]
    """In time order."""
    chart: Individuals | None
    """None for fewer than five tests."""


@dataclass(frozen=True, slots=True)
class ServiceChange:
    """The last test before a service against the first behind it."""

    event: ServiceEvent
    """What was done."""
    comparison: Comparison
    """The last test before it against the first behind it."""


@dataclass(frozen=True, slots=True)
class UnreadableTable:
    """A table that is left out."""

    source: str
    """Its name."""
    error: str
    """Why it could not be used."""
    may_be_last: bool = field(default=False, metadata=INTERNAL)
    """Whether nothing says that a test came behind it: then the last one proves no limit kept."""

    def __str__(self) -> str:
        last = ", and it may be the last test" if self.may_be_last else ""
        return f"left out{last}: {self.source}: {self.error}"


@dataclass(frozen=True, slots=True)
class CrossedLimit:
    """A limit that is crossed."""

    pose: str | None
    """None where no table names one."""
    figure: str
    """`X`, `XY` and so on."""
    limit: float
    """In the unit of the figure."""


def crossed_limits(found: tuple[SpreadHistory, ...]) -> tuple[CrossedLimit, ...]:
    """Return what is published of figures that crossed their limit."""
    return tuple(
        CrossedLimit(one.pose, one.figure, one.limit) for one in found if one.limit is not None
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class RobotHistory(Displayed):
    """``history`` of one robot."""

    schema: Literal["scara-iso/history/1"] = "scara-iso/history/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    robot: str
    """Its name; empty where no table states one."""
    serial: str
    """Its serial number; empty where no table states one."""
    notes: tuple[str, ...] = ()
    """What the tests differ in, and what else the history must be read with."""
    tests: tuple[DatedAnalysis, ...]
    """In time order."""
    unreadable: tuple[UnreadableTable, ...] = ()
    """Tables that could not be used."""
    events: tuple[ServiceEvent, ...]
    """In time order."""
    spreads: tuple[SpreadHistory, ...] = field(metadata=published("figures"))
    """One for each pose and figure."""
    means: tuple[MeanHistory, ...]
    """One for each pose and axis."""
    changes: tuple[ServiceChange, ...]
    """One for each service with a test on both sides."""
    crossed: tuple[SpreadHistory, ...] = field(init=False, metadata=published(by=crossed_limits))
    """The figures that crossed their limit."""

    def __post_init__(self) -> None:
        fill(self, crossed=tuple(one for one in self.spreads if one.crossed))

    def __repr__(self) -> str:
        return f"<RobotHistory of {self.robot or 'a robot'}: {len(self.tests)} tests>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: a row for each test and figure, with its interval."""
        rows = [
            *(_row(one, one.quantity, test) for one in self.spreads for test in one.tests),
            *(_row(one, "mean", test) for one in self.means for test in one.tests),
        ]
        return frame_of(rows, {"robot": self.robot})


def _row(
    history: SpreadHistory | MeanHistory, quantity: str, test: TestFigure
) -> Mapping[str, Any]:
    return {
        "when": test.when,
        "pose": history.pose,
        "figure": history.figure,
        "quantity": quantity,
        "unit": history.unit,
        **row_of(test),
    }
