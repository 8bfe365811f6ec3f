"""Every value between the readings and RP, so that each figure can be checked by hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.iso9283 import AxisResult, PoseResult
from scara_iso.reporting.blocks import Block, Cell, Number, Table
from scara_iso.reporting.digits import decimals
from scara_iso.run import FloatArray

_MORE_PLACES = 3  # than a reading has: enough that sums of them agree to the last one printed


def intermediates(pose: PoseResult) -> Iterator[Block]:
    """Yield sums, means and standard deviations behind each RP, eq. 2-6 and 7.2.2."""
    rows = []
    for axis in pose.axes.values():
        left = axis.readings - axis.mean
        rows.append(_row(axis.name, axis.unit, _places(pose), axis.readings, np.abs(left)))
    rows += [
        _row(name, "mm", _places(pose), None, _distances(pose, name))
        for name in ("XY", "XYZ")
        if name in pose.figures
    ]
    yield Table(
        (
            "figure",
            "unit",
            "n",
            "sum",
            "mean",
            "sum of l_j",
            "l_bar",
            "sum of (l_j - l_bar)²",
            "S_l",
            "RP = l_bar + 3 S_l",
        ),
        tuple(rows),
        "l_j: distance of cycle j from the mean (of an axis, eq. 2) or from the barycentre "
        "(XY and XYZ, 7.2.2); S_l with n - 1; eq. 23 is the root of RP² of X plus RP² of Y. "
        "Computed with all digits; more of them are printed here than the figures bear, so that "
        "each can be checked by hand.",
    )
    angles = [axis for axis in pose.axes.values() if axis.unit == "deg"]
    for axis in angles:
        yield _angle(axis, _places(pose))


def by_cycle(pose: PoseResult) -> Iterator[Block]:
    """Yield the deviation of each cycle from the mean, and its distance to the barycentre."""
    places = _places(pose)
    columns = {
        f"{axis.name} - mean [{axis.unit}]": axis.readings - axis.mean
        for axis in pose.axes.values()
    }
    cells = [[Number(v, f"+.{places}f") for v in values.tolist()] for values in columns.values()]
    radial = [name for name in ("XY", "XYZ") if name in pose.figures]
    cells += [
        [Number(v, f".{places}f") for v in _distances(pose, name).tolist()] for name in radial
    ]
    yield Table(
        ("cycle", *columns, *(f"l_j {name} [mm]" for name in radial)),
        tuple(zip(map(Number, pose.cycle.tolist()), *cells, strict=True)),
        "l_j of an axis is the deviation without its sign",
    )


def _row(
    name: str,
    unit: str,
    places: int,
    readings: FloatArray | None,
    l: FloatArray,  # noqa: E741
) -> tuple[Cell, ...]:
    n, l_bar = len(l), float(l.mean())
    squares = float(((l - l_bar) ** 2).sum())
    S_l = float(np.sqrt(squares / (n - 1)))
    spec = f".{places}f"
    sums: list[Cell] = ["", ""]
    if readings is not None:
        sums = [Number(float(v), spec) for v in (readings.sum(), readings.mean())]
    return (
        name,
        unit,
        Number(n),
        *sums,
        Number(float(l.sum()), spec),
        Number(l_bar, spec),
        Number(squares, ".6g"),
        Number(S_l, spec),
        Number(l_bar + 3 * S_l, spec),
    )


def _angle(axis: AxisResult, places: int) -> Table:
    s = axis.three_sigma / 3
    row: tuple[Cell, ...] = (axis.name, *(Number(v, f".{places}f") for v in (s, axis.three_sigma)))
    return Table(("angle", "S [deg]", "RP = ± 3 S [deg]"), (row,), "7.2.2, S with n - 1")


def _distances(pose: PoseResult, names: str) -> FloatArray:
    """Return the distance of each cycle to the barycentre of the named axes, shape (n,)."""
    squares = [(pose.axes[name].readings - pose.axes[name].mean) ** 2 for name in names]
    return np.asarray(np.sqrt(np.sum(squares, axis=0)))


def _places(pose: PoseResult) -> int:
    """Return decimal places: some more than the finest dial shows."""
    steps = [axis.resolution or axis.three_sigma for axis in pose.axes.values()]
    return decimals([step for step in steps if step]) + _MORE_PLACES - 2
