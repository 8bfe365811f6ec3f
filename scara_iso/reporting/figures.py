"""Which pictures a report shows, and what is to be seen in each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import PoseResult
from scara_iso.reporting.blocks import Block, Course, Figure, Plane, Prediction, Text
from scara_iso.reporting.digits import U_of_scatter, rounded
from scara_iso.reporting.uncertainty import U_of_mean, U_of_RP


def courses(pose: PoseResult) -> Iterator[Block]:
    """Yield the readings of each axis over the cycles."""
    for axis in pose.axes.values():
        step = (
            "resolution not stated"
            if axis.resolution is None
            else f"band: one step of the dial, {axis.resolution:g} {axis.unit}, about the mean"
        )
        yield Figure(
            Course(axis.name, axis.unit, pose.cycle, axis.readings, axis.mean, axis.resolution),
            f"{axis.name} over the cycles",
            f"dashed: mean {rounded(axis.mean, U_of_mean(axis))} {axis.unit}; {step}",
        )


def plane(pose: PoseResult, *, separate: bool) -> Iterator[Block]:
    """Yield the attained places in the XY plane, where X and Y are lengths.

    ``separate``: X and Y come from runs of their own, and no pair of them was attained together.
    """
    if pose.XY is None:
        return
    axes = [pose.axes["X"], pose.axes["Y"]]
    RP = rounded(pose.XY.RP, U_of_RP(pose.XY, len(pose.rows)))
    yield Figure(
        Plane(
            np.stack([axis.readings for axis in axes]),
            np.array([axis.mean for axis in axes]),
            pose.XY.RP,
        ),
        "X and Y of separate runs" if separate else "Attained places in the XY plane",
        f"cross: barycentre; circle: RP = {RP} mm about it (ISO 9283, 7.2.2); "
        "larger marks: several cycles at one place"
        + ("; X and Y of a cycle were not attained together" if separate else ""),
    )


def predictions(diagnosis: Diagnosis, pose: PoseResult) -> Iterator[Block]:
    """Yield readings with predictions, for the axes on which the diagnosis changed the model."""
    series, found = diagnosis.series, False
    for axis, measured in series.measured.items():
        before, after = series.predicted_before[axis], series.predicted_after[axis]
        if np.allclose(before, after, rtol=0, atol=1e-12):
            continue
        found = True
        rms = [error.rms[axis] for error in (diagnosis.error_before, diagnosis.error_after)]
        said, unit = [rounded(x, U_of_scatter(x, len(measured))) for x in rms], pose.axes[axis].unit
        yield Figure(
            Prediction(axis, unit, series.cycle, measured, before, after),
            f"{axis} before and after the diagnosis",
            f"rms of measured minus predicted: {said[0]} {unit} before (dashed), "
            f"{said[1]} {unit} after (solid)",
        )
    if not found:
        yield Text("no picture: the model says the same before and after", "quiet")
