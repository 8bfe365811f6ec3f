"""Which pictures a report shows, and what is to be seen in each: all poses on one scale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeVar

import numpy as np

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import Analysis, PoseResult
from scara_iso.reporting.blocks import (
    Block,
    Course,
    Courses,
    Figure,
    Plane,
    Planes,
    Prediction,
    Predictions,
)
from scara_iso.reporting.digits import U_of_mean, U_of_RP, U_of_scatter, rounded
from scara_iso.run import IntArray

Panel = TypeVar("Panel")
_PANELS = 30
"""Of one picture: six rows of five fill half a page."""


def courses(analysis: Analysis) -> Iterator[Block]:
    """Yield the readings of each axis over the cycles, with those that are discarded."""
    rows = dict(analysis.run.rows_by_pose())
    for name, axis in analysis.run.axes.items():
        panels = [_course(analysis, pose, name, rows[pose.label]) for pose in analysis.poses]
        span = max(float(np.abs(one.readings - one.mean).max()) for one in panels)
        step = (
            "resolution not stated"
            if axis.resolution is None
            else f"band: one step of the dial, {axis.resolution:g} {axis.unit}, about the mean"
        )
        hollow = "; hollow: discarded" if any(len(one.discarded) for one in panels) else ""
        for some in _by_page(panels):
            yield Figure(
                Courses(name, axis.unit, some, span),
                f"{name} over the cycles",
                f"dashed: mean{_mean(analysis.poses, name)}; {step}{hollow}",
            )


def _course(analysis: Analysis, pose: PoseResult, name: str, rows: IntArray) -> Course:
    axis, run = pose.axes[name], analysis.run
    left_out = np.setdiff1d(rows, pose.rows)
    return Course(
        pose.label,
        pose.cycle,
        axis.readings,
        axis.mean,
        axis.resolution,
        run.cycle[left_out],
        run.axes[name].readings[left_out],
    )


def _by_page(panels: Sequence[Panel]) -> Iterator[tuple[Panel, ...]]:
    for k in range(0, len(panels), _PANELS):
        yield tuple(panels[k : k + _PANELS])


def _mean(poses: Sequence[PoseResult], name: str) -> str:
    if len(poses) > 1:
        return " of the pose"
    axis = poses[0].axes[name]
    return f" {rounded(axis.mean, U_of_mean(axis))} {axis.unit}"


def planes(analysis: Analysis) -> Iterator[Block]:
    """Yield the attained places in the XY plane, where X and Y are lengths.

    Where X and Y come from runs of their own, no pair of them was attained together.
    """
    separate = any(found.code == "separate-axes" for found in analysis.findings)
    panels = [_plane(pose, pose.XY.RP) for pose in analysis.poses if pose.XY is not None]
    if not panels:
        return
    span = max(
        max(one.RP, float(np.abs(one.positions - one.barycentre[:, None]).max())) for one in panels
    )
    for some in _by_page(panels):
        yield Figure(
            Planes(some, span),
            "X and Y of separate runs" if separate else "Attained places in the XY plane",
            f"cross: barycentre; circle: RP{_radius(analysis.poses)} about it (ISO 9283, 7.2.2); "
            "larger marks: several cycles at one place"
            + ("; X and Y of a cycle were not attained together" if separate else ""),
        )


def _plane(pose: PoseResult, RP: float) -> Plane:
    axes = [pose.axes["X"], pose.axes["Y"]]
    return Plane(
        pose.label,
        np.stack([axis.readings for axis in axes]),
        np.array([axis.mean for axis in axes]),
        RP,
    )


def _radius(poses: Sequence[PoseResult]) -> str:
    if len(poses) > 1 or poses[0].XY is None:
        return ""
    return f" = {rounded(poses[0].XY.RP, U_of_RP(poses[0].XY, len(poses[0].rows)))} mm"


def predictions(
    diagnoses: Mapping[str | None, Diagnosis], poses: Sequence[PoseResult]
) -> Iterator[Block]:
    """Yield readings with predictions, for the axes on which a diagnosis changed the model."""
    for name, axis in poses[0].axes.items():
        changed = [
            (pose, diagnoses[pose.label])
            for pose in poses
            if pose.label in diagnoses and _changed(diagnoses[pose.label], name)
        ]
        panels = [_prediction(pose.label, found, name) for pose, found in changed]
        span = max((float(np.ptp(one.measured)) for one in panels), default=0.0)
        said = _rms(changed[0][1], name, axis.unit) if len(changed) == 1 else ""
        for some in _by_page(panels):
            yield Figure(
                Predictions(name, axis.unit, some, span),
                f"{name} before and after the diagnosis",
                f"dashed: predicted before; solid: after{said}",
            )


def _changed(found: Diagnosis, name: str) -> bool:
    """Return whether an axis is predicted otherwise; one that follows another has no error."""
    if name not in found.error_after.rms:
        return False
    before, after = found.series.predicted_before[name], found.series.predicted_after[name]
    return not np.allclose(before, after, rtol=0, atol=1e-12)


def _prediction(label: str | None, found: Diagnosis, name: str) -> Prediction:
    series = found.series
    before, after = series.predicted_before[name], series.predicted_after[name]
    return Prediction(label, series.cycle, series.measured[name], before, after)


def _rms(found: Diagnosis, name: str, unit: str) -> str:
    n = len(found.series.cycle)
    rms = [error.rms[name] for error in (found.error_before, found.error_after)]
    before, after = (rounded(x, U_of_scatter(x, n)) for x in rms)
    return f"; rms of measured minus predicted: {before} {unit} before, {after} {unit} after"
