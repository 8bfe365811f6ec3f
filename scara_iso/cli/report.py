"""``scara-iso report``: the whole test on paper, for those who sign and those who read it."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from scara_iso import library, render, reporting
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AllCount,
    AllowGaps,
    AsJson,
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
from scara_iso.iso9283 import Conformity, DecisionRule

ModelFile = Annotated[
    str | None,
    typer.Option("--model", metavar="MODEL", help="Model file: diagnosis and backlash with it."),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", help=f"File, by its ending: {' '.join(render.endings())}; else "
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
    excel_locale: ExcelLocale = None,
    json: AsJson = False,
) -> None:
    """Write the test report: result, pictures, every intermediate value, diagnosis, raw data.

    Example: scara-iso report run.csv --model robot.toml -o report.html
    """
    path = output or (None if json else Path(f"{_stem(table)}.html"))
    check_outputs([path], [table, model])
    found = library.report(
        table,
        model=model,
        to=path,
        pose=pose,
        limits=parse_limits(limit or ()),
        decision=decision.value,
        unit=unit,
        resolution=resolution,
        decimal=decimal,
        sheet=sheet,
        first_cycle_discarded=first_cycle_discarded,
        cycles=cycles,
        all_count=all_count,
        allow_gaps=allow_gaps,
        excel_locale=excel_locale,
        command=shlex.join(("scara-iso", *settings.arguments)),
    )
    if path is not None:
        typer.echo(reporting.printable(f"{path} is written"), err=json)
    if json:
        write_json(render.report_json(found.dossier))
    if found.analysis.conformity not in (None, Conformity.PASS):
        said = "; ".join(block.text for block in reporting.conformity(found.analysis))
        typer.echo(reporting.printable(f"scara-iso: {said}"), err=True)
        raise typer.Exit(NOT_WITHIN_LIMITS)


def _stem(table: str) -> str:
    return "report" if table == "-" else Path(table).stem
