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
    AsJson,
    ConditionName,
    Full,
    LimitRule,
    Limits,
    Tables,
    parse_limits,
    takes_tables,
)
from scara_iso.cli.output import command_line, write_json, write_report
from scara_iso.iso9283 import Analysis, Conformity, Counting, DecisionRule
from scara_iso.library import TableOptions


@takes_tables
def analyze_command(
    table: Tables,
    *,
    limit: Limits = None,
    decision: LimitRule = DecisionRule.INTERVAL,
    definitions: Annotated[
        bool, typer.Option("--definitions", help="Also half range, 2 s, 3 s and ISO 230-2.")
    ] = False,
    reading: TableOptions,
    counting: Counting,
    condition: ConditionName = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Repeatability of each pose, axis and plane, with intervals and findings.

    Example: scara-iso analyze run.csv --limit XY=0.02
    """
    options: dict[str, Any] = {
        "limits": parse_limits(limit or ()),
        "decision": decision.value,
        "other_definitions": definitions,
    }
    if (folder := test_folder(table, condition, reading)) is not None:
        from scara_iso.cli.conditions import analyze_folder

        options["counting"] = counting
        analyze_folder(folder, condition, options, as_json=json, full=full)
        return
    read = asdict(reading) | asdict(counting)
    analysis = library.analyze(table, **read, **options)
    if json:
        write_json(render.analysis_json(analysis))
    else:
        following = _next(analysis, table, read, limit, decision)
        write_report(reporting.analysis_report(analysis, following), full=full)
    if analysis.conformity not in (None, Conformity.PASS):
        raise typer.Exit(NOT_WITHIN_LIMITS)


def _next(
    analysis: Analysis,
    table: Sequence[str],
    read: Mapping[str, object],
    limit: Sequence[str] | None,
    decision: DecisionRule,
) -> reporting.NextStep:
    """Return what to do next, as a command line with the options of this one."""
    simple = decision is DecisionRule.SIMPLE
    held = {"limit": limit, "decision": decision.value if simple else None}
    again, whole = command_line(table, read), command_line(table, {**held, **read})
    axis = reporting.axis_of_loop(analysis)
    loop = command_line(table, {"axis": axis, **{k: read[k] for k in ("unit", "resolution")}})
    return reporting.after_analysis(analysis, whole, again, None if axis is None else loop)
