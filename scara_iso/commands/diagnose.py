"""`diagnose`: what a model leaves unexplained, and which effect it lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Unpack

import numpy as np
import typer

from scara_iso import diagnosis, render, reporting
from scara_iso.base.errors import DataError, ScaraIsoError, UsageError
from scara_iso.commands.conditions import ConditionRun, read_conditions
from scara_iso.commands.diagnose_design import Files, refuse_beside_design
from scara_iso.commands.folders import (
    Write,
    say_condition,
    say_missing,
    test_folder,
    write_conditions,
)
from scara_iso.commands.inputs import (
    OwnEffects,
    TableOptions,
    Tables,
    TablesOptions,
    defined,
    described,
    held_out_pose,
    parted,
)
from scara_iso.commands.options import (
    AsJson,
    ConditionName,
    Full,
    OwnEffectsFile,
    takes_tables,
)
from scara_iso.commands.output import (
    check_outputs,
    command_line,
    tell_written,
    write_picture,
    write_report,
    write_result,
)
from scara_iso.diagnosis import SEED, CyclesWanted, close_the_loop, close_the_loop_at_poses
from scara_iso.effects import OwnEffect
from scara_iso.iso9283 import Analysis, Counting, poses_in_cycles
from scara_iso.reporting import Failure
from scara_iso.run import Run
from scara_iso.tables import pose_in

if TYPE_CHECKING:
    from scara_iso.diagnosis import Diagnosis, DiagnosisOfPoses
    from scara_iso.robot import Model


def diagnose(
    table: Tables,
    model: Model | str | Path | None = None,
    *,
    condition: str | None = None,
    pose: str | None = None,
    hold_out: Tables | None = None,
    reach: bool = False,
    limit: float | None = None,
    sigma: float | None = None,
    seed: int = SEED,
    own_effects: OwnEffects = (),
    **options: Unpack[TablesOptions],
) -> Diagnosis | DiagnosisOfPoses:
    """Return what a model (or its file; None: a constant pose) leaves unexplained in a table.

    Several poses (a column, or several tables as in `analyze`) are searched together and give a
    `DiagnosisOfPoses`, with a model of the arm and ``[pose.P1]`` and so on traced to its joints,
    effects and scatter alike; ``pose`` names one of them. ``hold_out`` is a
    second table that measures the error on unseen cycles, or of several poses the name of one that
    takes no part; ``reach`` adds RP over the workspace, ``limit`` (in mm) also where it is at most
    that. The other options are those of `analyze`,
    for both tables, and so is the folder of a test. ``sigma`` is the known scatter in mm.
    ``own_effects`` are the user's, or the file that defines them. Same arguments, same result.
    Raises `DataError` for a table that cannot be read, breaks the cycle rule, or is not of the
    model, and `UsageError` for a pose that is not there.
    """
    reading, counting = parted(**options)
    if (measured := reading.measured(table, condition)) is not None:
        table, counting = measured.readings, measured.counted(counting)
    wanted = CyclesWanted(pose, counting)
    if limit is not None and not 0 < limit < np.inf:
        raise UsageError(
            f"`limit={limit:g}`: not a positive, finite length",
            remedy="write it in mm, as `limit=0.02`",
        )
    reach = reach or limit is not None
    own = defined(own_effects)
    run = reading.read(table)
    known = None if model is None else described(model, own)
    unseen = held_out_pose(run, hold_out)
    second = None if hold_out is None or unseen is not None else reading.read(hold_out)
    if pose is None and len(list(run.rows_by_pose())) > 1:
        search = partial(close_the_loop_at_poses, hold_out=second, seed=seed, sigma=sigma, own=own)
        found = _of_poses(run, known, wanted, search, unseen=unseen, reach=reach, limit=limit)
        return replace(found, notes=(*_seen(run, second), *found.notes))
    if reach:
        raise UsageError("the map is made of several poses", remedy="name a table of a test")
    if second is not None and pose is None and len(list(second.rows_by_pose())) > 1:
        raise DataError(
            "has several poses, and what it is held out of has one",
            where=second.origin.source,
            remedy="hold out a table of one pose",
        )
    one = close_the_loop(run, known, wanted, hold_out=second, sigma=sigma, seed=seed, own=own)
    return replace(one, notes=(*_seen(run, second), *one.notes))


def _seen(run: Run, second: Run | None) -> tuple[str, ...]:
    """Return what is to be said where the table that is held out is the first one again."""
    if second is None or len(second) != len(run):
        return ()
    pairs = [(axis, second.axes[name]) for name, axis in run.axes.items() if name in second.axes]
    if not all(np.allclose(a.readings, b.readings, rtol=0, atol=1e-9) for a, b in pairs):
        return ()
    return ("the second table holds the same readings: none of its cycles is unseen",)


def _of_poses(
    run: Run,
    model: Model | None,
    wanted: CyclesWanted,
    search: Callable[[Run, Model | None, CyclesWanted], DiagnosisOfPoses],
    *,
    unseen: str | None,
    reach: bool,
    limit: float | None,
) -> DiagnosisOfPoses:
    if model is None and (unseen is not None or reach):
        raise UsageError(
            "what other poses say of one takes the joints",
            remedy="name a model that gives links and [pose.P1] joint_deg: `model=`",
        )
    seen = [rows for label, rows in run.rows_by_pose() if label != unseen]
    if len(seen) <= 1:
        raise UsageError("no two poses are left to fit", remedy="hold none of them out")
    fitted = run.take(np.sort(np.concatenate(seen)))
    found = search(fitted, model, wanted)
    read = run.origin.notes if run.origin.files else ()
    found = replace(found, notes=(*read, *found.notes))
    if model is None:
        return found
    return diagnosis.with_joint_scatter(
        found, run, model, wanted, held_out=unseen, reach=reach, limit=limit
    )


def one_test(tables: Sequence[str], reading: TableOptions) -> Run | None:
    """Return the run of tables that name a pose each, None where one does not: they are unrelated.

    Raises as `TableOptions.read`.
    """
    if len(tables) == 1 or all(_names_a_pose(table, reading) for table in tables):
        return reading.read(tables)
    return None


def _names_a_pose(table: str, reading: TableOptions) -> bool:
    if pose_in(Path(table).name):
        return True
    try:
        run = reading.read(table)
    except ScaraIsoError:
        return False  # the summary of unrelated tables says why
    return run.pose is not None or "pose" in run.metadata


def diagnose_analysis(
    analysis: Analysis, model: Model | None, wanted: CyclesWanted, own: Sequence[OwnEffect] = ()
) -> dict[str | None, Diagnosis | Failure]:
    """Return the diagnosis of each pose; too few cycles for one are said, a wrong model raises."""
    labels = [pose.label for pose in poses_in_cycles(analysis)]
    if not labels:  # a drift test is its own course
        return {}
    try:
        if len(labels) > 1:
            found = close_the_loop_at_poses(analysis.run, model, wanted, seed=SEED, own=own)
            return {label: found[str(label)] for label in labels}
        return {labels[0]: close_the_loop(analysis.run, model, wanted, seed=SEED, own=own)}
    except ScaraIsoError as error:
        if model is not None:
            raise
        return dict.fromkeys(labels, Failure(error.headline, error.exit_code))


DiagnosedTables = Annotated[
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
    tables: DiagnosedTables = None,
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

    wanted = CyclesWanted(pose, counting)
    named = tables or []
    files = Files(model, effects, hold_out, save_model, plot, map_, limit, sigma)
    if design:
        from scara_iso.commands.diagnose_design import show_design

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
        from scara_iso.commands.diagnose_many import show_many

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
    if second is not None and held_out_pose(run, second) is None:
        second = reading.read(second)
    own = defined(files.effects or ())
    diagnosis = diagnose(
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
        _write(diagnosis, how)
        return
    if files.map is not None and diagnosis.joint_scatter is not None:
        render.save_map(diagnosis.joint_scatter, files.map)
        tell_written(files.map)
    _write_poses(diagnosis, how)


def _write(diagnosis: Diagnosis, how: _How) -> None:
    if how.as_json:
        from scara_iso.diagnosis import published_diagnosis

        how.write(published_diagnosis(diagnosis))
    else:
        write_report(reporting.diagnosis_report(diagnosis, how.again), full=how.full)


def _write_poses(diagnosis: DiagnosisOfPoses, how: _How) -> None:
    if how.as_json:
        from scara_iso.diagnosis import published_poses_diagnosis

        how.write(published_poses_diagnosis(diagnosis))
    else:
        write_report(reporting.poses_report(diagnosis, how.again), full=how.full)


def diagnose_folder(
    folder: str,
    condition: str | None,
    diagnose: Callable[[ConditionRun, Run, Write], None],
    *,
    check: Callable[[str], object],
    as_json: bool,
) -> None:
    """Diagnose each condition of a test that has readings; say of the others what is missing.

    ``check`` gets the name of each before the first begins. The JSON objects of several conditions
    go into one.
    """
    found = read_conditions(folder, condition)
    for one in found:
        check(one.condition.name)
    documents: list[reporting.ConditionResult] = []
    for one in found:
        if one.run is None:
            say_missing(one)
            continue

        def write(result: reporting.OfTable, one: ConditionRun = one) -> None:
            documents.append(reporting.published_condition(one, result))

        if not as_json:
            say_condition(one, found)
        diagnose(one, one.run, write if len(found) > 1 else write_result)
    if documents:
        write_conditions(documents)
