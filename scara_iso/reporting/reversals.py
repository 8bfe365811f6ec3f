"""The report on the reversals in a run's readings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_iso.reporting.backlash import gear_blocks, gear_errors
from scara_iso.reporting.blocks import Block, Number, Section, Table, Text
from scara_iso.reporting.digits import rounded

if TYPE_CHECKING:
    from scara_iso.diagnosis import Reversal, RunReversals


def reversals_section(found: RunReversals) -> Section:
    """Return the half width of the reversal per payload, and what the model's gears leave of it."""
    blocks: list[Block] = []
    if found.missing:
        blocks.append(
            Text(f"not compared with the gears: the model lacks {', '.join(found.missing)}", "warn")
        )
    if found.gear is not None:
        blocks += [*gear_blocks(found.gear)]
    if found.reversals:
        blocks.append(_table(found.reversals))
    if found.gear is not None:
        blocks.append(gear_errors(found.gear, "mm", "each payload"))
    return Section("reversals and gears", (*blocks, *(Text(note) for note in found.notes)))


def _table(reversals: tuple[Reversal, ...]) -> Table:
    return Table(
        ("", "payload [kg]", "half width [mm]", "u [mm]", "model before [mm]", "model after [mm]"),
        tuple(
            (
                one.axis,
                Number(one.payload_kg, "g"),
                *(
                    "" if value is None else rounded(value, one.uncertainty_mm)
                    for value in (
                        one.half_width_mm,
                        one.uncertainty_mm,
                        one.predicted_before_mm,
                        one.predicted_after_mm,
                    )
                ),
            )
            for one in reversals
        ),
        "half width: (mean of approach +1 minus mean of approach -1) / 2",
    )
