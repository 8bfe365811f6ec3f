"""``scara-iso diagnose``: what the model leaves unexplained, and which effect it lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso import library, render, reporting
from scara_iso.cli.diagnose_files import Files, refuse_beside_design
from scara_iso.cli.folders import test_folder
from scara_iso.cli.options import (
    AsJson,
    ConditionName,
    Full,
    OwnEffectsFile,
    takes_tables,
)
from scara_iso.cli.output import (
    check_outputs,
    command_line,
    tell_written,
    write_picture,
    write_report,
    write_result,
)
from scara_iso.iso9283 import Counting
from scara_iso.library import TableOptions

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
Limit = Annotated[
    list[str] | None,
    typer.Option(metavar="XY=MM", help="RP in XY that is wanted: where over the reach it is kept."),
]
SaveModel = Annotated[
    Path | None, typer.Option(metavar="NEW", help="Write the model with the effects declared.")
]
Plot = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Before and after as .svg or .png.")
]
Pose = Annotated[str | None, typer.Option(help="Which pose, where the table has several.")]
Design = Annotated[
    bool,
    typer.Option(
        "--design",
        help="What a planned test will tell; needs no readings. --columns are then the plan's: "
        "approach,temperature_C.",
    ),
]
Sigma = Annotated[
    float | None,
    typer.Option(
        help="Scatter of the readings where nothing acts [mm]: known, or planned (else 0.005)."
    ),
]
Seed = Annotated[int, typer.Option(help="Seed of the shuffles.", min=0)]


@takes_tables
def diagnose_command(
    tables: Tables = None,
    *,
    model: ModelOption = None,
    effects: OwnEffectsFile = None,
    hold_out: HoldOut = None,
    save_model: SaveModel = None,
    plot: Plot = None,
    map_: Map = None,
    limit: Limit = None,
    pose: Pose = None,
    design: Design = False,
    sigma: Sigma = None,
    seed: Seed = 9283,
    reading: TableOptions,
    counting: Counting,
    condition: ConditionName = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Say what besides scatter is in the readings: its effect, its cause, how much it explains.

    Example: scara-iso diagnose run.csv --model robot.toml --save-model new.toml
    """
    from scara_iso.diagnosis import CyclesWanted
    from scara_iso.library import one_test

    wanted = CyclesWanted(pose, counting)
    named = tables or []
    files = Files(model, effects, hold_out, save_model, plot, map_, limit, sigma)
    if design:
        from scara_iso.cli.diagnose_design import show_design

        refuse_beside_design(files)
        show_design(named, files, reading, wanted, seed=seed, as_json=json)
        return
    files.check(named)
    check_outputs([save_model, map_], [*named, model, effects, hold_out], pictures=[plot])
    show = partial(_How, full=full, as_json=json)
    if (folder := test_folder(named, condition, reading)) is not None:
        _diagnose_folder(folder, condition, files, reading, wanted, show, seed=seed, as_json=json)
        return
    run = one_test(named, reading)
    if run is None:
        from scara_iso.cli.diagnose_many import show_many

        files.refuse_of_test()
        show_many(named, (model, effects), reading, wanted, seed=seed, as_json=json)
    else:
        options = asdict(reading) | {"pose": pose} | asdict(counting) | {"effects": effects}
        how = show(partial(command_line, named, options))
        _diagnose_run(run, files, reading, wanted, how, seed=seed)


def _diagnose_folder(
    folder: str,
    condition: str | None,
    files: Files,
    reading: TableOptions,
    wanted: CyclesWanted,
    show: Callable[..., _How],
    *,
    seed: int,
    as_json: bool,
) -> None:
    from scara_iso.cli.conditions import diagnose_folder

    def diagnose(one: ConditionRun, run: Run, write: Write) -> None:
        counting = replace(wanted, counting=one.counted(wanted.counting))
        options = {"condition": one.condition.name, "effects": files.effects}
        how = show(partial(command_line, [folder], options), write=write)
        _diagnose_run(run, files.under(one.condition.name), reading, counting, how, seed=seed)

    diagnose_folder(folder, condition, diagnose, check=files.under, as_json=as_json)


@dataclass(frozen=True, slots=True)
class _How:
    """How a diagnosis is written; ``again`` names its table in a command line."""

    again: Callable[..., str]
    full: bool
    as_json: bool
    write: Write = write_result


def _diagnose_run(
    run: Run,
    files: Files,
    reading: TableOptions,
    wanted: CyclesWanted,
    how: _How,
    *,
    seed: int,
) -> None:
    from scara_iso.diagnosis import Diagnosis

    if wanted.pose is None and len(list(run.rows_by_pose())) > 1:
        files.check_poses(run)
    second: Run | str | None = files.hold_out
    if second is not None and library.held_out_pose(run, second) is None:
        second = reading.read(second)
    own = library.defined(files.effects or ())
    diagnosis = library.diagnose(
        run,
        files.model,
        pose=wanted.pose,
        **asdict(wanted.counting),
        hold_out=second,
        reach=files.map is not None,
        limit=files.limit_of_plane(),
        seed=seed,
        sigma=files.sigma,
        own_effects=own,
    )
    if files.save_model is not None and files.model is not None:
        from scara_iso.diagnosis import save_model

        said = save_model(diagnosis, files.model, files.save_model, own)
        tell_written(files.save_model)
        diagnosis = replace(diagnosis, notes=(*diagnosis.notes, *said))
    write_picture(diagnosis, files.plot)
    if isinstance(diagnosis, Diagnosis):
        _write(diagnosis, run.origin.source, how)
        return
    if files.map is not None and diagnosis.joint_scatter is not None:
        render.save_map(diagnosis.joint_scatter, files.map)
        tell_written(files.map)
    _write_poses(diagnosis, run.origin.source, how)


def _write(diagnosis: Diagnosis, title: str, how: _How) -> None:
    if how.as_json:
        from scara_iso.diagnosis import published_diagnosis

        how.write(published_diagnosis(diagnosis))
    elif how.full:
        write_report(reporting.diagnosis_report(diagnosis, title))
    else:
        write_report(reporting.diagnosis_brief(diagnosis, how.again))


def _write_poses(diagnosis: DiagnosisOfPoses, title: str, how: _How) -> None:
    if how.as_json:
        from scara_iso.diagnosis import published_poses_diagnosis

        how.write(published_poses_diagnosis(diagnosis))
    elif how.full:
        write_report(reporting.poses_report(diagnosis, title))
    else:
        write_report(reporting.poses_brief(diagnosis, how.again))
