"""The report on a planned test: what it will find, what it cannot tell apart, what helps."""

from __future__ import annotations

from collections.abc import Sequence

from scara_iso.diagnosis import Design, PlannedRun, Smallest
from scara_iso.reporting.blocks import Number, Report, Section, Table, Text
from scara_iso.reporting.digits import decimals
from scara_iso.reporting.words import words


def design_report(plan: PlannedRun, found: Design) -> Report:
    """Return the smallest effects, with the gain of each change of plan beside them."""
    return (
        Section("", tuple(_head(plan))),
        Section("smallest travel found in 80 % of tests [mm]", (_table(plan, found),)),
        Section("cannot be told apart", tuple(_alike(found))),
    )


def _head(plan: PlannedRun) -> list[Text]:
    columns = ", ".join(plan.conditions.covariates) or "none"
    return [
        Text("what this test will be able to tell", "strong"),
        Text(
            f"{len(plan.conditions)} cycles, scatter {plan.sigma:g} mm, dial {plan.division:g} mm, "
            f"columns: {columns}"
        ),
        Text("travel: lowest to highest reading of an effect, without scatter", "quiet"),
    ]


def _table(plan: PlannedRun, found: Design) -> Table:
    columns = [found.smallest, *(change.smallest for change in found.changes)]
    names = list(dict.fromkeys(one.effect for column in columns for one in column))
    places = decimals([plan.sigma])
    rows = tuple(
        (words(name), *(_travel(column, name, places) for column in columns)) for name in names
    )
    letters = [chr(ord("a") + k) for k in range(len(found.changes))]
    notes = "; ".join(f"{k}: {c.change}" for k, c in zip(letters, found.changes, strict=True))
    return Table(("effect", "as planned", *letters), rows, notes)


def _travel(column: Sequence[Smallest], name: str, places: int) -> Number | str:
    for one in column:
        if one.effect == name:
            return "-" if one.travel is None else Number(one.travel, f".{places}f")
    return ""


def _alike(found: Design) -> list[Text]:
    if not found.alike:
        return [Text("every pair of effects has shapes that differ")]
    return [
        Text(f"{words(a.first)} and {words(a.second)} (cosine {a.cosine:.2f})") for a in found.alike
    ]
