"""The tables of figures and characteristics, and the uncertainty budget of a reading."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

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
    NOT_STATED,
    Block,
    Cell,
    Number,
    Section,
    Table,
    Text,
    U_of_mean,
    U_of_RP,
    U_of_scatter,
    interval,
    rounded,
    table_by_name,
)
from scara_iso.run import Axis, Run

_OF_A_POSE = ("AP", "RP", "RP_a", "RP_rss")


def characteristics(analysis: Analysis, *, advice: bool = True) -> Iterator[Section]:
    """Yield one table of them, where there is one; ``advice`` names the command that explains."""
    found = [one for one in analysis.characteristics if one.code not in _OF_A_POSE]
    if found:
        yield Section("characteristics", (characteristics_table(found, advice=advice),))


def characteristics_table(found: Sequence[Characteristic], *, advice: bool = True) -> Table:
    """Return a table of characteristics."""
    header = ("characteristic", "pose", "of", "figure", "95 % interval", "n", "in")
    how = "scara-iso explain CODE says more about each" if advice else ""
    return Table(header, tuple(_row(one) for one in found), how)


def _row(found: Characteristic) -> tuple[Cell, ...]:
    estimate = found.estimate
    ends = estimate.interval
    U = U_of_scatter(estimate.value, estimate.n) if ends is None else (ends[1] - ends[0]) / 2
    return (
        f"{found.code} ({estimate.clause})",
        found.pose or "",
        found.of,
        rounded(estimate.value, U),
        interval(ends),
        Number(estimate.n),
        estimate.unit,
    )


def pose_figures(pose: PoseResult) -> Iterator[Block]:
    """Yield the tables of a pose: RP of axes, plane and space, accuracy, other words."""
    for unit in ("mm", "deg"):
        axes = [axis for axis in pose.axes.values() if axis.unit == unit]
        if axes:
            yield _axes_table(pose, axes, unit)
    yield from (Text(line) for line in _accuracy(pose))
    for axis in pose.axes.values():
        if axis.angle is not None:
            yield Text(
                f"theta at a radius of {axis.angle.radius_mm:g} mm: RP = ± "
                f"{_of_scatter(axis.angle.three_sigma_deg, axis.n)} deg (7.2.2, ± 3 S); "
                f"{_of_scatter(axis.angle.RP_deg, axis.n)} deg by eq. 2-6"
            )
    defined = [axis for axis in pose.axes.values() if axis.definitions]
    if defined:
        yield definitions_table(defined)


def _axes_table(pose: PoseResult, axes: Sequence[AxisResult], unit: str) -> Table:
    rows = [_axis_row(axis) for axis in axes]
    rows += [] if unit == "deg" else _radial_rows(pose)
    rule = "; an angle's RP is ± 3 s (7.2.2)" if unit == "deg" else ""
    note = f"in {unit}; n = {axes[0].n}; RP = l_bar + 3 S_l (eq. 2-6){rule}; U = 2 u"
    return table_by_name(rows, note)


def _axis_row(axis: AxisResult) -> dict[str, Cell]:
    """Return the row of an axis by column; of an angle, ± 3 s and its own interval."""
    angle = axis.unit == "deg"
    three_sigma: Cell = _of_scatter(axis.three_sigma, axis.n)
    return {
        "axis": axis.name,
        "mean": rounded(axis.mean, U_of_mean(axis)),
        **_parts(axis, axis.n),
        **({"± 3 s": three_sigma} if angle else {}),
        "95 % interval": interval(axis.three_sigma_interval if angle else axis.RP_interval),
        **({} if angle else {"3 s": three_sigma}),
        "U/3 s" if angle else "U/RP": _share(axis.expanded_ratio),
    }


def _radial_rows(pose: PoseResult) -> Iterator[dict[str, Cell]]:
    n = len(pose.rows)
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if found is None:
            continue
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
    U = U_of_RP(found, n)
    return {
        "l_bar": rounded(found.l_bar, U),
        "S_l": rounded(found.S_l, U),
        "RP": rounded(found.RP, U),
    }


def _of_scatter(figure: float, n: int) -> Number:
    return rounded(figure, U_of_scatter(figure, n))


def _accuracy(pose: PoseResult) -> Iterator[str]:
    parts = [
        f"{axis.name} {rounded(axis.accuracy, U_of_mean(axis), sign='+')} {axis.unit}"
        for axis in pose.axes.values()
        if axis.accuracy is not None
    ]
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if found is not None and found.accuracy is not None:
            U = max(U_of_mean(pose.axes[axis]) for axis in name)
            parts.append(f"{name} {rounded(found.accuracy, U)} mm")
    if parts:
        yield f"accuracy AP (7.2.1, mean minus command): {', '.join(parts)}"


def definitions_table(axes: Sequence[AxisResult]) -> Table:
    """Return other definitions of repeatability, a column for each axis."""
    scatter = [U_of_scatter(axis.three_sigma, axis.n) for axis in axes]
    rows = [
        (found[0].name, *(rounded(d.value, U) for d, U in zip(found, scatter, strict=True)))
        for found in zip(*(axis.definitions for axis in axes), strict=True)
    ]
    header = ("other words", *(f"{axis.name} [{axis.unit}]" for axis in axes))
    meanings = "; ".join(f"{d.name}: {d.meaning}" for d in axes[0].definitions)
    return Table(header, tuple(rows), meanings)


def _share(ratio: float | None) -> Number | str:
    return "" if ratio is None else Number(ratio, ".0%")


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
    return tuple(
        _line(axis, _largest([pose.axes[name].uncertainty for pose in analysis.poses]))
        for name, axis in analysis.run.axes.items()
    )


def _largest(found: Sequence[float | None]) -> float | None:
    known = [u for u in found if u is not None]
    return max(known) if len(known) == len(found) else None


def budget_blocks(analysis: Analysis) -> Iterator[Block]:
    """Yield the budget as a table, and what is left open."""
    lines = uncertainty_budget(analysis)
    yield Table(
        (
            "axis",
            "resolution a",
            "u of it: a / √12",
            "u of the calibration",
            "combined u",
            "expanded U = 2 u",
            "in",
        ),
        tuple(map(_budget_row, lines)),
        "rounding to a division is a rectangular distribution (GUM F.2.2.1); the calibration's is "
        "the standard uncertainty that its certificate gives; both combined as independent "
        "(GUM 5.1.2)",
    )
    if any(line.u_calibration is None for line in lines):
        yield Text(_NO_CALIBRATION)
    run = analysis.run
    yield from _corrections(run)
    yield Text(_WHAT_IT_IS)
    yield Text(
        _OPEN.format(angle="" if all(_is_aligned(run, name) for name in run.axes) else _ANGLE)
    )


def _is_aligned(run: Run, axis: str) -> bool:
    """Whether the angle between plunger and axis is stated, and so in the budget."""
    parts = (text for key, text in run.metadata.items() if key.startswith(f"corrected_{axis}"))
    return any("cosine" in text for text in parts)


def _corrections(run: Run) -> Iterator[Text]:
    found = [axis for axis in run.axes.values() if axis.displayed is not None]
    if found:
        parts = [
            f"{axis.name} {0.0 if axis.uncertainty is None else axis.uncertainty:.2g} {axis.unit} "
            f"with {NOT_STATED if axis.certified is None else f'{axis.certified:.2g}'} of the "
            "certificate"
            for axis in found
        ]
        names = ", ".join(axis.name for axis in found)
        yield Text(_CORRECTED.format(axes=names, each="; ".join(parts)))


def _line(axis: Axis, u: float | None) -> UncertaintyLine:
    rounding = None if axis.resolution is None else rounding_uncertainty(axis.resolution)
    U = None if u is None else 2 * u
    unit = cast(Unit, axis.unit)
    return UncertaintyLine(axis.name, unit, axis.resolution, rounding, axis.uncertainty, u, U)


def _budget_row(line: UncertaintyLine) -> tuple[Cell, ...]:
    stated = NOT_STATED if line.resolution is None else Number(line.resolution, "g")
    parts = (line.u_resolution, line.u_calibration, line.u, line.U)
    lines = [NOT_STATED if u is None else rounded(u, u) for u in parts]
    return (line.axis, stated, *lines, line.unit)
