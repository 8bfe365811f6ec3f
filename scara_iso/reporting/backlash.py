"""The two-inertia model, measured reversals beside it, and which of the paper's figures follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from scara_iso.base.published import Size
from scara_iso.diagnosis import BacklashResult
from scara_iso.iso9283 import Analysis, Millimetres, PoseResult
from scara_iso.reporting.blocks import Block, Columns, Report, Section, Table, Text, tabulated
from scara_iso.reporting.digits import (
    Cell,
    Number,
    U_of_RP,
    four_digits,
    half_of,
    p_equals,
    rounded,
    words,
)
from scara_iso.reporting.named_effects import probability_in_words
from scara_iso.robot import (
    PRINTED_DEVIATION_MM,
    PRINTED_FREE_PLAY_MM,
    PRINTED_L_BAR_MM,
    PRINTED_RP_MM,
    PRINTED_S_MM,
    PRINTED_XY_MM,
    Backlash,
    Crossing,
)
from scara_iso.run import AxisKey

if TYPE_CHECKING:
    from scara_iso.diagnosis import GearDiagnosis, Reversal, RunReversals

_WIDTH_IS_NO_SCATTER = (
    "A reversal width (right contact to left contact) is not a one-sided scatter: a cycle that "
    "always arrives on the same flank shows none of the gap."
)


def backlash_report(result: Backlash, actual: PoseResult | None = None) -> Report:
    """Return the report on a gear; ``actual`` is a measured pose to set beside it."""
    crossings = {"I_m as given": result.as_given}
    if result.reflected is not None:
        crossings[f"I_m through 1:{result.ratio:g}"] = result.reflected
    verdict = [Text("Backlash by the two-inertia model (paper, eq. 7-22)", "strong")]
    for name, crossing in crossings.items():
        mm = crossing.deviation_mm
        width = "" if mm is None else f", {four_digits(mm)} mm at the tool"
        moves = f"{name}: the load moves {four_digits(crossing.load_deviation_rad)} rad{width}"
        verdict.append(Text(f"{moves}: 1/{crossing.inertia_ratio:.6g} of the gap", "strong"))
    assumed = "plastic impacts, no friction, no torque but the motor's (paper, section IV)"
    given = "I_m is taken as given, on the load's shaft; `ratio=N` reflects it there."
    no_arm = "Without `arm=` the width at the tool is not known."
    notes = (
        Text(given if result.ratio is None else ""),
        Text(no_arm if result.arm_m is None else ""),
        Text(f"assumed: {assumed}", "quiet"),
    )
    at_tool = _at_tool(result, crossings, actual)
    return (
        Section("", tuple(verdict)),
        Section("two-inertia model", (_model(result, crossings),), depth="detail"),
        Section("at the tool (the paper's Table II)", (at_tool,), depth="detail"),
        Section("", notes, depth="detail"),
    )


def _model(result: Backlash, crossings: Mapping[str, Crossing]) -> Table:
    found = crossings.values()
    rows = {
        "gap 2D [rad] (eq. 18)": [four_digits(result.gap_rad)] * len(found),
        "I_m [kg m2]": [four_digits(c.motor_inertia) for c in found],
        "I_L [kg m2]": [four_digits(c.load_inertia) for c in found],
        "1 + I_L/I_m (eq. 20)": [Number(c.inertia_ratio, ".6g") for c in found],
        "load deviation [rad] (eq. 16)": [four_digits(c.load_deviation_rad) for c in found],
        "motor deviation [rad]": [four_digits(c.motor_deviation_rad) for c in found],
    }
    return Table(("", *crossings), tuple((label, *values) for label, values in rows.items()))


def _at_tool(
    result: Backlash, crossings: Mapping[str, Crossing], actual: PoseResult | None
) -> Table:
    """Return Table II, each row with what it is; empty without an arm and a measurement."""
    rows = [
        (f"theoretical, {name} (eq. 21)", four_digits(one.deviation_mm, "mm"), "reversal width")
        for name, one in crossings.items()
        if one.deviation_mm is not None
    ]
    if actual is not None and actual.XY is not None:
        U = U_of_RP(actual.XY, len(actual.rows))
        figures = {"radial (ISO 9283)": actual.XY.RP, "eq. 23": actual.XY.RP_rss}
        rows += [
            (f"actual, {name}", rounded(RP, U, unit="mm"), "one-sided scatter")
            for name, RP in figures.items()
        ]
    if result.free_play_mm is not None:
        rows.append(("free play (eq. 22)", four_digits(result.free_play_mm, "mm"), "whole gap"))
    return Table(("", "at the tool", "what it is"), tuple(rows), _WIDTH_IS_NO_SCATTER)


def sweep_report(closed: GearDiagnosis) -> Report:
    """Return the report on a measured sweep: what eq. 16 leaves, and which effect it is."""
    blocks = (*_gear_blocks(closed), _gear_errors(closed, "rad", "each reversal"))
    return (Section("measured sweep", (*blocks, *map(Text, closed.notes))),)


def reversals_section(found: RunReversals) -> Section:
    """Return the half width of the reversal per payload, and what the model's gears leave of it."""
    missing = f"not compared with the gears: the model lacks {', '.join(found.missing)}"
    columns: Columns[Reversal] = {
        "": lambda one: one.axis,
        "payload [kg]": lambda one: Number(one.payload_kg, "g"),
        "half width [mm]": lambda one: _to_u(one, one.half_width_mm),
        "u [mm]": lambda one: _to_u(one, one.uncertainty_mm),
        "model before [mm]": lambda one: _to_u(one, one.predicted_before_mm),
        "model after [mm]": lambda one: _to_u(one, one.predicted_after_mm),
    }
    note = "half width: (mean of approach +1 minus mean of approach -1) / 2"
    gear = found.gear
    blocks = (
        Text(missing if found.missing else "", "warn"),
        *([] if gear is None else _gear_blocks(gear)),
        tabulated(found.reversals, columns, note),
        *([] if gear is None else [_gear_errors(gear, "mm", "each payload")]),
        *map(Text, found.notes),
    )
    return Section("reversals and gears", blocks)


def _to_u(one: Reversal, value: float | None) -> Cell:
    return "" if value is None else rounded(value, one.uncertainty_mm)


def _gear_blocks(closed: GearDiagnosis) -> Iterator[Block]:
    """Yield verdict and effects of a diagnosis of reversals."""
    near = ", ".join(words(r.effect) for r in closed.candidates)
    nearest = f": structure that no known effect fits; nearest: {near}" if near else ""
    yield Text(f"{words(closed.verdict.value)} ({p_equals(closed)}){nearest}", "strong")
    for found in closed.effects:
        at = "" if found.joint is None else f" at joint {found.joint}"
        yield Text(
            f"{words(found.effect)}{at}: {probability_in_words(found.probability, found.rivals)}",
            "strong",
        )
        for name, value in found.parameters.items():
            yield Text(f"{name} {_with_ends(value, found.intervals.get(name))}")
        yield Text(f"cause: {found.cause}")
        yield Text(f"confirm: {found.confirm_by}")


def _gear_errors(closed: GearDiagnosis, unit: str, left_out: str) -> Table:
    """Return the error before and after, fitted and with ``left_out`` predicted unseen."""
    errors = {"eq. 16": closed.error.before, "with the effect": closed.error.after}
    rows = tuple(
        (name, *("" if x is None else Number(x, ".2g") for x in (one.rms, one.held_out_rms)))
        for name, one in errors.items()
    )
    note = f"held out: {left_out} predicted without it, the choice of effect repeated"
    return Table((f"rms error [{unit}]", "fitted", "held out"), rows, note)


def _with_ends(value: float, ends: tuple[float, float] | None) -> str:
    if ends is None:
        return f"{value:.3g}"
    shown, low, high = (rounded(x, half_of(ends)) for x in (value, *ends))
    return f"{shown} (95 %: {low} .. {high})"


def paper_section(table_1: PoseResult, gear: Backlash) -> Section:
    """Return the paper's printed figures (Tables I and II, eq. 21-23) beside recomputed ones.

    ``table_1`` is the analysis of the paper's Table I, ``gear`` its first joint.
    """
    x, XY, reflected = table_1.axes["X"], table_1.XY, gear.reflected
    figures: list[tuple[str, float | None, float | None]] = [
        ("l_bar X (eq. 4)", PRINTED_L_BAR_MM["X"], x.l_bar),
        ("S X (eq. 5)", PRINTED_S_MM["X"], x.S_l),
        *(
            (f"RP {name} (eq. 6)", printed, table_1.axes[name].RP)
            for name, printed in PRINTED_RP_MM.items()
        ),
        ("RP XY (eq. 23)", PRINTED_XY_MM, XY.RP_rss if XY else None),
        ("RP XY (ISO 9283, radial)", None, XY.RP if XY else None),
        ("deviation (eq. 21)", PRINTED_DEVIATION_MM, gear.as_given.deviation_mm),
        ("free play (eq. 22)", PRINTED_FREE_PLAY_MM, gear.free_play_mm),
        (f"through 1:{gear.ratio:g}", None, reflected.deviation_mm if reflected else None),
    ]
    rows: list[tuple[Cell, ...]] = []
    for label, printed, found in figures:
        ratio: Cell = Number(found / printed, ".2f") if found and printed else ""
        shown: Cell = four_digits(printed) if printed else "-"
        rows.append((label, *((shown, four_digits(found), ratio) if found else ("", "", ""))))
    header = ("in mm", "printed", "recomputed", "recomputed/printed")
    text = (
        "The paper's RP do not follow from its own table; this tool prints what the readings give."
    )
    heading = "which printed figures of the paper follow from its data"
    return Section(heading, (Text(text), Table(header, tuple(rows))))


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedFigures:
    """What the paper prints."""

    RP: Mapping[AxisKey, Size] = field(default_factory=lambda: PRINTED_RP_MM)
    """By axis, of Table I: lengths in mm, theta in degrees."""
    RP_rss: Millimetres = PRINTED_XY_MM
    """Eq. 23."""
    deviation_mm: Millimetres = PRINTED_DEVIATION_MM
    """Eq. 21."""
    free_play_mm: Millimetres = PRINTED_FREE_PLAY_MM
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
