"""Which pictures a report shows, all poses on one scale; a drift test in words and as a picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import Analysis, Characteristic, PoseResult
from scara_iso.reporting.blocks import (
    Block,
    Figure,
    Headline,
    Number,
    Section,
    Strip,
    Table,
    Text,
    U_of_mean,
    U_of_RP,
    U_of_scatter,
    rounded,
)
from scara_iso.reporting.picture_data import (
    Course,
    Courses,
    DriftPicture,
    Plane,
    Planes,
    Prediction,
    Predictions,
)
from scara_iso.run import IntArray

if TYPE_CHECKING:
    from scara_iso.iso9283 import DriftCourse


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
        text = _rms(changed[0][1], name, axis.unit) if len(changed) == 1 else ""
        for some in _by_page(panels):
            yield Figure(
                Predictions(name, axis.unit, some, span),
                f"{name} before and after the diagnosis",
                f"dashed: predicted before; solid: after{text}",
            )


def _changed(found: Diagnosis, name: str) -> bool:
    """Return whether an axis is predicted otherwise; one that follows another has no error."""
    if name not in found.error.after.rms:
        return False
    before, after = found.series.predicted_before[name], found.series.predicted_after[name]
    return not np.allclose(before, after, rtol=0, atol=1e-12)


def _prediction(label: str | None, found: Diagnosis, name: str) -> Prediction:
    series = found.series
    before, after = series.predicted_before[name], series.predicted_after[name]
    return Prediction(label, series.cycle, series.measured[name], before, after)


def _rms(found: Diagnosis, name: str, unit: str) -> str:
    n = len(found.series.cycle)
    rms = [error.rms[name] for error in (found.error.before, found.error.after)]
    before, after = (rounded(x, U_of_scatter(x, n)) for x in rms)
    return f"; rms of measured minus predicted: {before} {unit} before, {after} {unit} after"


_WHOLE = ("XYZ", "XY")


def drift_details(analysis: Analysis) -> Iterator[Section]:
    """Yield when each pose of a drift test is steady, and the means of its blocks."""
    for course in analysis.drift or ():
        label = course.pose.label or ""
        name = f"pose {label}: " if label else ""
        yield Section(f"{name}drift by block", (Text(_steady(course)), _table(course)), label)


def drift_headlines(analysis: Analysis) -> Iterator[Headline]:
    """Yield how far each pose moves, and when it is steady."""
    for course in analysis.drift or ():
        yield Headline(tuple(_moved(analysis, course)))
        steady, _, constant = _steady(course).partition(": ")
        yield Headline((steady, *filter(None, [constant])), "plain")


def _moved(analysis: Analysis, course: DriftCourse) -> list[str]:
    label = course.pose.label
    mine = [one for one in analysis.characteristics if one.pose == label]
    figures = [largest_of(mine, code) for code in ("dAP", "dRP")]
    moved = [_in_words(one) for one in figures if one is not None]
    return [f"drift{'' if label is None else f' at {label}'}: {', '.join(moved[:1])}", *moved[1:]]


def drift_sections(analysis: Analysis) -> Iterator[Section]:
    """Yield for each pose the course as strips, and block by block."""
    for course in analysis.drift or ():
        label = course.pose.label or ""
        name = f"pose {label}: " if label else ""
        strips = tuple(_strips(course))
        yield Section(f"{name}means of the blocks", strips, label)


def drift_pictures(analysis: Analysis) -> Iterator[Section]:
    """Yield for each pose the picture of its course, and the table of its blocks."""
    for course in analysis.drift or ():
        label = course.pose.label
        blocks: list[Block] = [Text(_steady(course)), *_picture(course), _table(course)]
        yield Section("Drift" if label is None else f"Drift at pose {label}", tuple(blocks))


def largest_of(found: Sequence[Characteristic], code: str) -> Characteristic | None:
    """Return the figure in space or in the plane, else the largest of an axis."""
    mine = {one.of: one for one in found if one.code == code}
    whole = next((mine[of] for of in _WHOLE if of in mine), None)
    return whole or max(mine.values(), key=lambda one: one.estimate.value, default=None)


def _in_words(one: Characteristic) -> str:
    estimate, ends = one.estimate, one.estimate.interval
    U = 0.0 if ends is None else (ends[1] - ends[0]) / 2
    between = "" if ends is None else f" [{rounded(ends[0], U)}, {rounded(ends[1], U)}]"
    return f"{one.code} of {one.of} {rounded(estimate.value, U)}{between} {estimate.unit}"


def _steady(course: DriftCourse) -> str:
    fit = course.fit
    if course.hours is None:
        return "no times are stated: no time constant is fitted"
    if fit is None:
        return "no drift beyond chance is seen between the blocks, or they are fewer than six"
    low, high = fit.interval_h
    tau, U = fit.time_constant_h, ((high or 3 * fit.time_constant_h) - low) / 2
    constant = f"time constant {rounded(tau, U)} h [{rounded(low, U)}, {_end(high, U)}]"
    ends = fit.steady_interval_h
    if not fit.steady or ends is None:
        return f"not steady within {fit.hours[-1]:.3g} h: {constant}, from a fit that looks ahead"
    U = (ends[1] - ends[0]) / 2
    steady, *text = (rounded(hours, U) for hours in (fit.steady_after_h, *ends))
    return f"steady after {steady} h [{text[0]}, {text[1]}]: a tenth is left then; {constant}"


def _end(hours: float | None, U: float) -> Number | str:
    return "not bounded" if hours is None else rounded(hours, U)


def _strips(course: DriftCourse) -> Iterator[Block]:
    blocks = np.arange(1, len(course.visits) + 1)
    for name, means in course.means.items():
        unit = course.pose.axes[name].unit
        moved = means[-1] - means[0]
        U = max(float(np.ptp(means)) / 10, 1e-9)
        caption = f"block 1 to {len(blocks)}: {rounded(moved, U, sign='+')} {unit}"
        yield Strip(name, blocks, means, caption)


def _table(course: DriftCourse) -> Table:
    names = list(course.means)
    units = [course.pose.axes[name].unit for name in names]
    hours = course.hours
    rows = []
    for k, visits in enumerate(course.visits):
        time = "" if hours is None else Number(float(hours[k]), ".2f")
        means = [Number(float(course.means[name][k]), ".5f") for name in names]
        rows.append((Number(k + 1), time, Number(len(visits)), *means))
    header = (
        "block",
        "hours",
        "visits",
        *(f"{n} [{u}]" for n, u in zip(names, units, strict=True)),
    )
    return Table(header, tuple(rows), "means of the visits; hours from the first visit")


def _picture(course: DriftCourse) -> Iterator[Block]:
    if course.hours is None:
        return

    lengths = [name for name, axis in course.pose.axes.items() if axis.unit == "mm"]
    moved = {name: course.means[name] - course.means[name][0] for name in lengths}
    fit = course.fit
    fitted = {} if fit is None else {n: fit.fitted[n] - course.means[n][0] for n in lengths}
    steady = fit.steady_interval_h if fit is not None and fit.steady else None
    yield Figure(
        DriftPicture(
            course.hours,
            moved,
            fitted,
            None if fit is None or steady is None else (steady[0], fit.steady_after_h, steady[1]),
        ),
        "Course of the drift",
        "points: mean of each block minus that of the first; "
        + ("lines: the fitted exponential; " if fitted else "no drift beyond chance is fitted; ")
        + ("band: where it is steady, with its 95 % interval" if steady else "not steady yet"),
    )
