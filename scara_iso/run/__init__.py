"""The one type that all rooms share: readings by cycle and axis, what else a row tells, their dial.

A recording, a table and a model give the same `Run`.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.run.axis import (
        AXES as AXES,
        FARTHEST as FARTHEST,
        Axis as Axis,
        AxisKey as AxisKey,
        Commanded as Commanded,
        Correction as Correction,
        FloatArray as FloatArray,
        IntArray as IntArray,
        beyond_dials as beyond_dials,
        common_step as common_step,
        joined_axis as joined_axis,
        seen_step as seen_step,
        step_of as step_of,
    )
    from scara_iso.run.columns import (
        CONDITIONS as CONDITIONS,
        FEW_LEVELS as FEW_LEVELS,
        POSE_NAMES as POSE_NAMES,
        UNITS as UNITS,
        RecordedCondition as RecordedCondition,
        arrival_labels as arrival_labels,
        by_pose as by_pose,
        check_clusters as check_clusters,
        coded as coded,
        declared_conditions as declared_conditions,
        find_condition as find_condition,
        is_transient as is_transient,
        no_such_pose as no_such_pose,
        number_cycles as number_cycles,
        overshoot_column as overshoot_column,
        parted_by as parted_by,
        read_direction as read_direction,
        stabilisation_column as stabilisation_column,
        unit_in_heading as unit_in_heading,
        unit_of_condition as unit_of_condition,
    )
    from scara_iso.run.frames import (
        FRAME as FRAME,
        frame_of as frame_of,
        is_frame as is_frame,
        make_frame as make_frame,
        stacked as stacked,
    )
    from scara_iso.run.runs import (
        SEPARATOR as SEPARATOR,
        Origin as Origin,
        Run as Run,
        TableField as TableField,
        copies as copies,
    )
else:
    __getattr__ = face(__name__)
