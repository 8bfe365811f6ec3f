"""The poses of a model file: `[pose]` of a single table, `[pose.P1]` and so on of a test."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scara_iso.errors import UsageError
from scara_iso.robot.arm import Arm, Elbow
from scara_iso.toml_keys import KeyFaults, number_at, only, pair

Joints = tuple[float, float]
"""Joints 1 and 2 in degrees."""

_KEYS = ("joint_deg", "x_mm", "y_mm", "elbow")


def poses_of(
    section: Mapping[str, Any], arm: Arm | None, faults: KeyFaults
) -> tuple[Joints | None, dict[str, Joints]]:
    """Return the joints of the single pose, None where it is not given, and of each named one.

    What is wrong goes to ``faults``.
    """
    named = {name: entry for name, entry in section.items() if _is_pose(name, entry)}
    own = {key: value for key, value in section.items() if key not in named}
    found = {name: _joints(entry, f"pose.{name}", arm, faults) for name, entry in named.items()}
    poses = {name: joints for name, joints in found.items() if joints is not None}
    return (_joints(own, "pose", arm, faults) if own else None), poses


def _is_pose(name: str, entry: object) -> bool:
    return isinstance(entry, dict) and name not in _KEYS


def _joints(
    pose: Mapping[str, Any], where: str, arm: Arm | None, faults: KeyFaults
) -> Joints | None:
    only(pose, set(_KEYS), where, faults)
    if pose.get("elbow", "right") not in ("left", "right"):
        faults.add(f"{where}.elbow", f"{repr(pose['elbow'])[:40]}: right or left")
    if "joint_deg" in pose:
        if len(pose) > 1:
            faults.add(where, "give either joint_deg, or x_mm and y_mm")
        return _within(pair(pose, "joint_deg", where, faults), where, arm, faults)
    x, y = (number_at(pose, key, where, faults) for key in ("x_mm", "y_mm"))
    if x is None or y is None:
        faults.add(where, "give joint_deg, or x_mm and y_mm")
        return None
    if arm is None:
        faults.add(where, "x_mm and y_mm need the link lengths of robot")
        return None
    elbow = Elbow.LEFT if pose.get("elbow") == "left" else Elbow.RIGHT
    try:
        joints = arm.inverse([x, y], elbow=elbow)
    except UsageError as error:
        faults.add(where, error.what)
        return None
    return float(joints[0]), float(joints[1])


def _within(joints: Joints, where: str, arm: Arm | None, faults: KeyFaults) -> Joints:
    for k, over in enumerate([] if arm is None else arm.excess(joints).tolist(), 1):
        if over > 0:
            faults.add(f"{where}.joint_deg", f"joint {k} is {over:g} deg outside its limits")
    return joints
