"""`report`: the whole test on paper, for those who sign and those who read it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace as exchanged
from functools import partial
from os.path import relpath
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from scara_iso import __version__, render, reporting
from scara_iso.base.displayed import Displayed
from scara_iso.base.errors import UsageError
from scara_iso.base.files import check_output, write_file
from scara_iso.commands import evidence
from scara_iso.commands.diagnose import diagnose_analysis
from scara_iso.commands.shared import inputs, options as opt, output as out, series
from scara_iso.diagnosis import CyclesWanted
from scara_iso.effects import OwnEffect
from scara_iso.iso9283 import Analysis, Conformity, DecisionRule, OtherTests
from scara_iso.robot import Gearbox, Model
from scara_iso.run import Run, no_such_pose
from scara_iso.tables import find_locale
from scara_iso.testfolder import is_test_folder

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True)
class TestReport(Displayed):
    """A test report: what it is made of in ``dossier``."""

    dossier: reporting.Dossier
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

    def write(
        self, path: str | Path, *, excel_locale: str | None = None, replace: bool = False
    ) -> Path:
        """Write .html, .md, .csv, .xlsx, .pdf or .json, by the name's ending; return the path.

        ``excel_locale`` (``de`` or ``en``) spells a .csv. Raises `UsageError` for another ending,
        `CannotCreateError` where the report of another table or number is there, or another one
        has this number, unless ``replace``, or where the file is no report; and as `write_file`.
        """
        path = Path(path)
        entry = self.entry(path, replace=replace)
        write_file(path, _writer(path, excel_locale)(self.dossier))
        evidence.register(path, entry)
        return path

    def entry(self, path: Path, *, replace: bool) -> evidence.Entry:
        """Return what its folder notes of a file of this report; errors as in `write`."""
        number = reporting.stated_field(self.analysis.run, "report number")
        folder = path.resolve().parent
        paths = [Path(relpath(table.resolve(), folder)).as_posix() for table in self.tables]
        hashes = [file.sha256 for file in self.dossier.provenance.files]
        entry = evidence.Entry(paths or hashes, number)
        evidence.refuse_another(path, entry, replace=replace)
        return entry

    def archive(
        self,
        path: str | Path,
        *,
        name: str = "report.html",
        excel_locale: str | None = None,
        replace: bool = False,
    ) -> Path:
        """Write the evidence as one ZIP file; return its path.

        It holds table and model, raw file and manifest of a recording, the report as ``name``,
        versions and SHA-256 of all; the same input gives the same bytes. Errors as in `write`.
        """
        path = Path(path)
        entry = self.entry(path, replace=replace)
        recorded = (one for table in self.tables for one in evidence.with_recording(table))
        made = self.dossier.provenance
        title = reporting.document(self.dossier).title
        about = {"report": title, "program": made.version, "command": made.command}
        page = (name, _writer(Path(name), excel_locale)(self.dossier))
        data = {**self.files, **dict(recorded)}
        write_file(path, evidence.archive(data, page, about))
        evidence.register(path, entry)
        return path


def report(
    table: inputs.Tables,
    *,
    condition: str | None = None,
    model: str | Path | None = None,
    own_effects: str | Path | None = None,
    to: str | Path | None = None,
    pose: str | None = None,
    limits: inputs.Sizes | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    excel_locale: str | None = None,
    language: str = reporting.ENGLISH,
    metadata: Mapping[str, str] | None = None,
    supersedes: str | None = None,
    reason: str | None = None,
    replace: bool = False,
    command: str = "scara_iso.report",
    **options: Unpack[inputs.TablesOptions],
) -> TestReport:
    """Return the report of a test: result, pictures, every intermediate value, diagnosis, raw data.

    ``model`` is a model file: diagnosis and backlash with it; ``own_effects`` the file of the
    user's effects. ``to`` also writes the report, as `TestReport.write`. ``language`` is that of
    the labels, such as ``de``. ``pose`` is one of several; ``command`` says in the report how it
    was made. ``metadata`` fills or overrides what the table states, and the report says which;
    ``supersedes`` is the number of the report in whose place this one stands, for ``reason``;
    ``replace`` overwrites the report of another table. The other options, and what ``table`` may
    be, are those of `analyze`. Errors as in `analyze`, `diagnose` and `TestReport.write`.
    """
    reporting.labels_of(language)
    if to is not None:
        _writer(Path(to), excel_locale)
        check_output(Path(to))
    reading, counting = inputs.reading_and_counting(report, options)
    found = inputs.read_series(table, reading, condition)
    run, restated = evidence.restate(_at(found.readings, pose), metadata or {})
    amendment = _amendment(run, supersedes, reason)
    own, known, stated = _models(model, own_effects)
    checks = (*found.files(), *stated)
    files = tuple(file for file, _ in checks)
    made_by = reporting.Provenance(files, __version__, command, restated)
    analysis = exchanged(found, run=run).analysis(
        counting=counting, limits=inputs.sizes_of("limits", limits), decision=decision
    )
    wanted = CyclesWanted(counting=found.counted(counting))
    others = found.other_tests if pose is None else OtherTests()
    diagnosed = diagnose_analysis(analysis, known, wanted, own)
    dossier = reporting.Dossier(
        analysis, made_by, *diagnosed, _gearboxes(known), amendment=amendment, language=language
    )
    made = TestReport(dossier.with_other_tests(others), evidence.by_file_name(checks), found.paths)
    if to is not None:
        made.write(to, excel_locale=excel_locale, replace=replace)
    return made


def join_reports(
    found: Sequence[series.MeasurementSeries], made: Sequence[TestReport]
) -> TestReport:
    """Return one report of all conditions, ``made`` of those that have readings, one at least.

    With the tests beside them, where there are several (that of one condition has them itself).
    Raises `DataError` where they have not the same axes.
    """
    if len(found) == 1:
        return made[0]
    measured = [one for one in found if one.run is not None]
    missing = [part for one in found if one.run is None for part in one.missing]
    tables = series.whole_tables(found[0].folder.other_tests)
    checks = list(series.files_of(tables))
    dossiers = {one.condition: report.dossier for one, report in zip(measured, made, strict=True)}
    dossier = reporting.joined_dossier(dossiers, missing).with_other_tests(
        series.read_other_tests(found[0].folder), [file for file, _ in checks]
    )
    files = {name: data for report in made for name, data in report.files.items()}
    return TestReport(
        dossier,
        files | {Path(file.name).name: data for file, data in checks},
        (*(path for report in made for path in report.tables), *tables),
    )


def _amendment(run: Run, supersedes: str | None, reason: str | None) -> reporting.Amendment | None:
    """Return what the report stands in place of; `UsageError` where it cannot be told apart."""
    if supersedes is None and reason is None:
        return None
    if not (supersedes and supersedes.strip()) or not (reason and reason.strip()):
        raise UsageError(
            "an amended report states which report it supersedes, and why",
            remedy="`supersedes=2026-017` with `reason=serial number corrected`",
        )
    number = reporting.stated_field(run, "report number")
    if not number or number == supersedes.strip():
        raise UsageError(
            "an amended report needs a number of its own",
            remedy="`metadata=report_number=2026-018`",
        )
    return reporting.Amendment(supersedes.strip(), reason.strip())


def _writer(path: Path, locale: str | None) -> Callable[[reporting.Dossier], bytes]:
    """Return what makes the bytes of a file with this name; errors before anything is computed."""
    write = render.find_format(path.name, path.suffix)
    if locale is not None:
        if path.suffix.lower() != ".csv":
            raise UsageError(
                "`excel_locale=` is for a report as .csv", remedy="let the name end in .csv"
            )
        write = partial(write, locale=find_locale(locale))
    return lambda dossier: write(reporting.document(dossier))


def _at(run: Run, pose: str | None) -> Run:
    if pose is None:
        return run
    rows = dict(run.rows_by_pose())
    if pose not in rows:
        raise no_such_pose(pose, rows, run.origin.source)
    run = run.take(rows[pose])
    return exchanged(run, metadata={**run.metadata, "pose": pose})


def _models(
    model: str | Path | None, own_effects: str | Path | None
) -> tuple[tuple[OwnEffect, ...], Model | None, list[series.FileBytes]]:
    """Return the user's effects, the model, and the files that they are read from."""
    own = inputs.load_effects(own_effects)
    known = None if model is None else inputs.load_model(model, own)
    of_user = {"model": model, "effects": own_effects}.items()
    return own, known, [series.with_bytes(role, Path(x)) for role, x in of_user if x is not None]


def _gearboxes(model: Model | None) -> dict[int, tuple[Gearbox, float | None]]:
    """Return each gearbox with the reach from its joint to the tool, the arm stretched [m]."""
    if model is None:
        return {}
    arm = model.arm
    reach = {}
    if arm is not None:
        reach = {1: (arm.link_1_mm + arm.link_2_mm) / 1000, 2: arm.link_2_mm / 1000}
    return {joint: (gearbox, reach.get(joint)) for joint, gearbox in model.gearboxes.items()}


@opt.takes_options_of(
    report,
    model=opt.option("Model file, for diagnosis and backlash.", metavar="MODEL"),
    to=opt.output_file(
        f"File to write, by its ending: {' '.join(render.endings())}; else "
        "TABLE's name with .html in this folder."
    ),
    pose=opt.option("Pose to report, where the table has several."),
    language=opt.option(
        f"Language of the labels: {', '.join(reporting.known_languages())}.",
        metavar="LANGUAGE",
        autocompletion=reporting.known_languages,
    ),
    metadata=opt.option(
        "Field of the report: laboratory='Example Ltd'; overrides the table.",
        "--meta",
        read=opt.parse_pairs,
        metavar="KEY=VALUE",
    ),
    supersedes=opt.option("Number of the report that this one replaces.", metavar="NUMBER"),
    reason=opt.option("Reason for the replacement."),
    archive=opt.option(
        "Evidence: table, raw file, model, report, versions, hashes.", metavar="FILE.zip"
    ),
    replace=opt.option("Overwrite a report of another table or number."),
)
def report_command(
    asked: opt.Asked[TestReport],
    *,
    meta_file: Path | None = None,
    archive: Path | None = None,
    json: bool = False,
) -> None:
    """Write the test report: result, pictures, every intermediate value, diagnosis, raw data.

    Example: scara-iso report run.csv --model robot.toml -o report.html
    """
    table, condition = asked["table"], asked["condition"]
    folder = table[0] if len(table) == 1 and is_test_folder(table[0]) else None
    path = asked["to"] or (None if json else Path(f"{_stem(table, folder)}.html"))
    if path is not None:
        _writer(path, asked["excel_locale"])
    files = [*table, asked["model"], asked["own_effects"], meta_file and str(meta_file)]
    out.check_outputs([], files, decided=[path, archive])
    options = asked.options("table", "condition", "to", "excel_locale", "replace", *opt.READING)
    options["metadata"] = opt.pairs_in(meta_file) | options.get("metadata", {})
    options["command"] = shlex.join(("scara-iso", *out.settings.arguments))
    found = inputs.each_series(table, asked.reading, condition)
    measured = out.recorded_among(found)
    made = [report(one, **options) for one in measured]
    if made:
        _write(join_reports(found, made), (path, archive), asked, as_json=json)
        if path and folder:
            for one in filter(lambda one: one.missing, measured):
                out.say(f"missing: {', '.join(one.missing)}", aside=json)
    else:
        for file in filter(None, (path, archive)):
            out.say(f"{file} is not written: nothing is recorded")
    beside = (
        series.read_other_tests(found[0].folder) if folder and condition is None else OtherTests()
    )
    for one, of_it in zip(measured, made, strict=True):
        _say_verdicts(of_it.analysis, f"{one.condition}: " if len(found) > 1 else "")
    if json:
        dossiers = [one.dossier for one in made]
        out.write_results(measured, dossiers, of=len(found), other_tests=beside)
    out.exit_by([*(one.analysis.conformity for one in made), beside.conformity])


def _write(
    made: TestReport,
    files: tuple[Path | None, Path | None],
    asked: opt.Asked[TestReport],
    *,
    as_json: bool,
) -> None:
    """Write a report and its evidence, where wanted, and say what was overridden and written.

    Neither is written where one of the two holds another's.
    """
    (path, packed), locale, over = files, asked["excel_locale"], asked["replace"]
    for named in filter(None, files):
        made.entry(named, replace=over)
    if path is not None:
        made.write(path, excel_locale=locale, replace=over)
    if packed is not None:
        name = "report.html" if path is None else path.name
        made.archive(packed, name=name, excel_locale=locale, replace=over)
    for one in made.dossier.provenance.restated:
        if one.before is not None:
            out.say(f"scara-iso: overridden, {one}")
    for file in files:
        out.say_written(file, aside=as_json)
    if missing := len(reporting.not_stated(made.analysis.run)):
        text = f"{missing} statements about the test are missing on its first page"
        out.tell(f"{text}: --meta operator=NAME, or --meta-file FILE.toml")


def _say_verdicts(analysis: Analysis, of: str) -> None:
    if analysis.conformity not in (None, Conformity.PASS):
        text = "; ".join(block.text for block in reporting.conformity(analysis))
        out.say(f"scara-iso: {of}{text}")


def _stem(tables: Sequence[str], folder: str | None) -> str:
    if folder is not None:
        return Path(folder).resolve().name
    return "report" if len(tables) > 1 or tables[0] in ("-", ".") else Path(tables[0]).stem
