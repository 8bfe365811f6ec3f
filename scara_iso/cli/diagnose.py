"""``scara-iso diagnose``: what the model leaves unexplained, and which effect it lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.cli.folders import is_folder
from scara_iso.cli.options import (
    AllCount,
    AllowGaps,
    AsJson,
    ConditionName,
    CyclesRun,
    DecimalMark,
    FirstDiscarded,
    ResolutionOfTable,
    Sheet,
    UnitOfTable,
)
from scara_iso.cli.output import check_outputs, write_json, write_report
from scara_iso.errors import UsageError

if TYPE_CHECKING:
    from scara_iso.cli.conditions import Write
    from scara_iso.diagnosis import CyclesWanted, Diagnosis
    from scara_iso.library import ConditionRun, TableOptions
    from scara_iso.run import Run

Tables = Annotated[
    list[str] | None,
    typer.Argument(metavar="TABLE...", help="Tables of readings; several give a summary."),
]


ModelOption = Annotated[
    str | None,
    typer.Option("--model", metavar="MODEL", help="Model file; else a constant pose."),
]
HoldOut = Annotated[
    str | None,
    typer.Option(metavar="TABLE", help="Second table for the error on unseen cycles."),
]
SaveModel = Annotated[
    Path | None, typer.Option(metavar="NEW", help="Write the model with the effects declared.")
]
Plot = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Before and after as .svg or .png.")
]
Pose = Annotated[str | None, typer.Option(help="Which pose, where the table has several.")]
Design = Annotated[
    bool, typer.Option("--design", help="What a planned test will tell; needs no readings.")
]
Sigma = Annotated[
    float | None,
    typer.Option(
        help="Scatter of the readings where nothing acts [mm]: known, or planned (else 0.005)."
    ),
]
Columns = Annotated[
    str | None, typer.Option(help="Columns of the planned test: approach,temperature_C.")
]
Seed = Annotated[int, typer.Option(help="Seed of the shuffles.", min=0)]


def diagnose_command(
    tables: Tables = None,
    *,
    model: ModelOption = None,
    hold_out: HoldOut = None,
    save_model: SaveModel = None,
    plot: Plot = None,
    pose: Pose = None,
    design: Design = False,
    sigma: Sigma = None,
    columns: Columns = None,
    seed: Seed = 9283,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    sheet: Sheet = None,
    first_cycle_discarded: FirstDiscarded = False,
    cycles: CyclesRun = None,
    all_count: AllCount = False,
    allow_gaps: AllowGaps = False,
    condition: ConditionName = None,
    json: AsJson = False,
) -> None:
    """Close the loop: residual, the effect that explains it, error before and after.

    Example: scara-iso diagnose run.csv --model robot.toml --save-model new.toml
    """
    from scara_iso.diagnosis import CyclesWanted
    from scara_iso.library import TableOptions

    reading = TableOptions(unit, resolution, decimal, sheet)
    wanted = CyclesWanted(pose, first_cycle_discarded, cycles, all_count, allow_gaps)
    named = tables or []
    if design:
        from scara_iso.cli.diagnose_design import show_design

        _refuse_beside_design(model, hold_out, save_model, plot)
        show_design(named, reading, wanted, sigma=sigma, columns=columns, seed=seed, as_json=json)
        return
    if columns is not None:
        raise UsageError("--columns is for --design", remedy="a table names its own columns")
    files = _Files(model, hold_out, save_model, plot, sigma)
    files.check(named)
    check_outputs([plot, save_model], [*named, model, hold_out])
    if len(named) == 1 and is_folder(named[0], condition, reading):
        from scara_iso.cli.conditions import diagnose_folder

        def diagnose(one: ConditionRun, run: Run, write: Write) -> None:
            counting = wanted if wanted.cycles else replace(wanted, cycles=one.options["cycles"])
            _diagnose_table(run, files, reading, counting, seed=seed, as_json=json, write=write)

        diagnose_folder(named[0], condition, diagnose)
    elif len(named) > 1:
        from scara_iso.cli.diagnose_many import show_many

        show_many(named, model, reading, wanted, seed=seed, as_json=json)
    else:
        _diagnose_table(named[0], files, reading, wanted, seed=seed, as_json=json)


def _refuse_beside_design(
    model: str | None, hold_out: str | None, save_model: Path | None, plot: Path | None
) -> None:
    given = {"--model": model, "--hold-out": hold_out, "--save-model": save_model, "--plot": plot}
    for option, value in given.items():
        if value is not None:
            raise UsageError(f"{option} has no part in --design", remedy="leave it out")


@dataclass(frozen=True, slots=True)
class _Files:
    """What the diagnosis of one table takes and writes beside it."""

    model: str | None
    hold_out: str | None
    save_model: Path | None
    plot: Path | None
    sigma: float | None

    @property
    def alone(self) -> bool:
        """Whether nothing but a table is named."""
        return not any((self.model, self.hold_out, self.save_model, self.plot, self.sigma))

    def check(self, tables: Sequence[str]) -> None:
        """Raise `UsageError` where this does not go with the tables that are named."""
        single = {
            "--hold-out": self.hold_out, "--save-model": self.save_model, "--plot": self.plot,
            "--sigma": self.sigma,
        }  # fmt: skip
        asked = [option for option, value in single.items() if value is not None]
        if not tables:
            raise UsageError("no table is named", remedy="name one, or ask for --design")
        if len(tables) > 1 and asked:
            raise UsageError(
                f"{asked[0]} is for one table", remedy="diagnose the tables one by one"
            )
        if self.save_model is not None and self.model is None:
            raise UsageError("--save-model needs --model", remedy="name the one to add to")


def _diagnose_table(
    table: str | Run,
    files: _Files,
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    seed: int,
    as_json: bool,
    write: Write = write_json,
) -> None:
    from scara_iso.diagnosis import save_model
    from scara_iso.library import diagnose

    run = reading.read(table)
    if files.alone and wanted.pose is None and len(list(run.rows_by_pose())) > 1:
        from scara_iso.cli.diagnose_many import diagnose_poses_of

        diagnose_poses_of(run, wanted, seed=seed, as_json=as_json, write=write)
        return
    diagnosis = diagnose(
        run,
        files.model,
        **asdict(wanted),
        hold_out=None if files.hold_out is None else reading.read(files.hold_out),
        seed=seed,
        sigma=files.sigma,
    )
    if files.plot is not None:
        from scara_iso.render import plot_diagnosis

        plot_diagnosis(diagnosis, files.plot)
    if files.save_model is not None and files.model is not None:
        said = save_model(diagnosis, files.model, files.save_model)
        diagnosis = replace(diagnosis, notes=(*diagnosis.notes, *said))
    _write(diagnosis, run.origin.source, as_json=as_json, write=write)


def _write(diagnosis: Diagnosis, title: str, *, as_json: bool, write: Write) -> None:
    if as_json:
        from scara_iso.render import diagnosis_json

        write(diagnosis_json(diagnosis))
    else:
        from scara_iso.reporting import diagnosis_report

        write_report(diagnosis_report(diagnosis, title))
