"""Close the loop: what a model leaves unexplained in a run, and which effect it is.

`close_the_loop` gives table and model to `diagnose`; `gears` is the same loop on eq. 16.

Every level, prior and threshold stands where it is used, with what chose it. One table of
``benchmarks/diagnosis.py`` is meant where only a table is named; its figures stand in
benchmarks/results/diagnosis.md, section 8, those of ``benchmarks/gear.py`` in section 5. The
weights of single effects, chosen on the tables *naming* (prior) and *power* (test), stand in their
files.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.diagnosis.closed_loop import (
        close_the_loop as close_the_loop,
        finer as finer,
        save_model as save_model,
        screen as screen,
    )
    from scara_iso.diagnosis.engine.hypotheses import ODD as ODD, SIZE_AT as SIZE_AT
    from scara_iso.diagnosis.engine.order import PERMUTATIONS as PERMUTATIONS
    from scara_iso.diagnosis.engine.residual import (
        AllPoses as AllPoses,
        CyclesWanted as CyclesWanted,
        whole_cycles as whole_cycles,
    )
    from scara_iso.diagnosis.engine.search import floor_of as floor_of
    from scara_iso.diagnosis.gears import diagnose_sweep as diagnose_sweep
    from scara_iso.diagnosis.joint_scatter import with_joint_scatter as with_joint_scatter
    from scara_iso.diagnosis.live import ALARM as ALARM, Monitor as Monitor
    from scara_iso.diagnosis.planning import (
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
    from scara_iso.diagnosis.poses import (
        close_the_loop_at_poses as close_the_loop_at_poses,
        diagnose_poses as diagnose_poses,
    )
    from scara_iso.diagnosis.poses_result import (
        DiagnosisOfPoses as DiagnosisOfPoses,
        FollowedInJoints as FollowedInJoints,
        JointScatter as JointScatter,
        PoseLeftOut as PoseLeftOut,
        ReachMap as ReachMap,
        SourceOfScatter as SourceOfScatter,
    )
    from scara_iso.diagnosis.result import (
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
    from scara_iso.diagnosis.separating import (
        GIVEN as GIVEN,
        PROPOSED as PROPOSED,
        STANDARD as STANDARD,
        PosesApart as PosesApart,
        SeparatingPlan as SeparatingPlan,
        separating_plan as separating_plan,
    )
    from scara_iso.diagnosis.sweeps import (
        BacklashResult as BacklashResult,
        GearDiagnosis as GearDiagnosis,
        Reversal as Reversal,
        RunReversals as RunReversals,
        read_sweep as read_sweep,
    )
    from scara_iso.diagnosis.verdict import (
        FEWEST_CYCLES as FEWEST_CYCLES,
        LEVEL as LEVEL,
        MOST_CYCLES as MOST_CYCLES,
        SEED as SEED,
        UNKNOWN as UNKNOWN,
        Rival as Rival,
        Verdict as Verdict,
        Watched as Watched,
    )
else:
    __getattr__ = face(__name__)
