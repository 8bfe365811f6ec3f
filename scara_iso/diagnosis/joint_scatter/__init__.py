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

__all__ = [
    "PLANE",
    "ScatterAtPose",
    "joint_scatter",
    "reach_map",
    "trace_poses",
    "trace_to_joints",
    "with_joint_scatter",
]
