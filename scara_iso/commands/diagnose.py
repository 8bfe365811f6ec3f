"""`diagnose`: what a model leaves unexplained, and which effect it lacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Unpack

import numpy as np
import typer

from scara_iso import diagnosis, render, reporting
from scara_iso.base.disk import check_output
from scara_iso.base.errors import DataError, ScaraIsoError, UsageError
from scara_iso.commands.inputs import (
    OwnEffects,
    TableOptions,
    Tables,
    TablesOptions,
    defined,
    described,
    held_out_pose,
    names_a_pose,
    parted,
)
from scara_iso.commands.options import (
    AsJson,
    ConditionName,
    Full,
    OwnEffectsFile,
    parse_limits,
    takes_tables,
)
from scara_iso.commands.output import (
    check_outputs,
    command_line,
    say_condition,
    say_missing,
    tell_written,
    write_picture,
    write_report,
    write_results,
)
from scara_iso.commands.series import MeasurementSeries
from scara_iso.diagnosis import (
    SEED,
    CyclesWanted,
    Diagnosis,
    DiagnosisOfPoses,
    close_the_loop,
    close_the_loop_at_poses,
    save_model,
)
from scara_iso.effects import OwnEffect
from scara_iso.iso9283 import Analysis, Counting, limit_of_plane, poses_in_cycles
from scara_iso.reporting import Failure
from scara_iso.run import Run, no_such_pose

if TYPE_CHECKING:
    from scara_iso.robot import Model


def diagnose(
    table: Tables,
    model: Model | str | Path | None = None,
    *,
    condition: str | None = None,
    pose: str | None = None,
    hold_out: Tables | None = None,
    reach: bool = False,
    limit: float | str | None = None,
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
    takes no part; ``reach`` adds RP over the workspace, ``limit`` (in mm, or ``"20um"``) also where
    it is at most that. The other options are those of `analyze`, for both tables,
    and so is the folder of a test. ``sigma`` is the known scatter in mm.
    ``own_effects`` are the user's, or the file that defines them. Same arguments, same result.
    Raises `DataError` for a table that cannot be read, breaks the cycle rule, or is not of the
    model, and `UsageError` for a pose that is not there.
    """
    reading, counting = parted(diagnose, options)
    found = reading.source(table, condition)
    run, wanted = found.readings, CyclesWanted(pose, found.counted(counting))
    most = None if limit is None else limit_of_plane(limit, run)
    reach = reach or limit is not None
    own = defined(own_effects)
    known = None if model is None else described(model, own)
    unseen = held_out_pose(run, hold_out)
    second = None if hold_out is None or unseen is not None else reading.read(hold_out)
    if pose is None and len(list(run.rows_by_pose())) > 1:
        search = partial(close_the_loop_at_poses, hold_out=second, seed=seed, sigma=sigma, own=own)
        joint = _of_poses(run, known, wanted, search, unseen=unseen, reach=reach, limit=most)
        return replace(joint, notes=(*_seen(run, second), *joint.notes))
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


def are_unrelated(tables: Sequence[str], reading: TableOptions) -> bool:
    """Say whether tables are several tests: one of them names no pose."""
    return len(tables) > 1 and not all(names_a_pose(table, reading) for table in tables)


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
    typer.Option(metavar="XY=SIZE", help="RP in XY that is wanted: where in the reach it is kept."),
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
    wanted = CyclesWanted(pose, counting)
    named = tables or []
    files = Files(model, effects, hold_out, save_model, plot, map_, limit, sigma)
    if design:
        from scara_iso.commands.diagnose_design import show_design

        refuse_with_design(files)
        own = (model, effects)
        show_design(named, own, reading, wanted, sigma=sigma, seed=seed, as_json=json)
        return
    files.check(named)
    check_outputs([save_model, map_], [*named, model, effects, hold_out], pictures=[plot])
    if condition is None and are_unrelated(named, reading):
        from scara_iso.commands.diagnose_many import show_many

        files.refuse_of_test()
        show_many(named, (model, effects), reading, wanted, seed=seed, as_json=json)
        return
    found = reading.sources(named, condition)
    of_each = [files.under(one.name) for one in found]
    results: list[tuple[MeasurementSeries, reporting.OfTable]] = []
    for one, its in zip(found, of_each, strict=True):
        if one.run is None:
            say_missing(one)
            continue
        diagnosis = _diagnosis(one, its, reading, wanted, seed=seed)
        if json:
            results.append((one, diagnosis))
            continue
        if len(found) > 1:
            say_condition(one)
        again = partial(command_line, named, _read_again(one, effects, reading, wanted))
        write_report(_report(diagnosis, again), full=full)
    write_results([one for one, _ in results], [made for _, made in results], of=len(found))


def _read_again(
    one: MeasurementSeries, effects: str | None, reading: TableOptions, wanted: CyclesWanted
) -> dict[str, object]:
    """Return the options by which another command reads the same readings."""
    if one.under:
        return {"condition": one.name, "effects": effects}
    return asdict(reading) | {"pose": wanted.pose} | asdict(wanted.counting) | {"effects": effects}


def _diagnosis(
    found: MeasurementSeries,
    files: Files,
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    seed: int,
) -> Diagnosis | DiagnosisOfPoses:
    """Return the diagnosis, and write model, picture and map where they are wanted."""
    run = found.readings
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
        **asdict(found.counted(wanted.counting)),
        hold_out=second,
        reach=files.map is not None,
        limit=files.limit_of_plane(),
        seed=seed,
        sigma=files.sigma,
        own_effects=own,
    )
    if files.save_model is not None and files.model is not None:
        notes = save_model(diagnosis, files.model, files.save_model, own)
        tell_written(files.save_model)
        diagnosis = replace(diagnosis, notes=(*diagnosis.notes, *notes))
    write_picture(diagnosis, files.plot)
    scatter = None if isinstance(diagnosis, Diagnosis) else diagnosis.joint_scatter
    if files.map is not None and scatter is not None:
        render.save_map(scatter, files.map)
        tell_written(files.map)
    return diagnosis


def _report(found: Diagnosis | DiagnosisOfPoses, again: Callable[..., str]) -> reporting.Report:
    """Return the report, with the command lines that ``again`` gives of its table."""
    if isinstance(found, Diagnosis):
        return reporting.diagnosis_report(found, again)
    return reporting.poses_report(found, again)


@dataclass(frozen=True, slots=True)
class Files:
    """What the diagnosis of one test takes and writes beside it."""

    model: str | None
    effects: str | None
    hold_out: str | None
    save_model: Path | None
    plot: Path | None
    map: Path | None
    limit: Sequence[str] | None
    sigma: float | None

    def under(self, condition: str) -> Files:
        """Return these for one condition of a test, each of which has a map of its own."""
        if self.map is None or not condition:
            return self
        named = self.map.with_name(f"{self.map.stem}-{condition}{self.map.suffix}")
        check_output(named)
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
        for option, value in {"--map": self.map, "--limit": self.limit}.items():
            if value is not None and self.model is None:
                raise UsageError(
                    f"{option} needs --model",
                    remedy="name one that gives links and [pose.P1] joint_deg",
                )
        self.limit_of_plane()
        if self.map is not None:
            render.check_map(self.map)

    def limit_of_plane(self) -> float | str | None:
        """Return the limit of RP in XY; `UsageError` for another one."""
        given = parse_limits(self.limit or ())
        if set(given) - {"", "XY"}:
            raise UsageError(
                f"--limit {min(set(given) - {'', 'XY'})}: the map is of RP in XY",
                remedy="write --limit XY=0.02",
            )
        return next(iter(given.values()), None)

    def refuse_of_test(self) -> None:
        """Raise `UsageError` where something is wanted that unrelated tables do not give."""
        asked = {"--hold-out": self.hold_out, "--map": self.map, "--limit": self.limit}
        _refuse(asked, "is for one test", "name its tables by their poses, P1.csv P2.csv")

    def check_poses(self, run: Run) -> None:
        """Raise `UsageError` where what is held out is neither a pose of ``run`` nor a file."""
        second = self.hold_out is not None and held_out_pose(run, self.hold_out) is None
        if second and not Path(self.hold_out or "").exists():
            labels = (label for label, _ in run.rows_by_pose())
            raise no_such_pose(self.hold_out or "", labels, run.origin.source)


def _refuse(given: Mapping[str, object], what: str, remedy: str) -> None:
    for option, value in given.items():
        if value is not None:
            raise UsageError(f"{option} {what}", remedy=remedy)


def refuse_with_design(files: Files) -> None:
    """Raise `UsageError` where something is wanted that needs readings."""
    given = {
        "--hold-out": files.hold_out,
        "--save-model": files.save_model,
        "--plot": files.plot,
        "--map": files.map,
        "--limit": files.limit,
    }
    _refuse(given, "does not go with --design", "leave it out")
