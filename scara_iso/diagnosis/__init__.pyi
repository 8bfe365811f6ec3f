from .closed_loop import (
    close_the_loop as close_the_loop,
    finer as finer,
    save_model as save_model,
    screen as screen,
)
from .engine.hypotheses import ODD as ODD, SIZE_AT as SIZE_AT
from .engine.order import PERMUTATIONS as PERMUTATIONS
from .engine.residual import (
    AllPoses as AllPoses,
    CyclesWanted as CyclesWanted,
    whole_cycles as whole_cycles,
)
from .engine.search import floor_of as floor_of
from .gears import diagnose_sweep as diagnose_sweep
from .joint_scatter import with_joint_scatter as with_joint_scatter
from .live import ALARM as ALARM, Monitor as Monitor
from .planning import (
    Alike as Alike,
    ChangeOfPoses as ChangeOfPoses,
    Design as Design,
    DesignOfPoses as DesignOfPoses,
    PlannedPosesTest as PlannedPosesTest,
    PlannedRun as PlannedRun,
    Travels as Travels,
    design as design,
    design_of_poses as design_of_poses,
    like_test as like_test,
    planned_columns as planned_columns,
)
from .poses import (
    close_the_loop_at_poses as close_the_loop_at_poses,
    diagnose_poses as diagnose_poses,
)
from .poses_result import (
    DiagnosisOfPoses as DiagnosisOfPoses,
    FollowedInJoints as FollowedInJoints,
    JointScatter as JointScatter,
    PoseLeftOut as PoseLeftOut,
    ReachMap as ReachMap,
    SourceOfScatter as SourceOfScatter,
)
from .result import (
    SECOND as SECOND,
    ByAxis as ByAxis,
    Diagnosis as Diagnosis,
    Foretold as Foretold,
    Found as Found,
    FoundAtPoses as FoundAtPoses,
    ParameterValue as ParameterValue,
    Repeatabilities as Repeatabilities,
    Series as Series,
    UnseenRP as UnseenRP,
)
from .separating import (
    GIVEN as GIVEN,
    PROPOSED as PROPOSED,
    STANDARD as STANDARD,
    PosesApart as PosesApart,
    SeparatingPlan as SeparatingPlan,
    separating_plan as separating_plan,
)
from .sweeps import (
    BacklashResult as BacklashResult,
    GearDiagnosis as GearDiagnosis,
    Reversal as Reversal,
    RunReversals as RunReversals,
    read_sweep as read_sweep,
)
from .verdict import (
    FEWEST_CYCLES as FEWEST_CYCLES,
    LEVEL as LEVEL,
    MOST_CYCLES as MOST_CYCLES,
    SEED as SEED,
    UNKNOWN as UNKNOWN,
    Rival as Rival,
    Verdict as Verdict,
    Watched as Watched,
)
