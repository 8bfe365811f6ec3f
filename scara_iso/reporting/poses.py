"""The figures of several poses side by side: one row a pose."""

from __future__ import annotations

from collections.abc import Sequence

from scara_iso.iso9283 import AxisResult, PoseResult
from scara_iso.reporting.blocks import Cell, Table
from scara_iso.reporting.digits import U_of_scatter, interval, rounded
from scara_iso.reporting.uncertainty import U_of_mean, U_of_RP


def poses_table(poses: Sequence[PoseResult]) -> Table:
    """Return RP of every axis and plane of each pose, and AP where every pose has one."""
    columns = [_column(poses, name) for name in poses[0].axes]
    columns += [*_plane(poses), *_accuracy(poses)]
    rows = zip(
        [pose.label or "" for pose in poses],
        [len(pose.rows) for pose in poses],
        *(cells for _, cells in columns),
        strict=True,
    )
    units = {axis.unit for axis in poses[0].axes.values()}
    note = f"RP in mm{', of an angle ± 3 s in deg' if 'deg' in units else ''}"
    return Table(("pose", "n", *(name for name, _ in columns)), tuple(rows), note)


_Column = tuple[str, list[Cell]]


def _column(poses: Sequence[PoseResult], name: str) -> _Column:
    return name, [_figure(pose.axes[name]) for pose in poses]


def _figure(axis: AxisResult) -> Cell:
    if axis.unit == "deg":
        return rounded(axis.three_sigma, U_of_scatter(axis.three_sigma, axis.n))
    return rounded(axis.RP, U_of_RP(axis, axis.n))


def _plane(poses: Sequence[PoseResult]) -> list[_Column]:
    """Return RP in XY with its interval; without a plane, the interval of the only axis."""
    planes = [(pose.XY, len(pose.rows)) for pose in poses if pose.XY is not None]
    if len(planes) == len(poses):
        ends: list[Cell] = [interval(XY.RP_interval) for XY, _ in planes]
        return [
            ("XY radial", [rounded(XY.RP, U_of_RP(XY, n)) for XY, n in planes]),
            ("95 % interval", ends),
        ]
    axes = [axis for pose in poses for axis in pose.axes.values()]
    if len(axes) > len(poses):
        return []
    found = [a.three_sigma_interval if a.unit == "deg" else a.RP_interval for a in axes]
    return [("95 % interval", [interval(one) for one in found])]


def _accuracy(poses: Sequence[PoseResult]) -> list[_Column]:
    found = [
        rounded(pose.XY.accuracy, max(U_of_mean(pose.axes[axis]) for axis in "XY"))
        for pose in poses
        if pose.XY is not None and pose.XY.accuracy is not None
    ]
    return [("AP XY", [*found])] if len(found) == len(poses) else []
