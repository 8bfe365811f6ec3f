"""Scatter of several poses traced to the joints, and RP where nobody measured."""

from scara_iso.diagnosis.joint_scatter.from_run import joint_scatter
from scara_iso.diagnosis.joint_scatter.in_loop import with_joint_scatter
from scara_iso.diagnosis.joint_scatter.poses import (
    PLANE,
    ScatterAtPose,
    trace_poses,
    trace_to_joints,
)
from scara_iso.diagnosis.joint_scatter.reach import reach_map
from scara_iso.diagnosis.joint_scatter.result import (
    FollowedInJoints,
    JointCorrelation,
    JointScatter,
    PoseLeftOut,
    PredictedRP,
    ReachMap,
    SizeInJoint,
    SourceOfScatter,
)

__all__ = [
    "PLANE",
    "FollowedInJoints",
    "JointCorrelation",
    "JointScatter",
    "PoseLeftOut",
    "PredictedRP",
    "ReachMap",
    "ScatterAtPose",
    "SizeInJoint",
    "SourceOfScatter",
    "joint_scatter",
    "reach_map",
    "trace_poses",
    "trace_to_joints",
    "with_joint_scatter",
]
