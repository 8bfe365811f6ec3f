"""``scara-iso report``: the whole test on paper, for those who sign and those who read it."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from scara_iso.cli.folders import is_folder
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AllCount,
    AllowGaps,
    AsJson,
    ConditionName,
    CyclesRun,
    DecimalMark,
    ExcelLocale,
    FirstDiscarded,
    LimitRule,
    Limits,
    ResolutionOfTable,
    Sheet,
    Table,
    UnitOfTable,
    parse_limits,
)
from scara_iso.cli.output import check_outputs, settings, write_json
from scara_iso.disk import write_file
from scara_iso.iso9283 import Conformity, DecisionRule
from scara_iso.render import endings

ModelFile = Annotated[
    str | None,
    typer.Option("--model", metavar="MODEL", help="Model file: diagnosis and backlash with it."),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", help=f"File, by its ending: {' '.join(endings())}; else "
        "TABLE's name with .html, in this folder.",
    ),
]  # fmt: skip
Pose = Annotated[str | None, typer.Option(help="Only this pose, where the table has several.")]


def report_command(
    table: Table,
    *,
    model: ModelFile = None,
    output: Output = None,
    pose: Pose = None,
    limit: Limits = None,
    decision: LimitRule = DecisionRule.INTERVAL,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    sheet: Sheet = None,
    first_cycle_discarded: FirstDiscarded = False,
    cycles: CyclesRun = None,
    all_count: AllCount = False,
    allow_gaps: AllowGaps = False,
    condition: ConditionName = None,
    excel_locale: ExcelLocale = None,
    json: AsJson = False,
) -> None:
    """Write the test report: result, pictures, every intermediate value, diagnosis, raw data.

    Example: scara-iso report run.csv --model robot.toml -o report.html
    """
    from scara_iso.library import TableOptions, report, writer
    from scara_iso.reporting import printable

    reading = TableOptions(unit, resolution, decimal, sheet)
    options: dict[str, Any] = {
        "model": model,
        "pose": pose,
        "limits": parse_limits(limit or ()),
        "decision": decision.value,
        "first_cycle_discarded": first_cycle_discarded,
        "cycles": cycles,
        "all_count": all_count,
        "allow_gaps": allow_gaps,
    }
    if is_folder(table, condition, reading):
        from scara_iso.cli.conditions import report_folder

        report_folder(table, condition, output, options, excel_locale=excel_locale, as_json=json)
        return
    path = output or (None if json else Path(f"{_stem(table)}.html"))
    write = None if path is None else writer(path, excel_locale)
    check_outputs([path], [table, model])
    command = shlex.join(("scara-iso", *settings.arguments))
    dossier = report(table, **asdict(reading), **options, command=command).dossier
    if path is not None and write is not None:
        write_file(path, write(dossier))
        typer.echo(printable(f"{path} is written"), err=json)
    if json:
        from scara_iso.render import report_json

        write_json(report_json(dossier))
    if dossier.analysis.conformity not in (None, Conformity.PASS):
        from scara_iso.reporting import conformity

        said = "; ".join(block.text for block in conformity(dossier.analysis))
        typer.echo(printable(f"scara-iso: {said}"), err=True)
        raise typer.Exit(NOT_WITHIN_LIMITS)


def _stem(table: str) -> str:
    return "report" if table == "-" else Path(table).stem
