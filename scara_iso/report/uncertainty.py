"""The uncertainty budget: what a reading is uncertain by, and what nobody stated."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.quantities import rounding_uncertainty
from scara_iso.report.blocks import Block, Table, Text
from scara_iso.report.digits import decimals
from scara_iso.report.head import NOT_STATED
from scara_iso.results import Analysis, AxisResult
from scara_iso.run import Axis

_OPEN = (
    "Not in the budget, because no reading tells it: the angle between the indicator and its axis "
    "(cosine error), the shape and wear of its tip, the stiffness of its stand, the temperature of "
    "robot and stand. They add to what is combined here."
)
_WHAT_IT_IS = (
    "The indicator makes single readings uncertain; how far RP itself could differ if the test "
    "were repeated is its 95 % interval."
)


def uncertainty_budget(analysis: Analysis) -> Iterator[Block]:
    """Yield one table for each axis, the same at every pose, and what is left open."""
    first = analysis.poses[0]
    for name, axis in analysis.run.axes.items():
        yield _budget(axis, first.axes[name])
    yield Text(_WHAT_IT_IS)
    yield Text(_OPEN)


def _budget(axis: Axis, result: AxisResult) -> Table:
    parts = [
        ("resolution", axis.resolution, "rectangular", "2 √3",
         None if axis.resolution is None else rounding_uncertainty(axis.resolution)),
        ("calibration", axis.uncertainty, "normal", "1", axis.uncertainty),
        ("combined", None, "root sum of squares", "", result.uncertainty),
        ("expanded, k = 2", None, "", "",
         None if result.uncertainty is None else 2 * result.uncertainty),
    ]  # fmt: skip
    known = [u for *_, u in parts if u is not None]
    places = decimals(known)
    rows = tuple(
        (
            source,
            (NOT_STATED if source in ("resolution", "calibration") else "")
            if value is None
            else f"{value:g}",
            shape,
            divisor,
            NOT_STATED if u is None else f"{u:.{places}f}",
        )
        for source, value, shape, divisor, u in parts
    )
    note = (
        "resolution / √12 (GUM F.2.2.1); calibration: the line indicator_uncertainty; "
        "combined as independent (GUM 5.1.2)"
    )
    header = (axis.name, f"stated [{axis.unit}]", "distribution", "divisor", f"u [{axis.unit}]")
    return Table(header, rows, note)
