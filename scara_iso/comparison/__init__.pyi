from .charts import date_on as date_on
from .decision import (
    MOST_CYCLES as MOST_CYCLES,
    Comparison as Comparison,
    Contrast as Contrast,
    ContrastVerdict as ContrastVerdict,
    Ends as Ends,
    Pair as Pair,
    SpreadContrast as SpreadContrast,
)
from .history import follow as follow
from .pairs import (
    CONDITIONS as CONDITIONS,
    PAGES as PAGES,
    SEED as SEED,
    compare as compare,
    exchangeability as exchangeability,
    poses_in_common as poses_in_common,
)
from .robot_history import (
    DatedAnalysis as DatedAnalysis,
    MeanHistory as MeanHistory,
    RobotHistory as RobotHistory,
    ServiceEvent as ServiceEvent,
    SpreadHistory as SpreadHistory,
    TestFigure as TestFigure,
    UnreadableTable as UnreadableTable,
    day_of as day_of,
    is_plausible as is_plausible,
    moment_said as moment_said,
    read_events as read_events,
)
