"""The two-inertia model, measured reversals beside it, and which of the paper's figures follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from scara_iso.base.published import Size
from scara_iso.diagnosis import BacklashResult
from scara_iso.iso9283 import Analysis, Millimetres, PoseResult
from scara_iso.reporting.named_effects import probability_in_words
from scara_iso.reporting.shared.blocks import Block, Columns, Report, Section, Table, Text, note
from scara_iso.reporting.shared.digits import (
    Cell,
    Number,
    four_digits,
    p_equals,
    result,
    rounded,
    share,
    words,
)
from scara_iso.robot import PRINTED_MM, PRINTED_RP_MM, Backlash, Crossing
from scara_iso.run import AxisKey

if TYPE_CHECKING:
    from scara_iso.diagnosis import GearDiagnosis, Reversal, RunReversals


def backlash_report(found: Backlash, actual: PoseResult | None = None) -> Report:
    """Return the report on a gear; ``actual`` is a measured pose to set beside it."""
    crossings = {"I_m as given": found.as_given}
    if found.reflected is not None:
        crossings[f"I_m through 1:{found.ratio:g}"] = found.reflected
    verdict = [Text("Backlash by the two-inertia model (paper, eq. 7-22)", "strong")]
    for name, crossing in crossings.items():
        mm = crossing.deviation_mm
        width = "" if mm is None else f", {four_digits(mm)} mm at the tool"
        moves = f"{name}: the load moves {four_digits(crossing.load_deviation_rad)} rad{width}"
        verdict.append(Text(f"{moves}: 1/{crossing.inertia_ratio:.6g} of the gap", "strong"))
    model: Columns[tuple[str, Crossing]] = {
        "model": lambda row: row[0],
        "I_m [kg m2]": lambda row: four_digits(row[1].motor_inertia),
        "I_L [kg m2]": lambda row: four_digits(row[1].load_inertia),
        "1 + I_L/I_m (eq. 20)": lambda row: Number(row[1].inertia_ratio, ".6g"),
        "load [rad] (eq. 16)": lambda row: four_digits(row[1].load_deviation_rad),
        "motor [rad]": lambda row: four_digits(row[1].motor_deviation_rad),
    }
    gap = f"gap 2D = {four_digits(found.gap_rad)} rad (eq. 18); load and motor: their deviations"
    notes = (
        Text(note("inertia_as_given") if found.ratio is None else ""),
        Text("Without `arm=` the width at the tool is not known." if found.arm_m is None else ""),
        Text(note("two_inertias"), "quiet"),
    )
    at_tool = _at_tool(found, crossings, actual)
    return (
        Section("", tuple(verdict)),
        Section("two-inertia model", (Table.of(crossings.items(), model, gap),), depth="detail"),
        Section("at the tool (the paper's Table II)", (at_tool,), depth="detail"),
        Section("", notes, depth="detail"),
    )


def _at_tool(
    found: Backlash, crossings: Mapping[str, Crossing], actual: PoseResult | None
) -> Table:
    rows: list[tuple[str, Cell, str]] = [
        (f"theoretical, {name} (eq. 21)", four_digits(one.deviation_mm, "mm"), "reversal width")
        for name, one in crossings.items()
        if one.deviation_mm is not None
    ]
    if actual is not None and (XY := actual.XY) is not None:
        radial = result(XY.RP, XY.RP_interval, "mm")
        rss = result(XY.RP_rss, XY.RP_rss_interval, "mm")
        rows.append(("actual, radial (ISO 9283)", radial, "one-sided scatter"))
        rows.append(("actual, eq. 23", rss, "one-sided scatter"))
    if found.free_play_mm is not None:
        rows.append(("free play (eq. 22)", four_digits(found.free_play_mm, "mm"), "whole gap"))
    return Table(("", "at the tool", "what it is"), tuple(rows), note("reversal_width"))


def sweep_report(closed: GearDiagnosis) -> Report:
    """Return the report on a measured sweep: what eq. 16 leaves, and which effect it is."""
    blocks = (*_gear_blocks(closed), *_gear_errors(closed, "rad", "each reversal"))
    return (Section("measured sweep", (*blocks, *map(Text, closed.notes))),)


def reversals_section(found: RunReversals) -> Section:
    """Return the half width of the reversal per payload, and what the model's gears leave of it."""
    missing = f"not compared with the gears: the model lacks {', '.join(found.missing)}"
    columns: Columns[Reversal] = {
        "": lambda one: one.axis,
        "payload [kg]": lambda one: Number(one.payload_kg, "g"),
        "half width [mm]": lambda one: rounded(one.half_width_mm, one.uncertainty_mm),
        "u [mm]": lambda one: rounded(one.uncertainty_mm, one.uncertainty_mm),
        "model before [mm]": lambda one: _to_u(one, one.predicted_before_mm),
        "model after [mm]": lambda one: _to_u(one, one.predicted_after_mm),
    }
    note = "half width: (mean of approach +1 minus mean of approach -1) / 2"
    blocks = (
        Text(missing if found.missing else "", "warn"),
        *_gear_blocks(found.gear),
        Table.of(found.reversals, columns, note),
        *_gear_errors(found.gear, "mm", "each payload"),
        *map(Text, found.notes),
    )
    return Section("reversals and gears", blocks)


def _to_u(one: Reversal, value: float | None) -> Cell:
    return "" if value is None else rounded(value, one.uncertainty_mm)


def _gear_blocks(closed: GearDiagnosis | None) -> Iterator[Block]:
    if closed is None:
        return
    near = ", ".join(words(r.effect) for r in closed.candidates)
    nearest = f": structure that no known effect fits; nearest: {near}" if near else ""
    yield Text(f"{words(closed.verdict.value)} ({p_equals(closed)}){nearest}", "strong")
    for found in closed.effects:
        at = "" if found.joint is None else f" at joint {found.joint}"
        sure = probability_in_words(found.probability, found.rivals)
        yield Text(f"{words(found.effect)}{at}: {sure}", "strong")
        for name, value in found.parameters.items():
            yield Text(f"{name} {result(value, found.intervals.get(name))}")
        yield Text(f"cause: {found.cause}")
        yield Text(f"confirm: {found.confirm_by}")


def _gear_errors(closed: GearDiagnosis | None, unit: str, left_out: str) -> Iterator[Table]:
    if closed is not None:
        errors = {"eq. 16": closed.error.before, "with the effect": closed.error.after}
        columns: Columns[tuple[str, Any]] = {
            f"rms error [{unit}]": lambda row: row[0],
            "fitted": lambda row: share(row[1].rms, ".2g"),
            "held out": lambda row: share(row[1].held_out_rms, ".2g"),
        }
        note = f"held out: {left_out} predicted without it, the choice of effect repeated"
        yield Table.of(errors.items(), columns, note)


def paper_section(table_1: PoseResult, gear: Backlash) -> Section:
    """Return the paper's printed figures (Tables I and II, eq. 21-23) beside recomputed ones.

    ``table_1`` is the analysis of the paper's Table I, ``gear`` its first joint.
    """
    x, XY, reflected = table_1.axes["X"], table_1.XY, gear.reflected
    figures: list[tuple[str, float | None, float | None]] = [
        ("l_bar X (eq. 4)", PRINTED_MM["l_bar X"], x.l_bar),
        ("S X (eq. 5)", PRINTED_MM["S X"], x.S_l),
        *(
            (f"RP {name} (eq. 6)", printed, table_1.axes[name].RP)
            for name, printed in PRINTED_RP_MM.items()
        ),
        ("RP XY (eq. 23)", PRINTED_MM["XY"], XY.RP_rss if XY else None),
        ("RP XY (ISO 9283, radial)", None, XY.RP if XY else None),
        ("deviation (eq. 21)", PRINTED_MM["deviation"], gear.as_given.deviation_mm),
        ("free play (eq. 22)", PRINTED_MM["play"], gear.free_play_mm),
        (f"through 1:{gear.ratio:g}", None, reflected.deviation_mm if reflected else None),
    ]
    columns: Columns[tuple[str, float | None, float | None]] = {
        "in mm": lambda row: row[0],
        "printed": lambda row: four_digits(row[1]) if row[1] else "-",
        "recomputed": lambda row: four_digits(row[2]),
        "recomputed/printed": lambda row: (
            share(row[2] / row[1], ".2f") if row[1] and row[2] else ""
        ),
    }
    text = (
        "The paper's RP do not follow from its own table; this tool prints what the readings give."
    )
    heading = "which printed figures of the paper follow from its data"
    return Section(heading, (Text(text), Table.of(figures, columns)))


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedFigures:
    """What the paper prints."""

    RP: Mapping[AxisKey, Size] = field(default_factory=lambda: PRINTED_RP_MM)
    """By axis, of Table I: lengths in mm, theta in degrees."""
    RP_rss: Millimetres = PRINTED_MM["XY"]
    """Eq. 23."""
    deviation_mm: Millimetres = PRINTED_MM["deviation"]
    """Eq. 21."""
    free_play_mm: Millimetres = PRINTED_MM["play"]
    """Eq. 22."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedDemo:
    """The paper's Table I and first joint."""

    schema: Literal["scara-iso/demo/1"] = "scara-iso/demo/1"
    """Name and number of this schema."""
    analysis: Analysis
    """Of Table I, as in `analyze`."""
    backlash: BacklashResult
    """Of the first joint, as in `backlash`."""
    printed: PrintedFigures = field(default_factory=PrintedFigures)
    """To be set beside those figures."""
