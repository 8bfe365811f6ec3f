"""``scara-iso diagnose``: what the model leaves unexplained, and which effect it lacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso import library, render, reporting
from scara_iso.cli.folders import test_folder
from scara_iso.cli.options import (
    AllCount,
    AllowGaps,
    AsJson,
    ConditionName,
    CyclesRun,
    DecimalMark,
    FirstDiscarded,
    Full,
    OwnEffectsFile,
    ResolutionOfTable,
    Sheet,
    UnitOfTable,
)
from scara_iso.cli.output import (
    check_outputs,
    command_line,
    named as files_of,
    write_json,
    write_report,
)
from scara_iso.errors import UsageError

if TYPE_CHECKING:
    from scara_iso.cli.conditions import Write
    from scara_iso.diagnosis import CyclesWanted, Diagnosis, DiagnosisOfPoses
    from scara_iso.library import ConditionRun, TableOptions
    from scara_iso.run import Run

Tables = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="TABLE...",
        help="Tables of readings, or a folder: poses of one test, or unrelated ones.",
    ),
]


ModelOption = Annotated[
    str | None,
    typer.Option("--model", metavar="MODEL", help="Model file; else a constant pose."),
]
HoldOut = Annotated[
    str | None,
    typer.Option(
        metavar="TABLE|POSE",
        help="Second table for the error on unseen cycles, or a pose of the test to foretell.",
    ),
]
Map = Annotated[
    Path | None,
    typer.Option("--map", metavar="FILE", help="RP over the robot's reach, as .png, .svg or .csv."),
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
    str | None,
    typer.Option(
        metavar="X,Y,..",
        help="What each field of a row is, where no header says it; - leaves one out. With "
        "--design and no table: the plan's columns, approach,temperature_C.",
    ),
]
Seed = Annotated[int, typer.Option(help="Seed of the shuffles.", min=0)]


def diagnose_command(
    tables: Tables = None,
    *,
    model: ModelOption = None,
    effects: OwnEffectsFile = None,
    hold_out: HoldOut = None,
    save_model: SaveModel = None,
    plot: Plot = None,
    map_: Map = None,
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
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Close the loop: residual, the effect that explains it, error before and after.

    Example: scara-iso diagnose run.csv --model robot.toml --save-model new.toml
    """
    from scara_iso.diagnosis import CyclesWanted
    from scara_iso.library import TableOptions, one_test

    reading = TableOptions(unit, resolution, decimal, sheet, columns)
    wanted = CyclesWanted(pose, first_cycle_discarded, cycles, all_count, allow_gaps)
    named = tables or []
    if design:
        from scara_iso.cli.diagnose_design import show_design

        _refuse_beside_design(_Files(model, effects, hold_out, save_model, plot, map_, None))
        show_design(
            named, reading, wanted, sigma=sigma, columns=columns, effects=effects, seed=seed,
            as_json=json,
        )  # fmt: skip
        return
    files = _Files(model, effects, hold_out, save_model, plot, map_, sigma)
    files.check(named)
    check_outputs([plot, save_model, map_], [*files_of(named), model, effects, hold_out])
    show = partial(_How, full=full, as_json=json)
    if (folder := test_folder(named, condition, reading)) is not None:
        _diagnose_folder(folder, condition, files, reading, wanted, show, seed=seed)
        return
    run = one_test(named, reading)
    if run is None:
        from scara_iso.cli.diagnose_many import show_many

        files.refuse_of_test()
        show_many(named, (model, effects), reading, wanted, seed=seed, as_json=json)
    else:
        options = asdict(reading) | asdict(wanted) | {"effects": effects}
        how = show(partial(command_line, named, options))
        _diagnose_run(run, files, reading, wanted, how, seed=seed)


def _diagnose_folder(
    folder: str,
    condition: str | None,
    files: _Files,
    reading: TableOptions,
    wanted: CyclesWanted,
    show: Callable[..., _How],
    *,
    seed: int,
) -> None:
    from scara_iso.cli.conditions import diagnose_folder

    def diagnose(one: ConditionRun, run: Run, write: Write) -> None:
        counting = wanted if wanted.cycles else replace(wanted, cycles=one.options["cycles"])
        options = {"condition": one.condition.name, "effects": files.effects}
        how = show(partial(command_line, [folder], options), write=write)
        _diagnose_run(run, files.under(one.condition.name), reading, counting, how, seed=seed)

    diagnose_folder(folder, condition, diagnose)


@dataclass(frozen=True, slots=True)
class _Files:
    """What the diagnosis of one test takes and writes beside it."""

    model: str | None
    effects: str | None
    hold_out: str | None
    save_model: Path | None
    plot: Path | None
    map: Path | None
    sigma: float | None

    def under(self, condition: str) -> _Files:
        """Return these for one condition of a test, each of which has a map of its own."""
        if self.map is None:
            return self
        named = self.map.with_name(f"{self.map.stem}-{condition}{self.map.suffix}")
        return replace(self, map=named)

    def check(self, tables: Sequence[str]) -> None:
        """Raise `UsageError` where this does not go with the tables that are named."""
        single = {"--save-model": self.save_model, "--plot": self.plot, "--sigma": self.sigma}
        if not tables:
            raise UsageError("no table is named", remedy="name one, or ask for --design")
        if len(tables) > 1:
            _refuse(single, "is for one table", "diagnose the tables one by one")
        if self.save_model is not None and self.model is None:
            raise UsageError("--save-model needs --model", remedy="name the one to add to")
        if self.map is not None and self.model is None:
            raise UsageError(
                "--map needs --model", remedy="name one that gives links and [pose.P1] joint_deg"
            )
        if self.map is not None:
            render.check_map(self.map)

    def refuse_of_test(self) -> None:
        """Raise `UsageError` where something is wanted that unrelated tables do not give."""
        asked = {"--hold-out": self.hold_out, "--map": self.map}
        _refuse(asked, "is for one test", "name its tables by their poses, P1.csv P2.csv")

    def check_poses(self, run: Run) -> None:
        """Raise `UsageError` where something goes with one pose and ``run`` holds several."""
        from scara_iso.library import held_out_pose

        labels = [label for label, _ in run.rows_by_pose()]
        second = self.hold_out is not None and held_out_pose(run, self.hold_out) is None
        if second and not Path(self.hold_out or "").exists():
            raise UsageError(
                f"no pose {self.hold_out!r} in {run.origin.source}",
                remedy=f"it has {', '.join(map(str, labels[:20]))}",
            )
        given = {"--hold-out": second or None, "--plot": self.plot, "--sigma": self.sigma}
        what = f"is for one pose, and there are {len(labels)}"
        _refuse(given, what, f"name it: --pose {labels[0]}")


def _refuse(given: Mapping[str, object], what: str, remedy: str) -> None:
    for option, value in given.items():
        if value is not None:
            raise UsageError(f"{option} {what}", remedy=remedy)


def _refuse_beside_design(files: _Files) -> None:
    given = {
        "--model": files.model, "--hold-out": files.hold_out, "--save-model": files.save_model,
        "--plot": files.plot, "--map": files.map,
    }  # fmt: skip
    _refuse(given, "does not go with --design", "leave it out")


@dataclass(frozen=True, slots=True)
class _How:
    """How a diagnosis is written; ``again`` names its table in a command line."""

    again: Callable[..., str]
    full: bool
    as_json: bool
    write: Write = write_json


def _diagnose_run(
    run: Run,
    files: _Files,
    reading: TableOptions,
    wanted: CyclesWanted,
    how: _How,
    *,
    seed: int,
) -> None:
    from scara_iso.diagnosis import DiagnosisOfPoses, save_model

    second: Run | str | None = files.hold_out
    if wanted.pose is None and len(list(run.rows_by_pose())) > 1:
        files.check_poses(run)
    elif files.hold_out is not None:
        second = reading.read(files.hold_out)
    own = library.defined(files.effects or ())
    diagnosis = library.diagnose(
        run,
        files.model,
        **asdict(wanted),
        hold_out=second,
        reach=files.map is not None,
        seed=seed,
        sigma=files.sigma,
        own_effects=own,
    )
    if files.save_model is not None and files.model is not None:
        said = save_model(diagnosis, files.model, files.save_model, own)
        diagnosis = replace(diagnosis, notes=(*diagnosis.notes, *said))
    if isinstance(diagnosis, DiagnosisOfPoses):
        if files.map is not None and diagnosis.joint_scatter is not None:
            render.save_map(diagnosis.joint_scatter, files.map)
        _write_poses(diagnosis, run.origin.source, how)
        return
    if files.plot is not None:
        render.save_figure(diagnosis.plot(), files.plot)
    _write(diagnosis, run.origin.source, how)


def _write(diagnosis: Diagnosis, title: str, how: _How) -> None:
    if how.as_json:
        how.write(render.diagnosis_json(diagnosis))
    elif how.full:
        write_report(reporting.diagnosis_report(diagnosis, title))
    else:
        write_report(reporting.diagnosis_brief(diagnosis, how.again))


def _write_poses(diagnosis: DiagnosisOfPoses, title: str, how: _How) -> None:
    if how.as_json:
        how.write(render.poses_diagnosis_json(diagnosis))
    elif how.full:
        write_report(reporting.poses_report(diagnosis, title))
    else:
        write_report(reporting.poses_brief(diagnosis, how.again))
