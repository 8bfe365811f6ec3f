"""The tables of figures: of a pose, of characteristics, of a drift; the budget of a reading."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from scara_iso.base.published import Size, Unit
from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.iso9283 import (
    Analysis,
    AxisResult,
    Characteristic,
    PlaneResult,
    PoseResult,
    RadialResult,
)
from scara_iso.reporting.shared.blocks import Block, Columns, Section, Strip, Table, Text, note
from scara_iso.reporting.shared.digits import (
    FIGURE,
    NOT_STATED,
    Cell,
    Number,
    U_of_mean,
    U_of_scatter,
    numbers,
    of_scatter,
    result,
    rounded,
    share,
)
from scara_iso.reporting.shared.limits import estimate_result
from scara_iso.run import Axis

if TYPE_CHECKING:
    from scara_iso.iso9283 import DriftCourse

_OF_A_POSE = ("AP", "RP", "RP_a", "RP_rss")
_RP = "RP [95 % interval]"


def characteristics(analysis: Analysis, *, advice: bool = True) -> Section:
    """Return one table of them, where there is one; ``advice`` names the command that explains."""
    found = [one for one in analysis.characteristics if one.code not in _OF_A_POSE]
    return Section("characteristics", (characteristics_table(found, advice=advice),))


def characteristics_table(found: Sequence[Characteristic], *, advice: bool = True) -> Table:
    """Return a table of characteristics."""
    columns: Columns[Characteristic] = {
        "characteristic": lambda one: f"{one.code} ({one.estimate.clause})",
        "pose": lambda one: one.pose,
        "of": lambda one: one.of,
        FIGURE: lambda one: estimate_result(one, one.estimate.unit),
        "n": lambda one: one.estimate.n,
    }
    more = "scara-iso explain CODE says more about each" if advice else ""
    return Table.of(found, columns, more)


def pose_figures(pose: PoseResult) -> Iterator[Block]:
    """Yield the tables of a pose: RP of axes, plane and space, accuracy, other words."""
    for unit in ("mm", "deg"):
        yield _axes_table(pose, [axis for axis in pose.axes.values() if axis.unit == unit], unit)
    yield Text(_accuracy(pose))
    for axis in pose.axes.values():
        if axis.angle is not None:
            yield Text(
                f"theta at a radius of {axis.angle.radius_mm:g} mm: RP = ± "
                f"{of_scatter(axis.angle.three_sigma_deg, axis.n)} deg (7.2.2, ± 3 S); "
                f"{of_scatter(axis.angle.RP_deg, axis.n)} deg by eq. 2-6"
            )
    yield definitions_table(pose)


def _axes_table(pose: PoseResult, axes: Sequence[AxisResult], unit: str) -> Table:
    rows = [_axis_row(axis) for axis in axes]
    rule = "; an angle's RP is ± 3 s (7.2.2)" if unit == "deg" else ""
    n = len(pose.rows)
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)) if rows and unit == "mm" else ():
        if found is not None:
            ratio = share(found.expanded_ratio)
            rows.append({"axis": f"{name} radial", **_parts(found, n), "U/RP": ratio})
        if isinstance(found, PlaneResult):
            RP = result(found.RP_rss, found.RP_rss_interval, n=n)
            rows.append({"axis": f"{name} eq. 23", _RP: RP})
    note = f"in {unit}; n = {n}; RP = l_bar + 3 S_l (eq. 2-6){rule}; U = 2 u"
    return Table.by_name(rows, note)


def _axis_row(axis: AxisResult) -> dict[str, Cell]:
    angle, ratio = axis.unit == "deg", share(axis.expanded_ratio)
    ends = axis.three_sigma_interval if angle else None
    three = result(axis.three_sigma, ends, n=axis.n)
    return {
        "axis": axis.name,
        "mean": rounded(axis.mean, U_of_mean(axis)),
        **_parts(axis, axis.n),
        **({"± 3 s [95 % interval]": three, "U/3 s": ratio} if angle else {}),
        **({} if angle else {"3 s": three.value, "U/RP": ratio}),
    }


def _parts(found: AxisResult | RadialResult, n: int) -> dict[str, Cell]:
    angle = isinstance(found, AxisResult) and found.unit == "deg"
    RP = result(found.RP, None if angle else found.RP_interval, n=n)
    low, high = found.RP_interval or (0.0, 2 * U_of_scatter(found.RP, n))
    l_bar, S_l = (rounded(value, (high - low) / 2) for value in (found.l_bar, found.S_l))
    return {"l_bar": l_bar, "S_l": S_l, "RP" if angle else _RP: RP}


def _accuracy(pose: PoseResult) -> str:
    parts = [
        f"{axis.name} {rounded(axis.accuracy, U_of_mean(axis), sign='+', unit=axis.unit)}"
        for axis in pose.axes.values()
        if axis.accuracy is not None
    ]
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if found is not None and found.accuracy is not None:
            U = max(U_of_mean(pose.axes[axis]) for axis in name)
            parts.append(f"{name} {rounded(found.accuracy, U, unit='mm')}")
    return f"accuracy AP (7.2.1, mean minus command): {', '.join(parts)}" if parts else ""


def definitions_table(pose: PoseResult) -> Table:
    """Return other definitions of repeatability, a column for each axis; empty without any."""
    axes = [axis for axis in pose.axes.values() if axis.definitions]
    scatter = [U_of_scatter(axis.three_sigma, axis.n) for axis in axes]
    rows = [
        (found[0].name, *(rounded(d.value, U) for d, U in zip(found, scatter, strict=True)))
        for found in zip(*(axis.definitions for axis in axes), strict=True)
    ]
    header = ("other words", *(f"{axis.name} [{axis.unit}]" for axis in axes))
    meanings = [f"{one.name}: {one.meaning}" for axis in axes[:1] for one in axis.definitions]
    return Table(header, tuple(rows), "; ".join(meanings))


def drift_details(analysis: Analysis) -> Iterator[Section]:
    """Yield when each pose of a drift test is steady, and the means of its blocks."""
    for course in analysis.drift or ():
        label = course.pose.label or ""
        blocks = (Text(steady_in_words(course)), blocks_table(course))
        yield Section(f"{label and f'pose {label}: '}drift by block", blocks, label)


def drift_headlines(analysis: Analysis) -> Iterator[Text]:
    """Yield how far each pose moves, and when it is steady."""
    for course in analysis.drift or ():
        label = course.pose.label
        mine = [one for one in analysis.characteristics if one.pose == label]
        figures = filter(None, (largest_of(mine, code) for code in ("dAP", "dRP")))
        moved = [
            f"{one.code} of {one.of} {estimate_result(one, one.estimate.unit)}" for one in figures
        ]
        name = f"drift{'' if label is None else f' at {label}'}"
        yield Text(f"{name}: {', '.join(moved[:1])}", "strong", tuple(moved[1:]))
        steady, *constant = steady_in_words(course).split(": ", 1)
        yield Text(steady, parts=tuple(constant))


def largest_of(found: Sequence[Characteristic], code: str) -> Characteristic | None:
    """Return the figure in space or in the plane, else the largest of an axis."""
    mine = {one.of: one for one in found if one.code == code}
    whole = mine.get("XYZ") or mine.get("XY")
    return whole or max(mine.values(), key=lambda one: one.estimate.value, default=None)


def drift_strips(course: DriftCourse) -> Iterator[Strip]:
    """Yield the means of the blocks of each axis."""
    for name, means in course.means.items():
        U, unit = max(float(np.ptp(means)) / 10, 1e-9), course.pose.axes[name].unit
        moved = rounded(means[-1] - means[0], U, sign="+", unit=unit)
        yield Strip(name, means, f"block 1 to {len(means)}: {moved}")


def steady_in_words(course: DriftCourse) -> str:
    """Return when a pose is steady, and the time constant of its drift."""
    fit = course.fit
    if course.hours is None:
        return "no times are stated: no time constant is fitted"
    if fit is None:
        return "no drift beyond chance is seen between the blocks, or they are fewer than six"
    constant = f"time constant {result(fit.time_constant_h, fit.interval_h, 'h')}"
    if not fit.steady or fit.steady_interval_h is None:
        return f"not steady within {fit.hours[-1]:.3g} h: {constant}, from a fit that looks ahead"
    steady = result(fit.steady_after_h, fit.steady_interval_h, "h")
    return f"steady after {steady}: a tenth is left then; {constant}"


def blocks_table(course: DriftCourse) -> Table:
    """Return the means of the blocks of a drift test."""
    hours = course.hours
    columns: dict[str, list[Cell]] = {"block": [*numbers(range(1, len(course.visits) + 1))]}
    if hours is not None:
        columns["hours"] = [*numbers(hours, ".2f")]
    columns["visits"] = [*numbers(map(len, course.visits))]
    for name, means in course.means.items():
        columns[f"{name} [{course.pose.axes[name].unit}]"] = [*numbers(means, ".5f")]
    return Table.in_columns(columns, "means of the visits; hours from the first visit")


_ANGLE = "the angle between the indicator and its axis (cosine error), "


@dataclass(frozen=True, slots=True)
class UncertaintyLine:
    """What a reading of one axis is uncertain by, in ``unit``; None where nobody stated it.

    ``u_resolution`` and ``u_calibration`` are standard uncertainties, ``u`` both combined as
    independent (GUM 5.1.2), ``U`` = 2 u the expanded one.
    """

    axis: str
    """Its name."""
    unit: Unit
    """Of every size here."""
    resolution: Size | None
    """The dial's division; null where not stated."""
    u_resolution: Size | None
    """Standard uncertainty of rounding to it."""
    u_calibration: Size | None
    """Standard uncertainty by the certificate; null where not stated."""
    u: Size | None
    """Both combined."""
    U: Size | None
    """2 u, the expanded uncertainty."""


def uncertainty_budget(analysis: Analysis) -> tuple[UncertaintyLine, ...]:
    """Return a line for each axis; of several poses and conditions the largest counts."""
    return tuple(_budget_line(axis, analysis.poses) for axis in analysis.run.axes.values())


def _budget_line(axis: Axis, poses: Sequence[PoseResult]) -> UncertaintyLine:
    found = [pose.axes[axis.name].uncertainty for pose in poses]
    known = [u for u in found if u is not None]
    u = max(known) if len(known) == len(found) else None
    rounding = None if axis.resolution is None else rounding_uncertainty(axis.resolution)
    U = None if u is None else 2 * u
    unit = cast(Unit, axis.unit)
    return UncertaintyLine(axis.name, unit, axis.resolution, rounding, axis.uncertainty, u, U)


def budget_blocks(analysis: Analysis) -> Iterator[Block]:
    """Yield the budget as a table, and what is left open."""
    lines, run = uncertainty_budget(analysis), analysis.run
    columns: Columns[UncertaintyLine] = {
        "axis": lambda line: line.axis,
        "resolution a": lambda line: (
            NOT_STATED if line.resolution is None else Number(line.resolution, "g")
        ),
        "u of it: a / √12": lambda line: _u_cell(line.u_resolution),
        "u of the calibration": lambda line: _u_cell(line.u_calibration),
        "combined u": lambda line: _u_cell(line.u),
        "expanded U = 2 u": lambda line: _u_cell(line.U),
        "in": lambda line: line.unit,
    }
    yield Table.of(lines, columns, note("combined"))
    yield Text(note("no_calibration") if any(line.u_calibration is None for line in lines) else "")
    yield Text(_corrections([axis for axis in run.axes.values() if axis.displayed is not None]))
    yield Text(note("what_u_is"))
    cosines = [key for key, text in run.metadata.items() if "cosine" in text]
    aligned = (any(key.startswith(f"corrected_{name}") for key in cosines) for name in run.axes)
    yield Text(note("not_in_budget").format(angle="" if all(aligned) else _ANGLE))


def _u_cell(u: float | None) -> Cell:
    return NOT_STATED if u is None else rounded(u, u)


def _corrections(found: Sequence[Axis]) -> str:
    parts = [
        f"{axis.name} {axis.uncertainty or 0.0:.2g} {axis.unit} "
        f"with {NOT_STATED if axis.certified is None else f'{axis.certified:.2g}'} of the "
        "certificate"
        for axis in found
    ]
    names = ", ".join(axis.name for axis in found)
    return note("corrected").format(axes=names, each="; ".join(parts)) if found else ""
