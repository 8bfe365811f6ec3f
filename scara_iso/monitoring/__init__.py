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
        LimitCrossing as LimitCrossing,
        Trend as Trend,
        between_tests as between_tests,
        crossing as crossing,
        cusum as cusum,
        ewma as ewma,
        individuals as individuals,
        standardised as standardised,
        trend_of as trend_of,
    )
    from scara_iso.monitoring.events import (
        ServiceEvent as ServiceEvent,
        date_on as date_on,
        day_of as day_of,
        is_plausible as is_plausible,
        moment_said as moment_said,
        read_events as read_events,
    )
    from scara_iso.monitoring.history import (
        DatedAnalysis as DatedAnalysis,
        MeanHistory as MeanHistory,
        RobotHistory as RobotHistory,
        ServiceChange as ServiceChange,
        SpreadHistory as SpreadHistory,
        TestFigure as TestFigure,
        follow as follow,
    )
    from scara_iso.monitoring.published import (
        PublishedHistory as PublishedHistory,
        published_history as published_history,
    )
else:
    __getattr__ = face(__name__)
