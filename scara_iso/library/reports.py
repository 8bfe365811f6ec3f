"""`report`: the whole test as one document, to be shown or written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from scara_iso import iso9283
from scara_iso.diagnosis import (
    SEED,
    CyclesWanted,
    Diagnosis,
    close_the_loop,
    close_the_loop_at_poses,
)
from scara_iso.disk import write_file
from scara_iso.display import Displayed
from scara_iso.errors import ScaraIsoError, UsageError
from scara_iso.frames import is_frame
from scara_iso.iso9283 import Analysis, DecisionRule, poses_in_cycles
from scara_iso.library.conditions import ConditionRun
from scara_iso.library.evidence import archive as pack, with_recording
from scara_iso.library.figures import compared_with_its_manifest
from scara_iso.library.inputs import (
    Table,
    TableOptions,
    Tables,
    every,
    paths_of,
    tables_of,
    together_as,
)
from scara_iso.library.statements import restate
from scara_iso.render import find_format
from scara_iso.reporting import (
    Amendment,
    Dossier,
    Failure,
    InputFile,
    Provenance,
    document,
    stated_field,
)
from scara_iso.robot import Gearbox, Model, read_model
from scara_iso.run import Run
from scara_iso.tables import find_locale, read_bytes, write_table

if TYPE_CHECKING:
    import pandas as pd


Held: TypeAlias = tuple[InputFile, bytes]
"""A file that a report is made of, and the very bytes of it."""


@dataclass(frozen=True, slots=True)
class TestReport(Displayed):
    """A test report: what it is made of in ``dossier``."""

    dossier: Dossier
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    """The bytes that it was made from, by name."""
    tables: tuple[Path, ...] = ()
    """Paths of its tables, where it was read from some."""

    def __repr__(self) -> str:
        return f"<TestReport of {self.dossier.provenance.files[0].name}>"

    @property
    def analysis(self) -> Analysis:
        """The figures and findings."""
        return self.dossier.analysis

    def to_frame(self) -> pd.DataFrame:
        """Return the figures as a pandas table, as `Analysis.to_frame`."""
        return self.analysis.to_frame()

    def write(self, path: str | Path, *, excel_locale: str | None = None) -> Path:
        """Write .html, .md, .csv, .xlsx, .pdf or .json, by the name's ending; return the path.

        ``excel_locale`` (``de`` or ``en``) spells a .csv. Raises `UsageError` for another ending,
        and as `write_file`.
        """
        path = Path(path)
        write_file(path, _writer(path, excel_locale)(self.dossier))
        return path

    def archive(
        self, path: str | Path, *, name: str = "report.html", excel_locale: str | None = None
    ) -> Path:
        """Write the evidence as one ZIP file; return its path.

        It holds table and model, raw file and manifest of a recording, the report as ``name``,
        versions and SHA-256 of all; the same input gives the same bytes. Errors as in `write`.
        """
        data = dict(self.files)
        for table in self.tables:
            data |= with_recording(table)
        made = self.dossier.provenance
        document_ = document(self.dossier)
        about = {"report": document_.title, "program": made.version, "command": made.command}
        page = (name, _writer(Path(name), excel_locale)(self.dossier))
        write_file(Path(path), pack(data, page, about))
        return Path(path)


def report(
    table: Tables,
    *,
    condition: str | None = None,
    model: str | Path | None = None,
    to: str | Path | None = None,
    pose: str | None = None,
    limits: Mapping[str, float] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    sheet: str | None = None,
    columns: str | Sequence[str] | None = None,
    first_cycle_discarded: bool = False,
    cycles: int | None = None,
    all_count: bool = False,
    allow_gaps: bool = False,
    excel_locale: str | None = None,
    metadata: Mapping[str, str] | None = None,
    supersedes: str | None = None,
    reason: str | None = None,
    command: str = "scara_iso.report",
) -> TestReport:
    """Return the report of a test: result, pictures, every intermediate value, diagnosis, raw data.

    ``model`` is a model file: diagnosis and backlash with it. ``to`` also writes the report, as
    `TestReport.write`. ``pose`` is one of several; ``command`` says in the report how it was made.
    ``metadata`` fills or overrides what the table states, and the report says which; ``supersedes``
    is the number of the report in whose place this one stands, for ``reason``. The other options,
    and what ``table`` may be, are those of `analyze`. Errors as in `analyze`, `diagnose` and
    `TestReport.write`.
    """
    write = None if to is None else _writer(Path(to), excel_locale)
    options: dict[str, Any] = {
        "first_cycle_discarded": first_cycle_discarded,
        "cycles": cycles,
        "all_count": all_count,
        "allow_gaps": allow_gaps,
        "limits": limits,
        "decision": decision,
    }
    reading = TableOptions(unit, resolution, decimal, sheet, columns)
    if (measured := reading.measured(table, condition)) is not None:
        run, held = _at(measured.readings, pose, str(measured.folder.path)), _held_files(measured)
        options, cycles = measured.merged_with(options), cycles or measured.cycles
    else:
        run, held = _read(table, reading, pose)
    wanted = CyclesWanted(None, first_cycle_discarded, cycles, all_count, allow_gaps)
    run, restated = restate(run, metadata or {})
    amendment = _amendment(run, supersedes, reason)
    described = None if model is None else read_model(model)
    analysis = iso9283.analyze(run, **options)
    held += () if model is None else (_held("model", str(model), Path(model).read_bytes()),)
    dossier = Dossier(
        analysis=analysis if measured else compared_with_its_manifest(analysis, table),
        provenance=Provenance(tuple(file for file, _ in held), _version(), command, restated),
        diagnoses=_diagnoses(analysis, described, wanted),
        gearboxes={} if described is None else _gearboxes(described),
        amendment=amendment,
    )
    if to is not None and write is not None:
        write_file(Path(to), write(dossier))
    return TestReport(
        dossier, _named(held), measured.tables if measured else tuple(paths_of(table))
    )


def _held_files(measured: ConditionRun) -> tuple[Held, ...]:
    return tuple(_held(role, str(path), path.read_bytes()) for role, path in measured.files())


def _named(held: Sequence[Held]) -> dict[str, bytes]:
    """Return the bytes by file name; of two files with one name the second is numbered."""
    found: dict[str, bytes] = {}
    for k, (file, data) in enumerate(held, 1):
        name = Path(file.name).name or "table"
        found[f"{k}-{name}" if name in found else name] = data
    return found


def _version() -> str:
    from scara_iso import __version__

    return __version__


def _amendment(run: Run, supersedes: str | None, reason: str | None) -> Amendment | None:
    """Return what the report stands in place of; `UsageError` where it cannot be told apart."""
    if supersedes is None and reason is None:
        return None
    if not (supersedes and supersedes.strip()) or not (reason and reason.strip()):
        raise UsageError(
            "an amended report names the report that it supersedes, and why",
            remedy="`supersedes=2026-017` with `reason=serial number corrected`",
        )
    number = stated_field(run, "report number")
    if not number or number == supersedes.strip():
        raise UsageError(
            "an amended report needs a number of its own", remedy="`meta=report_number=2026-018`"
        )
    return Amendment(supersedes.strip(), reason.strip())


def check_format(path: Path, excel_locale: str | None) -> None:
    """Raise `UsageError` where no report can have that name, before anything is computed."""
    _writer(path, excel_locale)


def _writer(path: Path, locale: str | None) -> Callable[[Dossier], bytes]:
    """Return what makes the bytes of a file with this name; errors before anything is computed."""
    render = find_format(path.name, path.suffix)
    if locale is None:
        return lambda dossier: render(document(dossier))
    if path.suffix.lower() != ".csv":
        raise UsageError(
            "`excel_locale=` is for a report as .csv", remedy="let the name end in .csv"
        )
    spelled = partial(render, locale=find_locale(locale))
    return lambda dossier: spelled(document(dossier))


def _read(tables: Tables, reading: TableOptions, pose: str | None) -> tuple[Run, tuple[Held, ...]]:
    """Return the run of tables, and the very bytes that it was read from."""
    found = tables_of(tables)
    known = every(found, partial(_hold, reading=reading), f"of {len(found)} tables")
    run = reading.read([table for table, _ in known])
    if len(found) > 1 and (source := together_as(tables)):
        run = replace(run, origin=replace(run.origin, source=source))
    return _at(run, pose, run.origin.source), tuple(held for _, held in known)


def _hold(table: Table, reading: TableOptions) -> tuple[Table, Held]:
    """Return a table whose bytes cannot change any more, and those."""
    if isinstance(table, Run) or is_frame(table):
        run = reading.read(table)
        data = write_table(run).encode()
        return table, _held("run, as write_table gives it", run.origin.source, data)
    data, name = read_bytes(table)
    file = BytesIO(data)
    setattr(file, "name", name)  # noqa: B010 - where errors and the report say it is from
    return file, _held("table", name, data)


def _held(role: str, name: str, data: bytes) -> Held:
    return InputFile(role, name, sha256(data).hexdigest()), data


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


def _diagnoses(
    analysis: Analysis, model: Model | None, wanted: CyclesWanted
) -> dict[str | None, Diagnosis | Failure]:
    """Return the diagnosis of each pose; too few cycles for one are said, a wrong model raises."""
    labels = [pose.label for pose in poses_in_cycles(analysis)]
    if not labels:  # a drift test is its own course
        return {}
    try:
        if len(labels) > 1:
            found = close_the_loop_at_poses(analysis.run, model, wanted, seed=SEED)
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
