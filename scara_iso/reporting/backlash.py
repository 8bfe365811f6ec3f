"""The report on the two-inertia model, and the paper's Table II.

The paper's printed figures beside those that its own Table I gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from scara_iso.iso9283 import PoseResult
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Number,
    Report,
    Section,
    Table,
    Text,
    U_of_RP,
    four_digits,
    p_equals,
    rounded,
    words,
)
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

if TYPE_CHECKING:
    from scara_iso.diagnosis import GearDiagnosis


def backlash_report(result: Backlash, actual: PoseResult | None = None) -> Report:
    """Return the report on a gear; ``actual`` is a measured pose to set beside it."""
    sections = [
        Section("", tuple(_verdict(result))),
        Section("two-inertia model", (_table(result),), depth="detail"),
    ]
    table = _comparison(result, actual)
    if table is not None:
        heading = "at the tool (the paper's Table II)"
        sections.append(Section(heading, (table,), depth="detail"))
    return (*sections, Section("", tuple(_assumptions(result)), depth="detail"))


def _verdict(result: Backlash) -> Iterator[Block]:
    yield Text("Backlash by the two-inertia model (paper, eq. 7-22)", "strong")
    for name, crossing in _crossings(result):
        width = (
            "" if crossing.deviation_mm is None else f", {_mm(crossing.deviation_mm)} at the tool"
        )
        yield Text(
            f"{name}: the load moves {four_digits(crossing.load_deviation_rad)} rad{width}: "
            f"1/{crossing.inertia_ratio:.6g} of the gap",
            "strong",
        )


def _crossings(result: Backlash) -> Iterator[tuple[str, Crossing]]:
    yield "I_m as given", result.as_given
    if result.reflected is not None:
        yield f"I_m through 1:{result.ratio:g}", result.reflected


def _table(result: Backlash) -> Table:
    crossings = list(_crossings(result))
    found = [crossing for _, crossing in crossings]
    rows = [
        ("gap 2D [rad] (eq. 18)", [four_digits(result.gap_rad)] * len(found)),
        ("I_m [kg m2]", [four_digits(c.motor_inertia) for c in found]),
        ("I_L [kg m2]", [four_digits(c.load_inertia) for c in found]),
        ("1 + I_L/I_m (eq. 20)", [Number(c.inertia_ratio, ".6g") for c in found]),
        ("load deviation [rad] (eq. 16)", [four_digits(c.load_deviation_rad) for c in found]),
        ("motor deviation [rad]", [four_digits(c.motor_deviation_rad) for c in found]),
    ]
    return Table(
        ("", *(name for name, _ in crossings)),
        tuple((label, *values) for label, values in rows),
    )


def _comparison(result: Backlash, actual: PoseResult | None) -> Table | None:
    """Return Table II, each row with what it is; None without an arm and a measurement."""
    rows = [
        (f"theoretical, {name} (eq. 21)", _mm(crossing.deviation_mm), "reversal width")
        for name, crossing in _crossings(result)
        if crossing.deviation_mm is not None
    ]
    if actual is not None and actual.XY is not None:
        rows.append(
            ("actual, radial (ISO 9283)", _measured(actual, actual.XY.RP), "one-sided scatter")
        )
        rows.append(("actual, eq. 23", _measured(actual, actual.XY.RP_rss), "one-sided scatter"))
    if result.free_play_mm is not None:
        rows.append(("free play (eq. 22)", _mm(result.free_play_mm), "whole gap"))
    if not rows:
        return None
    note = (
        "A reversal width (right contact to left contact) is not a one-sided scatter: a cycle that "
        "always arrives on the same flank shows none of the gap."
    )
    return Table(("", "at the tool", "what it is"), tuple(rows), note)


def _assumptions(result: Backlash) -> Iterator[Block]:
    if result.ratio is None:
        yield Text("I_m is taken as given, on the load's shaft; `ratio=N` reflects it there.")
    if result.arm_m is None:
        yield Text("Without `arm=` the width at the tool is not known.")
    assumed = "plastic impacts, no friction, no torque but the motor's (paper, section IV)"
    yield Text(f"assumed: {assumed}", "quiet")


def sweep_report(closed: GearDiagnosis) -> Report:
    """Return the report on a measured sweep: what eq. 16 leaves, and which effect it is."""
    blocks = [*gear_blocks(closed), gear_errors(closed, "rad", "each reversal")]
    return (Section("measured sweep", (*blocks, *(Text(line) for line in closed.notes))),)


def gear_blocks(closed: GearDiagnosis) -> Iterator[Block]:
    """Yield verdict and effects of a diagnosis of reversals."""
    near = ", ".join(words(r.effect) for r in closed.candidates)
    yield Text(
        f"{words(closed.verdict.value)} ({p_equals(closed)})"
        + (f": structure that no known effect fits; nearest: {near}" if near else ""),
        "strong",
    )
    for found in closed.effects:
        rivals = ", ".join(f"{words(r.effect)} ({r.probability:.0%})" for r in found.rivals)
        at = "" if found.joint is None else f" at joint {found.joint}"
        yield Text(
            f"{words(found.effect)}{at}: probability {found.probability:.0%}"
            + (f"; not excluded: {rivals}" if rivals else ""),
            "strong",
        )
        for name, value in found.parameters.items():
            yield Text(f"{name} {_between(value, found.intervals.get(name))}")
        yield Text(f"cause: {found.cause}")
        yield Text(f"confirm: {found.confirm_by}")


def gear_errors(closed: GearDiagnosis, unit: str, left_out: str) -> Table:
    """Return the error before and after, fitted and with ``left_out`` predicted unseen."""
    rows = (
        ("eq. 16", closed.error.before),
        ("with the effect", closed.error.after),
    )
    return Table(
        (f"rms error [{unit}]", "fitted", "held out"),
        tuple(
            (
                name,
                *("" if rms is None else Number(rms, ".2g") for rms in (of.rms, of.held_out_rms)),
            )
            for name, of in rows
        ),
        f"held out: {left_out} predicted without it, the choice of effect repeated",
    )


def _between(value: float, ends: tuple[float, float] | None) -> str:
    if ends is None:
        return f"{value:.3g}"
    U = (ends[1] - ends[0]) / 2
    return f"{rounded(value, U)} (95 %: {rounded(ends[0], U)} .. {rounded(ends[1], U)})"


def _measured(pose: PoseResult, RP: float) -> Number:
    assert pose.XY is not None  # noqa: S101 - the caller has seen it
    return rounded(RP, U_of_RP(pose.XY, len(pose.rows)), unit="mm")


def _mm(value: float | None) -> Number | str:
    return "" if value is None else four_digits(value, "mm")


def paper_section(table_1: PoseResult, gear: Backlash) -> Section:
    """Return the paper's printed figures (Tables I and II, eq. 21-23) beside recomputed ones.

    ``table_1`` is the analysis of the paper's Table I, ``gear`` its first joint.
    """
    x, reflected = table_1.axes["X"], gear.reflected
    rows = [
        ("l_bar X (eq. 4)", PRINTED_L_BAR_MM["X"], x.l_bar),
        ("S X (eq. 5)", PRINTED_S_MM["X"], x.S_l),
        *(
            (f"RP {name} (eq. 6)", printed, table_1.axes[name].RP)
            for name, printed in PRINTED_RP_MM.items()
        ),
        ("RP XY (eq. 23)", PRINTED_XY_MM, table_1.XY.RP_rss if table_1.XY else None),
        ("RP XY (ISO 9283, radial)", None, table_1.XY.RP if table_1.XY else None),
        ("deviation (eq. 21)", PRINTED_DEVIATION_MM, gear.as_given.deviation_mm),
        ("free play (eq. 22)", PRINTED_FREE_PLAY_MM, gear.free_play_mm),
        (f"through 1:{gear.ratio:g}", None, reflected.deviation_mm if reflected else None),
    ]
    table = Table(
        ("in mm", "printed", "recomputed", "recomputed/printed"),
        tuple(_row(label, printed, found) for label, printed, found in rows),
    )
    text = (
        "The paper's RP do not follow from its own table; this tool prints what the readings give."
    )
    return Section("which printed figures of the paper follow from its data", (Text(text), table))


def _row(label: str, printed: float | None, found: float | None) -> tuple[Cell, ...]:
    if found is None:
        return (label, "", "", "")
    if printed is None:
        return (label, "-", four_digits(found), "")
    return (label, four_digits(printed), four_digits(found), Number(found / printed, ".2f"))
