"""One robot over months: every test in time order, control charts, trend, limit, service.

`follow` gives a `RobotHistory` of analyses; a figure is an estimate, and its own sampling error is
in every limit.
"""

from typing import TYPE_CHECKING

from scara_iso.faces import face

if TYPE_CHECKING:
    from scara_iso.monitoring.charts import (
        Cusum as Cusum,
        Ewma as Ewma,
        Individuals as Individuals,
        between_tests as between_tests,
        cusum as cusum,
        ewma as ewma,
        individuals as individuals,
        standardised as standardised,
    )
    from scara_iso.monitoring.days import (
        date_on as date_on,
        day_of as day_of,
        is_plausible as is_plausible,
        moment_said as moment_said,
    )
    from scara_iso.monitoring.events import ServiceEvent as ServiceEvent, read_events as read_events
    from scara_iso.monitoring.published import (
        PublishedHistory as PublishedHistory,
        published_history as published_history,
    )
    from scara_iso.monitoring.result import (
        DatedAnalysis as DatedAnalysis,
        MeanHistory as MeanHistory,
        RobotHistory as RobotHistory,
        ServiceChange as ServiceChange,
        SpreadHistory as SpreadHistory,
        TestFigure as TestFigure,
    )
    from scara_iso.monitoring.sequence import follow as follow
    from scara_iso.monitoring.trend import (
        LimitCrossing as LimitCrossing,
        Trend as Trend,
        crossing as crossing,
        trend_of as trend_of,
    )
else:
    __getattr__ = face(__name__)
