from .analysis import (
    BEYOND_DIALS as BEYOND_DIALS,
    ConditionAnalysis as ConditionAnalysis,
    FolderAnalysis as FolderAnalysis,
    OtherTests as OtherTests,
    analyze as analyze,
    hold_to as hold_to,
    not_measured as not_measured,
)
from .characteristics import find_characteristics as find_characteristics
from .checks import in_brief as in_brief
from .checks._stated import (
    day_in_name as day_in_name,
    moment_in_name as moment_in_name,
    moment_of_test as moment_of_test,
    parse_moment as parse_moment,
    zoned_moment_of_test as zoned_moment_of_test,
)
from .checks.calibration_date import past_due as past_due
from .checks.gross_reading import far_readings as far_readings
from .checks.parts_missing import not_recorded as not_recorded
from .checks.recording_disturbed import resumed_before as resumed_before
from .checks.trend import (
    TREND_LEVEL as TREND_LEVEL,
    holm as holm,
    mann_kendall as mann_kendall,
)
from .core.cycles import (
    AS_THE_TABLE_SAYS as AS_THE_TABLE_SAYS,
    CYCLES_RUN as CYCLES_RUN,
    CYCLES_USED as CYCLES_USED,
    Counting as Counting,
    CountingOptions as CountingOptions,
    UsedCycles as UsedCycles,
    cycles_of_all_poses as cycles_of_all_poses,
    used_cycles as used_cycles,
)
from .core.drift import (
    DRIFT_CODES as DRIFT_CODES,
    DriftCourse as DriftCourse,
    block_of_rows as block_of_rows,
)
from .core.figures import (
    EVERY_LENGTH as EVERY_LENGTH,
    AxisResult as AxisResult,
    Conformity as Conformity,
    DecisionRule as DecisionRule,
    Limit as Limit,
    Millimetres as Millimetres,
    PlaneResult as PlaneResult,
    PoseResult as PoseResult,
    Poses as Poses,
    RadialResult as RadialResult,
)
from .core.limits import (
    MOST_CYCLES as MOST_CYCLES,
    check_limits as check_limits,
    limit_of_plane as limit_of_plane,
)
from .core.results import (
    Analysis as Analysis,
    Characteristic as Characteristic,
    Cycles as Cycles,
    Finding as Finding,
    LimitCheck as LimitCheck,
    Measured as Measured,
    Severity as Severity,
    WholeAnalysis as WholeAnalysis,
    arrivals_by_pose as arrivals_by_pose,
    each_axis as each_axis,
    gravest as gravest,
    poses_in_cycles as poses_in_cycles,
)
from .core.slips import copied_in as copied_in, exchanged_in as exchanged_in
from .core.statistics import (
    FEWEST_FOR_INTERVAL as FEWEST_FOR_INTERVAL,
    GAUSSIAN_ERROR as GAUSSIAN_ERROR,
    GAUSSIAN_RP as GAUSSIAN_RP,
    components as components,
    hidden as hidden,
    median as median,
    position_estimate as position_estimate,
    repeatability as repeatability,
    standard_deviation as standard_deviation,
    two_divisions as two_divisions,
)
from .poses import (
    CYCLES as CYCLES,
    DiagonalPlane as DiagonalPlane,
    PlannedPose as PlannedPose,
    PlannedVisit as PlannedVisit,
    PosePlan as PosePlan,
    PoseTestConditions as PoseTestConditions,
    Solid as Solid,
    make_plan as make_plan,
    planned_poses as planned_poses,
    planned_visits as planned_visits,
)
from .pushed_joint import PushResult as PushResult, push_test as push_test
from .transients import (
    StreamVisits as StreamVisits,
    with_arrivals as with_arrivals,
)
