"""The tables of figures: each axis, plane and space of a pose, and every characteristic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scara_iso.iso9283 import Analysis, AxisResult, Characteristic, PoseResult, RadialResult
from scara_iso.reporting.blocks import Block, Cell, Number, Section, Table, Text, table_by_name
from scara_iso.reporting.digits import U_of_mean, U_of_RP, U_of_scatter, interval, rounded

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
        if found.RP_rss is not None:
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
    said = [
        f"{axis.name} {rounded(axis.accuracy, U_of_mean(axis), sign='+')} {axis.unit}"
        for axis in pose.axes.values()
        if axis.accuracy is not None
    ]
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if found is not None and found.accuracy is not None:
            U = max(U_of_mean(pose.axes[axis]) for axis in name)
            said.append(f"{name} {rounded(found.accuracy, U)} mm")
    if said:
        yield f"accuracy AP (7.2.1, mean minus command): {', '.join(said)}"


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
