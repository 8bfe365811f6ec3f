"""The uncertainty budget: what a reading is uncertain by, and what nobody stated."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

from scara_iso.base.published import Size, Unit
from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.iso9283 import Analysis
from scara_iso.reporting.blocks import Block, Cell, Number, Table, Text
from scara_iso.reporting.digits import rounded
from scara_iso.reporting.stated import NOT_STATED
from scara_iso.run import Axis, Run

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
        tuple(map(_row, lines)),
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
    said = (text for key, text in run.metadata.items() if key.startswith(f"corrected_{axis}"))
    return any("cosine" in text for text in said)


def _corrections(run: Run) -> Iterator[Text]:
    found = [axis for axis in run.axes.values() if axis.displayed is not None]
    if found:
        said = [
            f"{axis.name} {0.0 if axis.uncertainty is None else axis.uncertainty:.2g} {axis.unit} "
            f"with {NOT_STATED if axis.certified is None else f'{axis.certified:.2g}'} of the "
            "certificate"
            for axis in found
        ]
        names = ", ".join(axis.name for axis in found)
        yield Text(_CORRECTED.format(axes=names, each="; ".join(said)))


def _line(axis: Axis, u: float | None) -> UncertaintyLine:
    rounding = None if axis.resolution is None else rounding_uncertainty(axis.resolution)
    U = None if u is None else 2 * u
    unit = cast(Unit, axis.unit)
    return UncertaintyLine(axis.name, unit, axis.resolution, rounding, axis.uncertainty, u, U)


def _row(line: UncertaintyLine) -> tuple[Cell, ...]:
    stated = NOT_STATED if line.resolution is None else Number(line.resolution, "g")
    parts = (line.u_resolution, line.u_calibration, line.u, line.U)
    said = [NOT_STATED if u is None else rounded(u, u) for u in parts]
    return (line.axis, stated, *said, line.unit)
