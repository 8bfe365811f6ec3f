"""What ``history`` publishes of a robot: schema ``scara-iso/history/1``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, cast

from scara_iso.base.published import Interval, Unit, publish
from scara_iso.comparison import PublishedComparison, published_comparison
from scara_iso.comparison.charts import Individuals, Trend
from scara_iso.comparison.events import ServiceEvent, date_on, moment_said
from scara_iso.comparison.history import (
    DatedAnalysis,
    MeanHistory,
    RobotHistory,
    SpreadHistory,
    TestFigure,
)
from scara_iso.iso9283 import Conformity
from scara_iso.run import FloatArray

_CROSSING = ("earliest", "likely", "latest", "horizon")


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedTest:
    """One test."""

    date: str
    """With the time of day where one is stated."""
    source: str
    """Name of its table."""
    cycles: int
    """Cycles that count."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UnreadableTable:
    """A table that is left out."""

    source: str
    """Its name."""
    error: str
    """Why it could not be used."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedEvent:
    """Something that was done to the robot."""

    date: str
    """With the time of day where one is stated."""
    what: str
    """What was done."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedTestFigure:
    """One figure of one test."""

    date: str
    """When it was measured."""
    source: str
    """Name of its table."""
    n: int
    """Cycles that count."""
    value: float
    """In the unit of the history."""
    interval: Interval | None
    """95 %; null where so few cycles allow none."""
    error: float
    """Standard error by sampling: of the logarithm of a figure of scatter, of a mean itself."""
    verdict: Conformity | None
    """Against the limit that was given."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedEwma:
    """Exponentially weighted mean of standardised values."""

    points: FloatArray
    """The weighted means, in standard errors."""
    limits: FloatArray
    """Upper limit; the lower one is its negative."""
    alarms: tuple[str, ...]
    """Dates of the tests that lie outside."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedCusum:
    """One-sided cumulative sums of standardised values."""

    up: FloatArray
    """Sum of what lies above, in standard errors."""
    down: FloatArray
    """As a sum above 0, of what lies below."""
    limit: float
    """The decision interval."""
    alarms: tuple[str, ...]
    """Dates of the tests at which a sum is beyond it."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedTrend:
    """The course of a figure since the last service."""

    per_month: float
    """Median of the rate, in the unit of the figure."""
    interval: Interval
    """95 %, of the rate."""
    shown: bool
    """Whether the rate is more than chance."""
    onset: tuple[str, str]
    """95 %, of the day on which it begins."""
    level: FloatArray
    """The expected figure at each test."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedCrossing:
    """A limit, and when the true figure meets it if it goes on as it does."""

    limit: float
    """In the unit of the figure."""
    crossed: bool
    """Whether, since the last service, a test broke the limit, or the last lies above it; the exit
    code is then 1."""
    earliest: str | None
    """Date from which the chance is 2.5 %; null: not before the horizon."""
    likely: str | None
    """50 %."""
    latest: str | None
    """97.5 %."""
    horizon: str | None
    """How far was looked ahead."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedSpreads:
    """RP, or 3 S of an angle, at one pose over the tests."""

    pose: str | None
    """Null where no table names one."""
    figure: str
    """`X`, `XY` and so on."""
    quantity: Literal["RP", "three_sigma"]
    """What is followed."""
    unit: Unit
    """Of every value."""
    sampling: float
    """Standard error of a figure's logarithm, by sampling alone."""
    sigma: float
    """As neighbouring tests differ; never less than `sampling`."""
    tests: tuple[PublishedTestFigure, ...]
    """In time order."""
    standardised: FloatArray
    """Each test against those before it since the last service."""
    ewma: PublishedEwma | None
    """Null for fewer than five tests, or where a figure is 0."""
    cusum: PublishedCusum | None
    """Likewise."""
    since_service: str
    """Date of the first test behind the last service."""
    trend: PublishedTrend | None
    """Null for fewer than five tests."""
    limit: PublishedCrossing | None
    """Null where none was given."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedChart:
    """Individuals: values against their mean, and moving ranges."""

    centre: FloatArray
    """Mean of the stretch between services that a test belongs to."""
    low: FloatArray
    """Three standard errors below it."""
    high: FloatArray
    """Three standard errors above it."""
    range_limit: float
    """Upper limit of the moving range."""
    sigma: float
    """Standard error of a value."""
    moving_range: tuple[float | None, ...]
    """Distance from the test before, null at the first of a stretch."""
    alarms: tuple[str, ...]
    """Dates of the tests that lie outside or moved farther than the limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedMeans:
    """The mean of one axis at one pose over the tests: robot, fixture and zero of the dial."""

    pose: str | None
    """Null where no table names one."""
    figure: str
    """Name of the axis."""
    unit: Unit
    """Of every value."""
    tests: tuple[PublishedTestFigure, ...]
    """In time order."""
    chart: PublishedChart | None
    """Null for fewer than five tests."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedChange:
    """What a service changed."""

    event: PublishedEvent
    """What was done."""
    comparison: PublishedComparison
    """The last test before it against the first behind it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CrossedLimit:
    """A limit that is crossed."""

    pose: str | None
    """Null where no table names one."""
    figure: str
    """`X`, `XY` and so on."""
    limit: float
    """In the unit of the figure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedHistory:
    """``history`` of one robot."""

    schema: Literal["scara-iso/history/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    robot: str
    """Its name; empty where no table states one."""
    serial: str
    """Its serial number; empty where no table states one."""
    notes: tuple[str, ...]
    """What the tests differ in, and what else the history must be read with."""
    tests: tuple[PublishedTest, ...]
    """In time order."""
    unreadable: tuple[UnreadableTable, ...]
    """Tables that could not be used."""
    events: tuple[PublishedEvent, ...]
    """In time order."""
    figures: tuple[PublishedSpreads, ...]
    """One for each pose and figure."""
    means: tuple[PublishedMeans, ...]
    """One for each pose and axis."""
    changes: tuple[PublishedChange, ...]
    """One for each service with a test on both sides."""
    crossed: tuple[CrossedLimit, ...]
    """The figures that crossed their limit."""


def published_history(found: RobotHistory) -> PublishedHistory:
    """Return what ``history`` says."""
    changes = [(one.event, published_comparison(one.comparison)) for one in found.changes]
    return PublishedHistory(
        schema="scara-iso/history/1",
        unit="mm",
        robot=found.robot,
        serial=found.serial,
        notes=found.notes,
        tests=tuple(map(_test, found.tests)),
        unreadable=tuple(UnreadableTable(source=of, error=why) for of, why in found.unreadable),
        events=tuple(map(_event, found.events)),
        figures=tuple(map(_spreads, found.spreads)),
        means=tuple(map(_means, found.means)),
        changes=tuple(PublishedChange(event=_event(e), comparison=one) for e, one in changes),
        crossed=tuple(publish(CrossedLimit, one) for one in found.crossed),
    )


def _test(test: DatedAnalysis) -> PublishedTest:
    cycles = test.analysis.cycles.used
    return PublishedTest(date=moment_said(test.when), source=test.source, cycles=cycles)


def _event(event: ServiceEvent) -> PublishedEvent:
    return PublishedEvent(date=moment_said(event.when), what=event.what)


def _spreads(found: SpreadHistory) -> PublishedSpreads:
    dates = [moment_said(test.when) for test in found.tests]
    ewma, cusum = found.ewma, found.cusum
    return publish(
        PublishedSpreads,
        found,
        tests=tuple(map(_figure, found.tests)),
        ewma=ewma and publish(PublishedEwma, ewma, alarms=_at(dates, ewma.alarms)),
        cusum=cusum and publish(PublishedCusum, cusum, alarms=_at(dates, cusum.alarms)),
        since_service=dates[found.since_service],
        trend=found.trend and _trend(found.trend),
        limit=None if found.limit is None else _limit(found),
    )


def _trend(found: Trend) -> PublishedTrend:
    first, last = map(date_on, found.onset)
    level = found.level(found.days)
    return publish(PublishedTrend, found, shown=found.is_shown, onset=(first, last), level=level)


def _limit(found: SpreadHistory) -> PublishedCrossing:
    days = {name: getattr(found.crossing, name, None) for name in _CROSSING}
    dates = {name: None if day is None else date_on(day) for name, day in days.items()}
    return publish(PublishedCrossing, found, **dates)


def _means(found: MeanHistory) -> PublishedMeans:
    dates = [moment_said(test.when) for test in found.tests]
    return PublishedMeans(
        pose=found.pose,
        figure=found.figure,
        unit=cast(Unit, found.unit),
        tests=tuple(map(_figure, found.tests)),
        chart=None if found.chart is None else _chart(found.chart, dates),
    )


def _chart(found: Individuals, dates: Sequence[str]) -> PublishedChart:
    moved = tuple(None if math.isnan(one) else one for one in found.moving_range.tolist())
    alarms = _at(dates, found.alarms)
    return publish(PublishedChart, found, moving_range=moved, alarms=alarms)


def _figure(test: TestFigure) -> PublishedTestFigure:
    return publish(PublishedTestFigure, test, date=moment_said(test.when))


def _at(dates: Sequence[str], alarms: Sequence[int]) -> tuple[str, ...]:
    return tuple(dates[k] for k in alarms)
