"""``scara-iso report``: the whole test on paper, for those who sign and those who read it."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scara_iso import library, render, reporting
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import to_json
from scara_iso.cli.folders import test_folder
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AsJson,
    ConditionName,
    ExcelLocale,
    LimitRule,
    Limits,
    OwnEffectsFile,
    Tables,
    parse_limits,
    takes_tables,
)
from scara_iso.cli.output import (
    check_outputs,
    say_limits,
    say_written,
    settings,
    tell,
    write_json,
)
from scara_iso.iso9283 import Analysis, Conformity, Counting, DecisionRule
from scara_iso.library import TableOptions

if TYPE_CHECKING:
    from scara_iso.library import TestReport

ModelFile = Annotated[
    str | None,
    typer.Option("--model", metavar="MODEL", help="Model file: diagnosis and backlash with it."),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        help=f"File, by its ending: {' '.join(render.endings())}; else "
        "TABLE's name with .html, in this folder.",
    ),
]
Meta = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=VALUE", help="State or override a field of the report. May be repeated."
    ),
]
MetaFile = Annotated[
    Path | None, typer.Option(metavar="FILE.toml", help="Lines key = value, stated likewise.")
]
Archive = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.zip", help="The evidence: table, raw file, model, report, versions, hashes."
    ),
]
Supersedes = Annotated[
    str | None,
    typer.Option(metavar="NUMBER", help="Number of the report that this one stands in place of."),
]
Reason = Annotated[str | None, typer.Option(help="Why it does.")]
Pose = Annotated[str | None, typer.Option(help="Only this pose, where the table has several.")]


@takes_tables
def report_command(
    table: Tables,
    *,
    model: ModelFile = None,
    effects: OwnEffectsFile = None,
    output: Output = None,
    pose: Pose = None,
    limit: Limits = None,
    decision: LimitRule = DecisionRule.INTERVAL,
    reading: TableOptions,
    counting: Counting,
    condition: ConditionName = None,
    excel_locale: ExcelLocale = None,
    meta: Meta = None,
    meta_file: MetaFile = None,
    supersedes: Supersedes = None,
    reason: Reason = None,
    archive: Archive = None,
    json: AsJson = False,
) -> None:
    """Write the test report: result, pictures, every intermediate value, diagnosis, raw data.

    Example: scara-iso report run.csv --model robot.toml -o report.html
    """
    path = output or (None if json else Path(f"{_stem(table)}.html"))
    read = [*table, model, effects, None if meta_file is None else str(meta_file)]
    if path is not None:
        library.check_format(path, excel_locale)
    check_outputs([output, archive], read)
    options: dict[str, Any] = {
        "model": model,
        "own_effects": effects,
        "pose": pose,
        "limits": parse_limits(limit or ()),
        "decision": decision.value,
        **asdict(counting),
        "excel_locale": excel_locale,
        "metadata": _metadata(meta or (), meta_file),
        "supersedes": supersedes,
        "reason": reason,
        "command": shlex.join(("scara-iso", *settings.arguments)),
    }
    if (folder := test_folder(table, condition, reading)) is not None:
        from scara_iso.cli.conditions import report_folder

        report_folder(folder, condition, output, archive, options, as_json=json)
        return
    check_outputs([path, archive], read)
    found = library.report(table, to=path, **asdict(reading), **options)
    if archive is not None:
        found.archive(
            archive, name="report.html" if path is None else path.name, excel_locale=excel_locale
        )
    _say_written(found, [path, archive], as_json=json)
    if json:
        write_json(to_json(reporting.published_report(found.dossier)))
    _exit_by(found.analysis)


def _say_written(found: TestReport, files: Sequence[Path | None], *, as_json: bool) -> None:
    """Say which statements of the table were overridden, and which files are there now."""
    for one in found.dossier.provenance.restated:
        if one.before is not None:
            typer.echo(reporting.printable(f"scara-iso: overridden, {one}"), err=True)
    for path in files:
        say_written(path, aside=as_json)
    if missing := len(reporting.not_stated(found.analysis.run)):
        said = f"{missing} statements about the test are missing on its first page"
        tell(f"{said}: --meta operator=NAME, or --meta-file FILE.toml")


def _exit_by(analysis: Analysis) -> None:
    """Say where limits are not kept, and exit accordingly."""
    say_limits(analysis)
    if analysis.conformity not in (None, Conformity.PASS):
        raise typer.Exit(NOT_WITHIN_LIMITS)


def _metadata(texts: Sequence[str], file: Path | None) -> dict[str, str]:
    """Return what a file and options state; an option holds against the file."""
    from scara_iso.base.files import read_toml

    found = {} if file is None else read_toml(file, "docs/report.md")
    nested = sorted(key for key, value in found.items() if isinstance(value, dict | list))
    if nested:
        raise DataError(
            f"{', '.join(nested)}: not a single value",
            where=str(file),
            remedy='write lines such as operator = "A. Muster"',
        )
    stated = {key: str(value) for key, value in found.items()}
    wrong = [text for text in texts if "=" not in text]
    if wrong:
        raise UsageError(f"--meta {wrong[0]!r} is not KEY=VALUE", remedy="--meta operator=A.Muster")
    pairs = (text.partition("=") for text in texts)
    return stated | {key.strip(): value.strip() for key, _, value in pairs}


def _stem(tables: Sequence[str]) -> str:
    return "report" if len(tables) > 1 or tables[0] in ("-", ".") else Path(tables[0]).stem
