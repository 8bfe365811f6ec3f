"""`report`: the whole test as one document, to be shown or written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from io import BytesIO
from pathlib import Path

from scara_iso import iso9283
from scara_iso.diagnosis import (
    SEED,
    CyclesWanted,
    Diagnosis,
    close_the_loop,
    close_the_loop_at_poses,
)
from scara_iso.disk import write_file
from scara_iso.errors import ScaraIsoError, UsageError
from scara_iso.frames import is_frame
from scara_iso.iso9283 import Analysis, DecisionRule
from scara_iso.library.figures import compared_with_its_manifest
from scara_iso.library.inputs import Table, TableOptions, Tables, every, tables_of, together_as
from scara_iso.library.notebook import framed
from scara_iso.render import find_format
from scara_iso.reporting import Dossier, Failure, InputFile, Provenance, document
from scara_iso.robot import Gearbox, Model, read_model
from scara_iso.run import Run
from scara_iso.tables import find_locale, read_bytes, write_table


@dataclass(frozen=True, slots=True)
class TestReport:
    """A test report: what it is made of in ``dossier``; it shows itself in a notebook."""

    dossier: Dossier

    @property
    def analysis(self) -> Analysis:
        """The figures and findings."""
        return self.dossier.analysis

    def write(self, path: str | Path, *, excel_locale: str | None = None) -> Path:
        """Write .html, .md, .csv, .xlsx, .pdf or .json, by the name's ending; return the path.

        ``excel_locale`` (``de`` or ``en``) spells a .csv. Raises `UsageError` for another ending,
        and as `write_file`.
        """
        path = Path(path)
        write_file(path, writer(path, excel_locale)(self.dossier))
        return path

    def _repr_html_(self) -> str:
        return framed(find_format("report", ".html")(document(self.dossier)).decode())


def report(
    table: Tables,
    *,
    model: str | Path | None = None,
    to: str | Path | None = None,
    pose: str | None = None,
    limits: Mapping[str, float] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    sheet: str | None = None,
    first_cycle_discarded: bool = False,
    cycles: int | None = None,
    all_count: bool = False,
    allow_gaps: bool = False,
    excel_locale: str | None = None,
    command: str = "scara_iso.report",
) -> TestReport:
    """Return the report of a test: result, pictures, every intermediate value, diagnosis, raw data.

    ``model`` is a model file: diagnosis and backlash with it. ``to`` also writes the report, as
    `TestReport.write`. ``pose`` is one of several; ``command`` says in the report how it was made;
    the other options, and what ``table`` may be, are those of `analyze`. Errors as in `analyze`,
    `diagnose` and `TestReport.write`.
    """
    write = None if to is None else writer(Path(to), excel_locale)
    wanted = CyclesWanted(None, first_cycle_discarded, cycles, all_count, allow_gaps)
    run, files = _read(table, TableOptions(unit, resolution, decimal, sheet), pose)
    described = None if model is None else read_model(model)
    analysis = iso9283.analyze(
        run,
        first_cycle_discarded=first_cycle_discarded,
        cycles=cycles,
        all_count=all_count,
        allow_gaps=allow_gaps,
        limits=limits,
        decision=decision,
    )
    files += () if model is None else (_hashed("model", model),)
    dossier = Dossier(
        analysis=compared_with_its_manifest(analysis, table),
        provenance=_provenance(files, command),
        diagnoses=_diagnoses(analysis, described, wanted),
        gearboxes={} if described is None else _gearboxes(described),
    )
    if to is not None and write is not None:
        write_file(Path(to), write(dossier))
    return TestReport(dossier)


def _provenance(files: tuple[InputFile, ...], command: str) -> Provenance:
    from scara_iso import __version__

    return Provenance(files, __version__, command)


def writer(path: Path, locale: str | None) -> Callable[[Dossier], bytes]:
    """Return what makes the bytes of a file with this name; errors before anything is computed."""
    render = find_format(path.name, path.suffix)
    if locale is None:
        return lambda dossier: render(document(dossier))
    if path.suffix.lower() != ".csv":
        raise UsageError("`excel_locale=` spells a .csv", remedy="let the name end in .csv")
    spelled = partial(render, locale=find_locale(locale))
    return lambda dossier: spelled(document(dossier))


def _read(
    tables: Tables, reading: TableOptions, pose: str | None
) -> tuple[Run, tuple[InputFile, ...]]:
    """Return the run of tables, and the hashes of the very bytes that it was read from."""
    found = tables_of(tables)
    known = every(found, partial(_hold, reading=reading), f"of {len(found)} tables")
    run = reading.read([table for table, _ in known])
    if len(found) > 1 and (source := together_as(tables)):
        run = replace(run, origin=replace(run.origin, source=source))
    return _at(run, pose, run.origin.source), tuple(file for _, file in known)


def _hold(table: Table, reading: TableOptions) -> tuple[Table, InputFile]:
    """Return a table whose bytes cannot change any more, and their hash."""
    if isinstance(table, Run) or is_frame(table):
        run = reading.read(table)
        data, name = write_table(run).encode(), run.origin.source
        return table, InputFile("run, as write_table gives it", name, _hex(data))
    data, name = read_bytes(table)
    file = BytesIO(data)
    setattr(file, "name", name)  # noqa: B010 - where errors and the report say it is from
    return file, InputFile("table", name, _hex(data))


def _at(run: Run, pose: str | None, name: str) -> Run:
    """Return the run of one pose, all of it where None is named."""
    if pose is None:
        return run
    rows = {str(label): rows for label, rows in run.rows_by_pose()}
    if pose not in rows:
        raise UsageError(
            f"no pose {pose!r} in {name}", remedy=f"it has {', '.join(list(rows)[:20])}"
        )
    run = run.take(rows[pose])
    return replace(run, metadata={**run.metadata, "pose": pose})


def _hex(data: bytes) -> str:
    return sha256(data).hexdigest()


def _hashed(role: str, path: str | Path) -> InputFile:
    return InputFile(role, str(path), _hex(Path(path).read_bytes()))


def _diagnoses(
    analysis: Analysis, model: Model | None, wanted: CyclesWanted
) -> dict[str | None, Diagnosis | Failure]:
    """Return the diagnosis of each pose; too few cycles for one are said, a wrong model raises."""
    labels = [pose.label for pose in analysis.poses]
    try:
        if len(labels) > 1:  # a model file describes one pose
            found = close_the_loop_at_poses(analysis.run, wanted, seed=SEED)
            return {label: found[str(label)] for label in labels}
        return {labels[0]: close_the_loop(analysis.run, model, wanted, seed=SEED)}
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
