"""What the tests of one robot amount to over months; all frozen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any

from scara_iso.comparison import Comparison
from scara_iso.display import Displayed
from scara_iso.frames import frame_of, or_nan
from scara_iso.iso9283 import Analysis, Conformity
from scara_iso.monitoring.charts import Cusum, Ewma, Individuals
from scara_iso.monitoring.events import ServiceEvent
from scara_iso.monitoring.trend import LimitCrossing, Trend
from scara_iso.run import FloatArray

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True)
class DatedAnalysis:
    """One test, and when it was made."""

    when: datetime
    """Date, with a time where one is stated."""
    analysis: Analysis
    """Its figures and findings."""

    @property
    def source(self) -> str:
        """Name of its table."""
        return self.analysis.run.origin.source


@dataclass(frozen=True, slots=True)
class TestFigure:
    """One figure of one test."""

    __test__ = False  # no test of ours

    when: datetime
    """When it was measured."""
    source: str
    """Name of its table."""
    value: float
    """In the unit of the history."""
    interval: tuple[float, float] | None
    """95 %; None where so few cycles allow none."""
    n: int
    """Cycles that count."""
    error: float
    """Standard error by sampling: of the logarithm of a figure of scatter, of a mean itself."""
    verdict: Conformity | None = None
    """Against the limit that was given."""


@dataclass(frozen=True, eq=False, slots=True)
class SpreadHistory:
    """RP, or 3 S of an angle, at one pose over the tests."""

    pose: str | None
    """Label; None where no table names one."""
    figure: str
    """``X``, ``XY`` and so on."""
    quantity: str
    """``RP`` or ``three_sigma``."""
    unit: str
    """``mm`` or ``deg``."""
    tests: tuple[TestFigure, ...]
    """In time order."""
    sampling: float
    """Standard error of a figure's logarithm, by sampling alone."""
    sigma: float
    """Of the differences between tests; never less than ``sampling``."""
    standardised: FloatArray
    """Each test against those before it since the last service, shape (tests,)."""
    ewma: Ewma | None
    """None for fewer than five tests, or where a figure is 0."""
    cusum: Cusum | None
    """Likewise."""
    trend: Trend | None
    """Since the last service; None for fewer than five tests."""
    limit: float | None
    """That was given; None without."""
    crossing: LimitCrossing | None
    """When the limit is met; None without limit or trend."""
    since_service: int
    """First test, from 0, behind the last service."""

    @property
    def crossed(self) -> bool:
        """Whether, since the last service, a test broke the limit, or the last lies above it."""
        later = self.tests[self.since_service :]
        broken = any(test.verdict is Conformity.FAIL for test in later)
        return self.limit is not None and (broken or self.tests[-1].value > self.limit)

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
    unit: str
    """``mm`` or ``deg``."""
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


@dataclass(frozen=True, eq=False, slots=True)
class RobotHistory(Displayed):
    """Every test of one robot, in time order."""

    robot: str
    """Its name; empty where no table states one."""
    serial: str
    """Its serial number; empty where no table states one."""
    tests: tuple[DatedAnalysis, ...]
    """In time order."""
    events: tuple[ServiceEvent, ...]
    """In time order."""
    spreads: tuple[SpreadHistory, ...]
    """One for each pose and figure."""
    means: tuple[MeanHistory, ...]
    """One for each pose and axis."""
    changes: tuple[ServiceChange, ...]
    """One for each service with a test on both sides."""
    notes: tuple[str, ...] = ()
    """What the history must be read with."""
    unreadable: tuple[tuple[str, str], ...] = ()
    """Tables that could not be used, and why."""

    def __repr__(self) -> str:
        return f"<RobotHistory of {self.robot or 'a robot'}: {len(self.tests)} tests>"

    @property
    def crossed(self) -> tuple[SpreadHistory, ...]:
        """The figures that crossed their limit."""
        return tuple(one for one in self.spreads if one.crossed)

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
    low, high = test.interval or (None, None)
    return {
        "when": test.when,
        "source": test.source,
        "pose": history.pose,
        "figure": history.figure,
        "quantity": quantity,
        "unit": history.unit,
        "n": test.n,
        "value": test.value,
        "low": or_nan(low),
        "high": or_nan(high),
    }
