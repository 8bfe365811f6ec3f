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
from scara_iso.reporting.blocks import (
    Block,
    Columns,
    Headline,
    Section,
    Strip,
    Table,
    Text,
    table_by_name,
    tabulated,
)
from scara_iso.reporting.digits import (
    NOT_STATED,
    Cell,
    Number,
    U_of_mean,
    U_of_RP,
    U_of_scatter,
    half_of,
    in_brackets,
    interval,
    of_scatter,
    rounded,
)
from scara_iso.run import Axis, Run

if TYPE_CHECKING:
    from scara_iso.iso9283 import DriftCourse

_OF_A_POSE = ("AP", "RP", "RP_a", "RP_rss")


def characteristics(analysis: Analysis, *, advice: bool = True) -> Iterator[Section]:
    """Yield one table of them, where there is one; ``advice`` names the command that explains."""
    found = [one for one in analysis.characteristics if one.code not in _OF_A_POSE]
    yield Section("characteristics", (characteristics_table(found, advice=advice),))


def characteristics_table(found: Sequence[Characteristic], *, advice: bool = True) -> Table:
    """Return a table of characteristics."""
    columns: Columns[Characteristic] = {
        "characteristic": lambda one: f"{one.code} ({one.estimate.clause})",
        "pose": lambda one: one.pose,
        "of": lambda one: one.of,
        "figure": lambda one: rounded(one.estimate.value, _U_of(one)),
        "95 % interval": lambda one: interval(one.estimate.interval),
        "n": lambda one: one.estimate.n,
        "in": lambda one: one.estimate.unit,
    }
    return tabulated(
        found, columns, "scara-iso explain CODE says more about each" if advice else ""
    )


def _U_of(one: Characteristic) -> float:  # noqa: N802 - GUM's symbol
    ends = one.estimate.interval
    return half_of(ends) if ends else U_of_scatter(one.estimate.value, one.estimate.n)


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
    """Return the figures of the axes of a unit, and of the plane and space below lengths."""
    if not axes:
        return Table((), ())
    rows = [_axis_row(axis) for axis in axes]
    rule = "; an angle's RP is ± 3 s (7.2.2)" if unit == "deg" else ""
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)) if unit == "mm" else ():
        if found is not None:
            rows += _radial_rows(name, found, len(pose.rows))
    note = f"in {unit}; n = {axes[0].n}; RP = l_bar + 3 S_l (eq. 2-6){rule}; U = 2 u"
    return table_by_name(rows, note)


def _axis_row(axis: AxisResult) -> dict[str, Cell]:
    """Return the row of an axis by column; of an angle, ± 3 s and its own interval."""
    angle = axis.unit == "deg"
    three_sigma: Cell = of_scatter(axis.three_sigma, axis.n)
    return {
        "axis": axis.name,
        "mean": rounded(axis.mean, U_of_mean(axis)),
        **_parts(axis, axis.n),
        **({"± 3 s": three_sigma} if angle else {}),
        "95 % interval": interval(axis.three_sigma_interval if angle else axis.RP_interval),
        **({} if angle else {"3 s": three_sigma}),
        "U/3 s" if angle else "U/RP": _share(axis.expanded_ratio),
    }


def _radial_rows(name: str, found: RadialResult, n: int) -> Iterator[dict[str, Cell]]:
    yield {
        "axis": f"{name} radial",
        **_parts(found, n),
        "95 % interval": interval(found.RP_interval),
        "U/RP": _share(found.expanded_ratio),
    }
    if isinstance(found, PlaneResult):
        yield {
            "axis": f"{name} eq. 23",
            "RP": rounded(found.RP_rss, U_of_RP(found, n)),
            "95 % interval": interval(found.RP_rss_interval),
        }


def _parts(found: AxisResult | RadialResult, n: int) -> dict[str, Cell]:
    """Return l_bar, S_l and RP to the same place; the appendix of a report has all digits."""
    U, parts = U_of_RP(found, n), {"l_bar": found.l_bar, "S_l": found.S_l, "RP": found.RP}
    return {name: rounded(figure, U) for name, figure in parts.items()}


def _share(ratio: float | None) -> Number | str:
    return "" if ratio is None else Number(ratio, ".0%")


def _accuracy(pose: PoseResult) -> str:
    parts = [
        f"{axis.name} {rounded(axis.accuracy, U_of_mean(axis), sign='+')} {axis.unit}"
        for axis in pose.axes.values()
        if axis.accuracy is not None
    ]
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if found is not None and found.accuracy is not None:
            U = max(U_of_mean(pose.axes[axis]) for axis in name)
            parts.append(f"{name} {rounded(found.accuracy, U)} mm")
    return f"accuracy AP (7.2.1, mean minus command): {', '.join(parts)}" if parts else ""


def definitions_table(pose: PoseResult) -> Table:
    """Return other definitions of repeatability, a column for each axis; empty without any."""
    axes = [axis for axis in pose.axes.values() if axis.definitions]
    if not axes:
        return Table((), ())
    scatter = [U_of_scatter(axis.three_sigma, axis.n) for axis in axes]
    rows = [
        (found[0].name, *(rounded(d.value, U) for d, U in zip(found, scatter, strict=True)))
        for found in zip(*(axis.definitions for axis in axes), strict=True)
    ]
    header = ("other words", *(f"{axis.name} [{axis.unit}]" for axis in axes))
    meanings = "; ".join(f"{d.name}: {d.meaning}" for d in axes[0].definitions)
    return Table(header, tuple(rows), meanings)


def drift_details(analysis: Analysis) -> Iterator[Section]:
    """Yield when each pose of a drift test is steady, and the means of its blocks."""
    for course in analysis.drift or ():
        blocks = (Text(steady_in_words(course)), blocks_table(course))
        label = course.pose.label or ""
        yield Section(f"{label and f'pose {label}: '}drift by block", blocks, label)


def drift_headlines(analysis: Analysis) -> Iterator[Headline]:
    """Yield how far each pose moves, and when it is steady."""
    for course in analysis.drift or ():
        label = course.pose.label
        mine = [one for one in analysis.characteristics if one.pose == label]
        figures = filter(None, (largest_of(mine, code) for code in ("dAP", "dRP")))
        moved = [_moved(one) for one in figures]
        name = f"drift{'' if label is None else f' at {label}'}"
        yield Headline((f"{name}: {', '.join(moved[:1])}", *moved[1:]))
        steady, _, constant = steady_in_words(course).partition(": ")
        yield Headline((steady, *filter(None, [constant])), "plain")


def _moved(one: Characteristic) -> str:
    """Return how much of what moves between the blocks."""
    value = str(rounded(one.estimate.value, half_of(one.estimate.interval)))
    between = in_brackets(interval(one.estimate.interval))
    return " ".join(filter(None, (f"{one.code} of {one.of}", value, between, one.estimate.unit)))


def largest_of(found: Sequence[Characteristic], code: str) -> Characteristic | None:
    """Return the figure in space or in the plane, else the largest of an axis."""
    mine = {one.of: one for one in found if one.code == code}
    whole = mine.get("XYZ") or mine.get("XY")
    return whole or max(mine.values(), key=lambda one: one.estimate.value, default=None)


def drift_strips(course: DriftCourse) -> Iterator[Strip]:
    """Yield the means of the blocks of each axis."""
    blocks = np.arange(1, len(course.visits) + 1)
    for name, means in course.means.items():
        U = max(float(np.ptp(means)) / 10, 1e-9)
        moved = f"{rounded(means[-1] - means[0], U, sign='+')} {course.pose.axes[name].unit}"
        yield Strip(name, blocks, means, f"block 1 to {len(blocks)}: {moved}")


def steady_in_words(course: DriftCourse) -> str:
    """Return when a pose is steady, and the time constant of its drift."""
    fit = course.fit
    if course.hours is None:
        return "no times are stated: no time constant is fitted"
    if fit is None:
        return "no drift beyond chance is seen between the blocks, or they are fewer than six"
    low, high = fit.interval_h
    tau, U = fit.time_constant_h, ((high or 3 * fit.time_constant_h) - low) / 2
    end = "not bounded" if high is None else rounded(high, U)
    constant = f"time constant {rounded(tau, U)} h [{rounded(low, U)}, {end}]"
    ends = fit.steady_interval_h
    if not fit.steady or ends is None:
        return f"not steady within {fit.hours[-1]:.3g} h: {constant}, from a fit that looks ahead"
    steady = rounded(fit.steady_after_h, half_of(ends))
    return (
        f"steady after {steady} h {in_brackets(interval(ends))}: a tenth is left then; {constant}"
    )


def blocks_table(course: DriftCourse) -> Table:
    """Return the means of the blocks of a drift test."""
    hours = course.hours
    units = {name: course.pose.axes[name].unit for name in course.means}
    rows = tuple(
        (
            Number(k + 1),
            "" if hours is None else Number(float(hours[k]), ".2f"),
            Number(len(visits)),
            *(Number(float(means[k]), ".5f") for means in course.means.values()),
        )
        for k, visits in enumerate(course.visits)
    )
    header = ("block", "hours", "visits", *(f"{name} [{unit}]" for name, unit in units.items()))
    return Table(header, rows, "means of the visits; hours from the first visit")


_ANGLE = "the angle between the indicator and its axis (cosine error), "
_OPEN = (
    "Not in the budget, because no reading shows it: {angle}the shape and wear of its tip, the "
    "stiffness of its stand, the temperature of robot and stand. They add to what is combined here."
)
_CORRECTED = (
    "The calibration of {axes} holds the certificate's own uncertainty, that of its correction "
    "curve and that of the angle between plunger and axis, combined as independent: {each}. The "
    "readings are corrected; what the dial showed is in the raw data."
)
_NO_CALIBRATION = (
    "Where the calibration is not stated, the combined uncertainty holds the resolution alone: "
    "the indicator's own errors are left out of it, and it is too small."
)
_WHAT_IT_IS = (
    "The indicator makes single readings uncertain; how far RP itself could differ if the test "
    "were repeated is its 95 % interval, in which rounding and a stated calibration are counted."
)
_COMBINED = (
    "rounding to a division is a rectangular distribution (GUM F.2.2.1); the calibration's is "
    "the standard uncertainty that its certificate gives; both combined as independent (GUM 5.1.2)"
)


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
    yield tabulated(lines, columns, _COMBINED)
    yield Text(_NO_CALIBRATION if any(line.u_calibration is None for line in lines) else "")
    yield Text(_corrections(run))
    yield Text(_WHAT_IT_IS)
    aligned = (
        any(
            "cosine" in text
            for key, text in run.metadata.items()
            if key.startswith(f"corrected_{name}")
        )
        for name in run.axes
    )
    yield Text(_OPEN.format(angle="" if all(aligned) else _ANGLE))


def _u_cell(u: float | None) -> Cell:
    return NOT_STATED if u is None else rounded(u, u)


def _corrections(run: Run) -> str:
    found = [axis for axis in run.axes.values() if axis.displayed is not None]
    parts = [
        f"{axis.name} {axis.uncertainty or 0.0:.2g} {axis.unit} "
        f"with {NOT_STATED if axis.certified is None else f'{axis.certified:.2g}'} of the "
        "certificate"
        for axis in found
    ]
    names = ", ".join(axis.name for axis in found)
    return _CORRECTED.format(axes=names, each="; ".join(parts)) if found else ""
