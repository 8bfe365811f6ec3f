"""``scara-iso report``: the whole test on paper, for those who sign and those who read it."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.cli.analyze import compared_with_its_manifest
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
from scara_iso.disk import write_file
from scara_iso.errors import ScaraIsoError, UsageError
from scara_iso.iso9283 import Conformity, Decision

if TYPE_CHECKING:
    from scara_iso.diagnosis import CyclesWanted, Diagnosis, Reading
    from scara_iso.iso9283 import Analysis
    from scara_iso.reporting import Dossier, Failure, InputFile
    from scara_iso.robot import Gearbox, Model
    from scara_iso.run import Run
    from scara_iso.tables import SheetLocale

_SEED = 9283

ModelFile = Annotated[
    str | None,
    typer.Option("--model", metavar="MODEL", help="Model file: diagnosis and backlash with it."),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", help="File, by its ending: .html .md .csv .xlsx .pdf .json; else "
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
    decision: LimitRule = Decision.INTERVAL,
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
    from scara_iso.diagnosis import CyclesWanted, Reading
    from scara_iso.reporting import printable

    path = output or (None if json else Path(f"{_stem(table)}.html"))
    write = None if path is None else _writer(path, excel_locale)
    check_outputs([path], [table, model])
    wanted = CyclesWanted(pose, first_cycle_discarded, cycles, all_count, allow_gaps)
    reading = Reading(unit, resolution, decimal, sheet)
    dossier = _test(table, model, reading, wanted, (parse_limits(limit or ()), decision))
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


def _writer(path: Path, locale: str | None) -> Callable[[Dossier], bytes]:
    """Return what makes the bytes of a file with this name; errors before anything is computed."""
    kind = path.suffix.lower()
    if kind not in _ENDINGS:
        raise UsageError(
            f"{path.name}: a report is written as {', '.join(_ENDINGS)}",
            remedy="let the name end in one of them",
        )
    if locale is not None and kind != ".csv":
        raise UsageError("--excel-locale spells a .csv", remedy="let the name end in .csv")
    if kind == ".csv":
        from scara_iso.tables import find_locale

        return lambda dossier: _csv(dossier, _title(dossier), find_locale(locale))
    render = _KINDS[kind]
    return lambda dossier: render(dossier, _title(dossier))


def _title(dossier: Dossier) -> str:
    robot = dossier.analysis.run.metadata.get("robot", "").strip()
    return f"ISO 9283 repeatability of {robot or dossier.provenance.files[0].name}"


def _html(dossier: Dossier, title: str) -> bytes:
    from scara_iso.render import to_html
    from scara_iso.reporting import document

    return to_html(document(dossier), title).encode()


def _markdown(dossier: Dossier, title: str) -> bytes:
    from scara_iso.render import to_markdown
    from scara_iso.reporting import document

    return to_markdown(document(dossier), title).encode()


def _csv(dossier: Dossier, title: str, locale: SheetLocale) -> bytes:
    from scara_iso.render import to_csv
    from scara_iso.reporting import document

    return to_csv(document(dossier), title, locale).encode()


def _workbook(dossier: Dossier, title: str) -> bytes:
    from scara_iso.render import to_workbook
    from scara_iso.reporting import document

    return to_workbook(document(dossier), title)


def _pdf(dossier: Dossier, title: str) -> bytes:
    from scara_iso.render import to_pdf
    from scara_iso.reporting import document

    return to_pdf(document(dossier), title)


def _json(dossier: Dossier, title: str) -> bytes:  # noqa: ARG001 - JSON holds no title
    from scara_iso.render import report_json, to_text

    return f"{to_text(report_json(dossier))}\n".encode()


_KINDS: dict[str, Callable[[Dossier, str], bytes]] = {
    ".html": _html,
    ".md": _markdown,
    ".xlsx": _workbook,
    ".json": _json,
    ".pdf": _pdf,
}
_ENDINGS = (*_KINDS, ".csv")


def _test(
    table: str,
    model_file: str | None,
    reading: Reading,
    wanted: CyclesWanted,
    limits: tuple[dict[str, float], Decision],
) -> Dossier:
    from scara_iso import __version__, analyze
    from scara_iso.reporting import Dossier, Provenance

    run, table_file = _read(table, reading, wanted.pose)
    described, files = None, [table_file]
    if model_file is not None:
        described, read = _read_model(model_file)
        files.append(read)
    analysis = analyze(
        run,
        first_cycle_discarded=wanted.first_cycle_discarded,
        cycles=wanted.cycles,
        all_count=wanted.all_count,
        allow_gaps=wanted.allow_gaps,
        limits=limits[0],
        decision=limits[1].value,
    )
    analysis = compared_with_its_manifest(analysis, table)
    command = shlex.join(("scara-iso", *settings.arguments))
    return Dossier(
        analysis=analysis,
        provenance=Provenance(tuple(files), __version__, command),
        diagnoses=_diagnoses(analysis, described, replace(wanted, pose=None)),
        gearboxes={} if described is None else _gearboxes(described),
    )


def _read(table: str, reading: Reading, pose: str | None) -> tuple[Run, InputFile]:
    """Return the run of a table, and the hash of the very bytes that it was read from."""
    from hashlib import sha256
    from io import BytesIO

    from scara_iso.reporting import InputFile
    from scara_iso.tables import read_bytes

    data, name = read_bytes(table)
    file = BytesIO(data)
    setattr(file, "name", name)  # noqa: B010 - where errors and the report say it is from
    run = reading.read(file)
    if pose is not None:
        rows = {str(label): rows for label, rows in run.rows_by_pose()}
        if pose not in rows:
            raise UsageError(
                f"no pose {pose!r} in {name}", remedy=f"it has {', '.join(list(rows)[:20])}"
            )
        run = run.take(rows[pose])
        run = replace(run, metadata={**run.metadata, "pose": pose})
    return run, InputFile("table", name, sha256(data).hexdigest())


def _read_model(path: str) -> tuple[Model, InputFile]:
    from scara_iso.acquisition import sha256
    from scara_iso.reporting import InputFile
    from scara_iso.robot import read_model

    model = read_model(path)
    return model, InputFile("model", path, sha256(Path(path)))


def _diagnoses(
    analysis: Analysis, model: Model | None, wanted: CyclesWanted
) -> dict[str | None, Diagnosis | Failure]:
    """Return the diagnosis of each pose; too few cycles for one are said, a wrong model raises."""
    from scara_iso.diagnosis import close_the_loop, close_the_loop_at_poses
    from scara_iso.reporting import Failure

    labels = [pose.label for pose in analysis.poses]
    try:
        if len(labels) > 1:  # a model file describes one pose
            found = close_the_loop_at_poses(analysis.run, wanted, seed=_SEED)
            return {label: found[str(label)] for label in labels}
        return {labels[0]: close_the_loop(analysis.run, model, wanted, seed=_SEED)}
    except ScaraIsoError as error:
        if model is not None:
            raise
        return dict.fromkeys(labels, Failure(error.headline, error.exit_code))


def _gearboxes(model: Model) -> dict[int, tuple[Gearbox, float | None]]:
    """Return each gearbox with the reach from its joint to the tool, the arm stretched [m]."""
    arm = model.arm
    reach = {}
    if arm is not None:
        reach = {1: (arm.link_1_mm + arm.link_2_mm) / 1000, 2: arm.link_2_mm / 1000}
    return {joint: (gearbox, reach.get(joint)) for joint, gearbox in model.gearboxes.items()}
