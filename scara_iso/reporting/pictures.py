"""Every picture of a document, as data: what a drawing shows of a result.

Of several poses each is a panel, all on one scale, about its mean.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from scara_iso.comparison import (
    Comparison,
    Contrast,
    MeanHistory,
    Pair,
    RobotHistory,
    SpreadHistory,
    day_of,
)
from scara_iso.diagnosis import Diagnosis, DiagnosisOfPoses, Series
from scara_iso.gauge import AxisStudy, Crossed, Linearity, Stability, TypeOne
from scara_iso.iso9283 import Analysis, PoseResult, PushResult
from scara_iso.reporting.comparison import CHANGED, figure_name
from scara_iso.reporting.shared.blocks import Block, Curve, Figure, Hue, Look, Panel, Section, Text
from scara_iso.reporting.shared.digits import U_of_mean, of_scatter, result, rounded
from scara_iso.reporting.shared.figures import blocks_table, steady_in_words
from scara_iso.run import FloatArray

if TYPE_CHECKING:
    from scara_iso.iso9283 import DriftCourse

_PANELS = 30
"""Of one picture: six rows of five fill half a page."""
_HUES: tuple[Hue, ...] = ("ink", "blue", "orange")
_MOST_PAIRS, _LONGEST_NAME = 8, 28
_AHEAD = 0.5
"""Spans of the tests that a picture of months goes on for."""


def _by_page(figure: Figure) -> Iterator[Figure]:
    for k in range(0, len(figure.panels), _PANELS):
        yield replace(figure, panels=figure.panels[k : k + _PANELS])


def courses(analysis: Analysis) -> Iterator[Block]:
    """Yield the readings of each axis over the cycles, with those that are discarded."""
    poses, rows = analysis.poses, dict(analysis.run.rows_by_pose())
    many = len(poses) > 1
    left_out = {pose.label: np.setdiff1d(rows[pose.label], pose.rows) for pose in poses}
    for name, axis in analysis.run.axes.items():
        step, found = axis.resolution or 0.0, [pose.axes[name] for pose in poses]
        span = max(float(np.abs(one.readings - one.mean).max()) for one in found)
        reach = 1.15 * max(span, step / 2, 1e-9)
        cycles = analysis.run.cycle.astype(float)
        discarded = [(cycles[at], axis.readings[at]) for at in left_out.values()]
        panels = tuple(
            _course(pose, name, at, reach, about_mean=many)
            for pose, at in zip(poses, discarded, strict=True)
        )
        middle = 0.0 if many else found[0].mean
        mean = "of the pose" if many else rounded(middle, U_of_mean(found[0]), unit=axis.unit)
        band = f"band: one step of the dial, {step:g} {axis.unit}, about the mean"
        hollow = "; hollow: discarded" if any(map(len, left_out.values())) else ""
        label = f"{name}{' - mean' if many else ''} [{axis.unit}]"
        caption = f"dashed: mean {mean}; {band if step else 'resolution not stated'}{hollow}"
        ends = (middle - reach, middle + reach)
        title = f"{name} over the cycles"
        yield from _by_page(Figure(title, caption, "cycle", label, panels, y_limits=ends))


def _course(
    pose: PoseResult,
    name: str,
    discarded: tuple[FloatArray, FloatArray],
    reach: float,
    *,
    about_mean: bool,
) -> Panel:
    """Return the readings of a pose, those that are discarded moved to the edge of the picture."""
    axis, (cycle, readings) = pose.axes[name], discarded
    about = axis.mean if about_mean else 0.0
    middle, off = axis.mean - about, readings - axis.mean
    kept = np.clip(off, -0.94 * reach, 0.94 * reach)
    sides: tuple[Look, ...] = ("below", "hollow", "above")
    left_out = [
        Curve("", cycle[at], middle + kept[at], look, "ink")
        for look, side in zip(sides, (-1, 0, 1), strict=True)
        if (at := np.sign(off - kept) == side).any()
    ]
    half = None if axis.resolution is None else axis.resolution / 2
    return Panel(
        pose.label or "",
        (Curve("", pose.cycle.astype(float), axis.readings - about, "joined", "ink"), *left_out),
        {"": middle},
        across=None if half is None else (middle - half, middle + half),
    )


def planes(analysis: Analysis) -> Iterator[Block]:
    """Yield the attained places in the XY plane, where X and Y are lengths.

    Where X and Y come from runs of their own, no pair of them was attained together.
    """
    separate = any(found.code == "separate-axes" for found in analysis.findings)
    poses = [(pose, pose.XY) for pose in analysis.poses if pose.XY is not None]
    if not poses:
        return
    axes = [[pose.axes["X"], pose.axes["Y"]] for pose, _ in poses]
    spans = [np.abs(one.readings - one.mean).max() for both in axes for one in both]
    reach = 1.1 * max(*(XY.RP for _, XY in poses), *map(float, spans), 1e-9)
    many, turn = len(analysis.poses) > 1, np.linspace(0, 2 * np.pi, 121)
    panels = []
    for (pose, XY), (x, y) in zip(poses, axes, strict=True):
        means = np.array([x.mean, y.mean])
        middle = means - means if many else means
        places, counts = np.unique(
            np.stack([x.readings, y.readings]).round(9), axis=1, return_counts=True
        )
        places = places - means[:, None] + middle[:, None]
        circle = middle[:, None] + XY.RP * np.stack([np.cos(turn), np.sin(turn)])
        curves = (
            Curve("", circle[0], circle[1], "line", "blue"),
            Curve("", places[0], places[1], "points", "orange", counts=counts.astype(float)),
            Curve("", middle[:1], middle[1:], "cross", "blue"),
        )
        panels.append(Panel(pose.label or "", curves))
    minus = " - mean" if many else ""
    x_limits, y_limits = ((float(m) - reach, float(m) + reach) for m in middle)
    _, XY = poses[0]
    radius = "" if many else f" = {result(XY.RP, XY.RP_interval, 'mm').value}"
    apart = "; X and Y of a cycle were not attained together" if separate else ""
    title = "X and Y of separate runs" if separate else "Attained places in the XY plane"
    caption = (
        f"cross: barycentre; circle: RP{radius} about it (ISO 9283, 7.2.2); "
        f"larger marks: several cycles at one place{apart}"
    )
    scales = f"X{minus} [mm]", f"Y{minus} [mm]"
    yield from _by_page(
        Figure(title, caption, *scales, tuple(panels), x_limits, y_limits, square=True)
    )


def predictions(
    diagnoses: Mapping[str | None, Diagnosis], poses: Sequence[PoseResult]
) -> Iterator[Block]:
    """Yield readings with predictions, for the axes on which a diagnosis changed the model."""
    for name, axis in poses[0].axes.items():
        found = [(pose.label, diagnoses.get(pose.label)) for pose in poses]
        changed = [(label, one) for label, one in found if one and _is_changed(one, name)]
        many = len(changed) > 1
        panels = [
            Panel(label or "", _predicted(one.series, name, about_mean=many))
            for label, one in changed
        ]
        text = _rms(changed[0][1], name, axis.unit) if changed and not many else ""
        label = f"{name}{' - mean' if many else ''} [{axis.unit}]"
        title = f"{name} before and after the diagnosis"
        caption = f"dashed: predicted before; solid: after{text}"
        yield from _by_page(Figure(title, caption, "cycle", label, tuple(panels)))


def _predicted(series: Series, name: str, *, about_mean: bool) -> tuple[Curve, ...]:
    cycle, measured = series.cycle.astype(float), series.measured[name]
    about = float(measured.mean()) if about_mean else 0.0
    return (
        Curve("measured", cycle, measured - about, "points", "ink"),
        Curve("before", cycle, series.predicted_before[name] - about, "dashed", "blue"),
        Curve("after", cycle, series.predicted_after[name] - about, "line", "orange"),
    )


def diagnosis_pictures(found: Diagnosis | DiagnosisOfPoses) -> Iterator[Figure]:
    """Yield readings with predictions, and what is left, of each axis at each pose."""
    caption = "left: dashed before, solid after; right: hollow before, full after [mm or deg]"
    for pose, one in ({"": found} if isinstance(found, Diagnosis) else found.poses).items():
        series, learned = one.series, {} if one.learned is None else one.learned.axes
        for name, measured in series.measured.items():
            readings = _predicted(series, name, about_mean=True)
            *_, after = readings
            if name in learned:
                ends = after.y + np.transpose(learned[name].band) - learned[name].value
                readings = (Curve("", after.x, after.y, "band", ends=ends), *readings)
            left = (
                Curve("", after.x, measured - series.predicted_before[name], "hollow", "blue"),
                Curve("", after.x, measured - series.predicted_after[name], "points", "orange"),
            )
            panels = (
                Panel(f"readings: {one.verdict.value}", readings),
                Panel("measured minus predicted", left, {"": 0.0}),
            )
            yield Figure(f"{pose} {name}".strip(), caption, "cycle", f"{name} - mean", panels)


def _is_changed(found: Diagnosis, name: str) -> bool:
    """Return whether an axis is predicted otherwise; one that follows another has no error."""
    if name not in found.error.after.rms:
        return False
    before, after = found.series.predicted_before[name], found.series.predicted_after[name]
    return not np.allclose(before, after, rtol=0, atol=1e-12)


def _rms(found: Diagnosis, name: str, unit: str) -> str:
    n, error = len(found.series.cycle), found.error
    before, after = (of_scatter(one.rms[name], n) for one in (error.before, error.after))
    return f"; rms of measured minus predicted: {before} {unit} before, {after} {unit} after"


def drift_pictures(analysis: Analysis) -> Iterator[Section]:
    """Yield for each pose the picture of its course, and the table of its blocks."""
    for course in analysis.drift or ():
        label = course.pose.label
        steady = Text(steady_in_words(course))
        blocks: tuple[Block, ...] = (steady, *_drift(course), blocks_table(course))
        yield Section("Drift" if label is None else f"Drift at pose {label}", blocks)


def _drift(course: DriftCourse) -> Iterator[Figure]:
    hours, fit = course.hours, course.fit
    if hours is None:
        return
    curves: list[Curve] = []
    lengths = [name for name, axis in course.pose.axes.items() if axis.unit == "mm"]
    for name, hue in zip(lengths, _HUES, strict=False):
        first = course.means[name][0]
        curves.append(Curve(name, hours, course.means[name] - first, "hollow", hue))
        if fit is not None:
            curves.append(Curve("", hours, fit.fitted[name] - first, "line", hue))
    steady = fit.steady_interval_h if fit is not None and fit.steady else None
    at = () if fit is None or steady is None else (fit.steady_after_h,)
    panel = Panel("", tuple(curves), along=steady, upright=at)
    caption = (
        "points: mean of each block minus that of the first; "
        + ("lines: the fitted exponential; " if fit else "no drift beyond chance is fitted; ")
        + ("band: where it is steady, with its 95 % interval" if steady else "not steady yet")
    )
    yield Figure("Course of the drift", caption, "hours", "moved [mm]", (panel,))


def push_picture(found: PushResult) -> Figure:
    """Return the picture of the loops: what the dial showed over the force."""
    curve = Curve("readings, in their order", found.loop.force, found.loop.reading)
    title, caption = "Loops of the push test", "the width at no force is the hysteresis"
    return Figure(title, caption, "force [N]", "[mm]", (Panel("", (curve,)),), wide=True)


def study_picture(study: AxisStudy) -> Figure:
    """Return the picture of a gauge study: its readings, and what decides."""
    figures, values, unit = study.figures, study.readings.values, study.readings.unit
    levels: dict[str, float] = {}
    ticks: tuple[str, ...] = ()
    match figures:
        case TypeOne():
            levels = {"mean": figures.mean}
            if figures.reference is not None:
                levels["reference"] = figures.reference
                for sign, mark in ((1, "+"), (-1, "-")) if study.tolerance else ():
                    end = figures.reference + sign * (study.tolerance or 0.0) / 10
                    levels[f"reference {mark} 0.1 T"] = end
            curves = [Curve("readings", np.arange(1.0, len(values) + 1), values, "points")]
            label, text = "reading", "readings in the order in which they were taken"
        case Crossed():
            means = figures.cells.mean(axis=2)
            x, ticks = np.arange(1.0, len(figures.parts) + 1), figures.parts
            names = figures.operators or ("mean",)
            curves = [Curve(name, x, means[:, k]) for k, name in enumerate(names)]
            label, text = "part", "mean of each part by operator"
        case Linearity():
            reference = np.asarray(study.readings.reference)
            at, middle, levels = figures.references, figures.lower + figures.upper, {"no bias": 0.0}
            curves = [
                Curve("bias of a reading", reference, values - reference, "points"),
                Curve("line", at, middle / 2),
                Curve("95 % band", at, figures.lower),
                Curve("", at, figures.upper),
            ]
            label = f"true value [{unit}]"
            text = "bias over the true value, line and its band"
        case Stability():
            x, ticks = np.arange(1.0, len(figures.means) + 1), figures.sessions
            levels = {"centre": figures.centre}
            low, high = (figures.centre + side * figures.half_width for side in (-1, 1))
            curves = [Curve("mean", x, figures.means), Curve("limits", x, low), Curve("", x, high)]
            label, text = "session", "means of the sessions, and their limits"
    panel = Panel("", tuple(curves), levels)
    title, scale = study.readings.axis, f"[{unit}]"
    return Figure(title, text, label, scale, (panel,), ticks=ticks, wide=True)


def comparison_pictures(found: Comparison) -> Iterator[Figure]:
    """Yield for each pair its readings about their means, ratios of RP, and changes of the mean."""
    for pair in found.pairs[:_MOST_PAIRS]:
        yield from _by_page(_before_and_after(pair))
        for k in range(0, len(pair.spreads), _PANELS):
            spreads = pair.spreads[k : k + _PANELS]
            ratios = [(one.ratio or None, one.ratio_interval) for one in spreads]
            yield _intervals("Ratio of RP", "RP after / before", spreads, ratios, unchanged=1.0)
        label = f"after − before [{_units(pair)}]"
        for k in range(0, len(pair.means), _PANELS):
            means = pair.means[k : k + _PANELS]
            changes = [(one.difference, one.difference_interval) for one in means]
            yield _intervals("Change of the mean", label, means, changes, unchanged=0.0)


def _before_and_after(pair: Pair) -> Figure:
    sides: tuple[tuple[Analysis, Look, Hue], ...] = (
        (pair.before, "hollow", "blue"),
        (pair.after, "points", "orange"),
    )
    panels = []
    for one in pair.means:
        curves = []
        for run, look, hue in sides:
            pose = {pose.label: pose for pose in run.poses}.get(one.pose, run.poses[0])
            axis = pose.axes[one.figure]
            off = axis.readings - axis.mean
            curves.append(Curve("", pose.cycle.astype(float), off, look, hue))
        panels.append(Panel(figure_name(one), tuple(curves)))
    names = (run.run.origin.source for run, *_ in sides)
    title = " → ".join(f"…{x[1 - _LONGEST_NAME :]}" if len(x) > _LONGEST_NAME else x for x in names)
    caption, label = "hollow: before, full: after", f"off its mean [{_units(pair)}]"
    return Figure(title, caption, "cycle", label, tuple(panels))


def _units(pair: Pair) -> str:
    return ", ".join(dict.fromkeys(one.unit for one in pair.means))


def _intervals(
    title: str,
    label: str,
    contrasts: Sequence[Contrast],
    found: Sequence[tuple[float | None, tuple[float | None, float | None]]],
    *,
    unchanged: float,
) -> Figure:
    known = [value for middle, ends in found for value in (middle, *ends) if value]
    beyond = min(known, default=1.0) / 1.3, max(known, default=1.0) * 1.3
    curves: list[Curve] = []
    for k, (one, (middle, ends)) in enumerate(zip(contrasts, found, strict=True), start=1):
        is_shown, x = one.verdict in CHANGED, np.array([float(k)])
        hue: Hue = "orange" if is_shown else "grey"
        of_ratio = [end or None for end in ends] if unchanged else ends
        both = [far if end is None else end for end, far in zip(of_ratio, beyond, strict=True)]
        curves.append(Curve("", x.repeat(2), np.array(both), "line", hue))
        looks: tuple[Look, Look] = ("below", "above")
        for look, end, far in zip(looks, of_ratio, beyond, strict=True):
            if end is None:
                curves.append(Curve("", x, np.array([far]), look, hue))
        if middle is not None:
            curves.append(Curve("", x, np.array([middle]), "points" if is_shown else "hollow", hue))
    caption = "95 % intervals; full: shown, hollow: not; a triangle: without end"
    names = tuple(figure_name(one) for one in contrasts)
    panel = Panel("", tuple(curves), {"": unchanged})
    is_ratio = unchanged > 0
    return Figure(title, caption, "", label, (panel,), ticks=names, wide=True, logarithmic=is_ratio)


def month_picture(found: RobotHistory, one: SpreadHistory) -> Figure:
    """Return a figure by date, with the trend where there is one."""
    days, values, trend = *_by_day(one), one.trend
    ends = np.array([test.interval or (math.nan, math.nan) for test in one.tests]).T
    curves = [Curve("95 %", days, values, "points", "ink", ends)]
    if trend is not None:
        curves.append(Curve("trend", days[-len(trend.levels) :], trend.levels, "line", "orange"))
        if trend.shown:
            first, last = trend.days[0], trend.days[-1]
            later = np.linspace(last, last + _AHEAD * (last - first), 12)
            curves.append(Curve("", later, trend.level(later), "dotted", "orange"))
    levels = {} if one.limit is None else {"limit": one.limit}
    panel = Panel("", tuple(curves), levels, upright=_services(found))
    title = f"{'RP' if one.quantity == 'RP' else '3 S'} {one.figure}"
    text = "each test with its 95 % interval; orange what the trend expects, dotted if it goes on"
    unit = f"[{one.unit}]"
    return Figure(title, text, "", unit, (panel,), y_limits=(0.0, None), dates=True)


def control_charts(found: RobotHistory, one: SpreadHistory | MeanHistory) -> Iterator[Figure]:
    """Yield the charts of a figure by date, where there are tests enough; an alarm is ringed."""
    days, values = _by_day(one)
    chart = partial(_control, _services(found), days)
    zero = 0.0 * days
    if isinstance(one, MeanHistory):
        if (c := one.chart) is not None:
            words = "Individuals", "mean of each test, limits of three standard errors"
            limits = c.low, c.centre, c.high
            unit = f"[{one.unit}]"
            yield chart(words, unit, {"mean": values}, limits, c.alarms)
            words = "Moving range", "distance from the test before, and its limit"
            moved, limits = np.nan_to_num(c.moving_range), (zero, zero, zero + c.range_limit)
            yield chart(words, unit, {"moving range": moved}, limits, c.alarms)
        return
    text, unit = "of ln RP against the tests before; a ring is an alarm", "[standard errors]"
    if (e := one.ewma) is not None:
        limits = -e.limits, zero, e.limits
        yield chart(("EWMA", text), unit, {"EWMA": e.points}, limits, e.alarms)
    if (s := one.cusum) is not None:
        limits = zero - s.limit, zero, zero + s.limit
        yield chart(("CUSUM", text), unit, {"up": s.up, "down": -s.down}, limits, s.alarms)


def _control(
    services: tuple[float, ...],
    days: FloatArray,
    words: tuple[str, str],
    label: str,
    lines: Mapping[str, FloatArray],
    limits: tuple[FloatArray, FloatArray, FloatArray],
    alarms: Sequence[int],
) -> Figure:
    low, centre, high = limits
    curves = [
        Curve("", days, centre, "band", ends=np.stack([low, high])),
        Curve("", days, centre, "line", "grey"),
    ]
    for (name, values), hue in zip(lines.items(), _HUES, strict=False):
        at = [k for k in alarms if values[k] > high[k] or values[k] < low[k]]
        curves.append(Curve(name, days, values, "joined", hue))
        curves.append(Curve("", days[at], values[at], "ring", "orange"))
    return Figure(*words, "", label, (Panel("", tuple(curves), upright=services),), dates=True)


def _by_day(one: SpreadHistory | MeanHistory) -> tuple[FloatArray, FloatArray]:
    days, values = zip(*((day_of(test.when), test.value) for test in one.tests), strict=True)
    return np.array(days), np.array(values)


def _services(found: RobotHistory) -> tuple[float, ...]:
    return tuple(day_of(event.when) for event in found.events)
