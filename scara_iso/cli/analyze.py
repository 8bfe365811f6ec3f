"""``scara-iso analyze``: repeatability of a table of readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Annotated, Any

import typer

from scara_iso import library, render, reporting
from scara_iso.cli.folders import test_folder
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AllCount,
    AllowGaps,
    AsJson,
    ColumnsByPosition,
    ConditionName,
    CyclesRun,
    DecimalMark,
    FirstDiscarded,
    Full,
    LimitRule,
    Limits,
    ResolutionOfTable,
    Sheet,
    Tables,
    UnitOfTable,
    parse_limits,
)
from scara_iso.cli.output import command_line, write_json, write_report
from scara_iso.iso9283 import Analysis, Conformity, DecisionRule


def analyze_command(
    table: Tables,
    *,
    limit: Limits = None,
    decision: LimitRule = DecisionRule.INTERVAL,
    definitions: Annotated[
        bool, typer.Option("--definitions", help="Also half range, 2 s, 3 s and ISO 230-2.")
    ] = False,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    sheet: Sheet = None,
    columns: ColumnsByPosition = None,
    first_cycle_discarded: FirstDiscarded = False,
    cycles: CyclesRun = None,
    all_count: AllCount = False,
    allow_gaps: AllowGaps = False,
    condition: ConditionName = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Repeatability of each pose, axis and plane, with intervals and findings.

    Example: scara-iso analyze run.csv --limit XY=0.02
    """
    reading = library.TableOptions(unit, resolution, decimal, sheet, columns)
    counted: dict[str, Any] = {
        "first_cycle_discarded": first_cycle_discarded, "cycles": cycles, "all_count": all_count,
        "allow_gaps": allow_gaps,
    }  # fmt: skip
    options = counted | {
        "limits": parse_limits(limit or ()), "decision": decision.value,
        "other_definitions": definitions,
    }  # fmt: skip
    if (folder := test_folder(table, condition, reading)) is not None:
        from scara_iso.cli.conditions import analyze_folder

        analyze_folder(folder, condition, options, as_json=json, full=full)
        return
    analysis = library.analyze(table, **asdict(reading), **options)
    if json:
        write_json(render.analysis_json(analysis))
    elif full:
        write_report(reporting.analysis_report(analysis))
    else:
        _write_brief(analysis, table, asdict(reading) | counted, limit, decision)
    if analysis.conformity not in (None, Conformity.PASS):
        raise typer.Exit(NOT_WITHIN_LIMITS)


def _write_brief(
    analysis: Analysis,
    table: Sequence[str],
    read: Mapping[str, object],
    limit: Sequence[str] | None,
    decision: DecisionRule,
) -> None:
    """Write the answer and what to do next, as a command line with the options of this one."""
    simple = decision is DecisionRule.SIMPLE
    held = {"limit": limit, "decision": decision.value if simple else None}
    again, whole = command_line(table, read), command_line(table, {**held, **read})
    axis = reporting.axis_of_loop(analysis)
    loop = command_line(table, {"axis": axis, **{k: read[k] for k in ("unit", "resolution")}})
    following = reporting.after_analysis(analysis, whole, again, None if axis is None else loop)
    write_report(reporting.analysis_brief(analysis, following))
