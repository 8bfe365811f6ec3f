"""`report`: the whole test as one document, to be shown or written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from scara_iso import iso9283
from scara_iso.base.disk import check_output, write_file
from scara_iso.base.display import Displayed
from scara_iso.base.errors import UsageError
from scara_iso.diagnosis import (
    CyclesWanted,
)
from scara_iso.iso9283 import Analysis, Beside, DecisionRule
from scara_iso.library.evidence import archive as pack, with_recording
from scara_iso.library.figures import compared_with_its_manifest
from scara_iso.library.held import hold, named, read_held
from scara_iso.library.inputs import (
    Tables,
    TablesOptions,
    parted,
    paths_of,
)
from scara_iso.library.loop import diagnose_analysis
from scara_iso.library.sizes import sizes_of
from scara_iso.library.statements import restate
from scara_iso.render import find_format
from scara_iso.reporting import (
    Amendment,
    Dossier,
    Provenance,
    document,
    stated_field,
)
from scara_iso.robot import Gearbox, Model, read_effects, read_model
from scara_iso.run import Run, no_such_pose
from scara_iso.tables import find_locale

if TYPE_CHECKING:
    import pandas as pd


_PACKAGE = "scara-iso"


@dataclass(frozen=True, slots=True)
class TestReport(Displayed):
    """A test report: what it is made of in ``dossier``."""

    dossier: Dossier
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    """The bytes that it was made from, by name."""
    tables: tuple[Path, ...] = ()
    """Paths of its tables, where it was read from some."""
    _pages: dict[tuple[str, str | None], bytes] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    """What `write` made, by ending and locale."""

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
        write_file(path, self._page(path, excel_locale))
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
        page = (name, self._page(Path(name), excel_locale))
        write_file(Path(path), pack(data, page, about))
        return Path(path)

    def _page(self, path: Path, excel_locale: str | None) -> bytes:
        """Return the bytes of a file with this name; those of a kind are made once."""
        kind = (path.suffix.lower(), excel_locale)
        if kind not in self._pages:
            self._pages[kind] = _writer(path, excel_locale)(self.dossier)
        return self._pages[kind]


def report(
    table: Tables,
    *,
    condition: str | None = None,
    model: str | Path | None = None,
    own_effects: str | Path | None = None,
    to: str | Path | None = None,
    pose: str | None = None,
    limits: float | Mapping[str, float] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    excel_locale: str | None = None,
    metadata: Mapping[str, str] | None = None,
    supersedes: str | None = None,
    reason: str | None = None,
    command: str = "scara_iso.report",
    **options: Unpack[TablesOptions],
) -> TestReport:
    """Return the report of a test: result, pictures, every intermediate value, diagnosis, raw data.

    ``model`` is a model file: diagnosis and backlash with it; ``own_effects`` the file of the
    user's effects. ``to`` also writes the report, as
    `TestReport.write`. ``pose`` is one of several; ``command`` says in the report how it was made.
    ``metadata`` fills or overrides what the table states, and the report says which; ``supersedes``
    is the number of the report in whose place this one stands, for ``reason``. The other options,
    and what ``table`` may be, are those of `analyze`. Errors as in `analyze`, `diagnose` and
    `TestReport.write`.
    """
    if to is not None:
        check_format(Path(to), excel_locale)
        check_output(Path(to))
    reading, counting = parted(**options)
    wanted: dict[str, Any] = {
        "counting": counting,
        "limits": sizes_of("limits", limits),
        "decision": decision,
    }
    if (measured := reading.measured(table, condition)) is not None:
        run, held = measured.readings, tuple(hold(*file) for file in measured.files())
        wanted = measured.merged_with(wanted)
    else:
        run, held = read_held(table, reading)
    run, restated = restate(_at(run, pose), metadata or {})
    amendment = _amendment(run, supersedes, reason)
    own = () if own_effects is None else read_effects(own_effects)
    described = None if model is None else read_model(model, own)
    analysis = iso9283.analyze(run, **wanted)
    for role, file in (("model", model), ("effects", own_effects)):
        held += () if file is None else (hold(role, Path(file)),)
    dossier = Dossier(
        analysis=analysis if measured else compared_with_its_manifest(analysis, table),
        provenance=Provenance(
            tuple(file for file, _ in held), version(_PACKAGE), command, restated
        ),
        diagnoses=diagnose_analysis(
            analysis, described, CyclesWanted(counting=wanted["counting"]), own
        ),
        gearboxes={} if described is None else _gearboxes(described),
        amendment=amendment,
    ).with_beside(measured.beside if measured and pose is None else Beside())
    tables = measured.tables if measured else tuple(paths_of(table))
    made = TestReport(dossier, named(held), tables)
    if to is not None:
        made.write(to, excel_locale=excel_locale)
    return made


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


def _at(run: Run, pose: str | None) -> Run:
    """Return the run of one pose, all of it where None is named."""
    if pose is None:
        return run
    rows = dict(run.rows_by_pose())
    if pose not in rows:
        raise no_such_pose(pose, rows, run.origin.source)
    run = run.take(rows[pose])
    return replace(run, metadata={**run.metadata, "pose": pose})


def _gearboxes(model: Model) -> dict[int, tuple[Gearbox, float | None]]:
    """Return each gearbox with the reach from its joint to the tool, the arm stretched [m]."""
    arm = model.arm
    reach = {}
    if arm is not None:
        reach = {1: (arm.link_1_mm + arm.link_2_mm) / 1000, 2: arm.link_2_mm / 1000}
    return {joint: (gearbox, reach.get(joint)) for joint, gearbox in model.gearboxes.items()}
