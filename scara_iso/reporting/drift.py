"""The report on a drift test: how far, until when, block by block, and its picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from scara_iso.iso9283 import Analysis, Characteristic
from scara_iso.reporting.blocks import (
    Block,
    DriftPicture,
    Figure,
    Headline,
    Number,
    Section,
    Strip,
    Table,
    Text,
)
from scara_iso.reporting.digits import rounded

if TYPE_CHECKING:
    from scara_iso.iso9283 import DriftCourse

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
    moved = [_said(one) for one in figures if one is not None]
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


def _said(one: Characteristic) -> str:
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
    if not fit.is_steady or ends is None:
        return f"not steady within {fit.hours[-1]:.3g} h: {constant}, from a fit that looks ahead"
    U = (ends[1] - ends[0]) / 2
    steady, *said = (rounded(hours, U) for hours in (fit.steady_after_h, *ends))
    return f"steady after {steady} h [{said[0]}, {said[1]}]: a tenth is left then; {constant}"


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
    steady = fit.steady_interval_h if fit is not None and fit.is_steady else None
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
