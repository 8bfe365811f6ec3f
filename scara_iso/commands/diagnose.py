"""`diagnose`: what a model leaves unexplained, which effect it lacks; what a test will tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from scara_iso import diagnosis, iso9283, render, reporting
from scara_iso.base.errors import DataError, ScaraIsoError, UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.commands.shared import inputs, options as opt, output as out
from scara_iso.commands.shared.series import MeasurementSeries
from scara_iso.diagnosis import SEED, CyclesWanted, Diagnosis, DiagnosisOfPoses, FoundAtPoses
from scara_iso.effects import Conditions, OwnEffect, find_effects
from scara_iso.iso9283 import Analysis, limit_of_plane, poses_in_cycles
from scara_iso.reporting import Failure, left_unused
from scara_iso.robot import Arm, Model, read_model
from scara_iso.run import FloatArray, Run, no_such_pose

_FEWEST_POSES = 2
_SIGMA_MM, _RESOLUTION_MM = 0.005, 0.001


def diagnose(
    table: inputs.Tables,
    model: Model | str | Path | None = None,
    *,
    condition: str | None = None,
    pose: str | None = None,
    hold_out: inputs.Tables | None = None,
    reach: bool = False,
    limit: float | str | None = None,
    sigma: float | None = None,
    seed: int = SEED,
    own_effects: inputs.OwnEffects = (),
    **options: Unpack[inputs.TablesOptions],
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
    reading, counting = inputs.reading_and_counting(diagnose, options)
    found = inputs.read_series(table, reading, condition)
    run, wanted = found.readings, CyclesWanted(pose, found.counted(counting))
    most = None if limit is None else limit_of_plane(limit, run)
    reach = reach or limit is not None
    own = inputs.load_effects(own_effects)
    known = None if model is None else inputs.load_model(model, own)
    unseen = inputs.held_out_pose(run, hold_out)
    second = None if hold_out is None or unseen is not None else inputs.read_run(hold_out, reading)
    how: dict[str, Any] = {"hold_out": second, "seed": seed, "sigma": sigma, "own": own}
    if pose is None and len(list(run.rows_by_pose())) > 1:
        poses = _at_poses(run, known, wanted, how, held_out=unseen, reach=reach, limit=most)
        return replace(poses, notes=(*_seen(run, second), *left_unused(run), *poses.notes))
    if reach:
        raise UsageError("the map is made of several poses", remedy="name a table of a test")
    if second is not None and pose is None and len(list(second.rows_by_pose())) > 1:
        raise DataError(
            "has several poses, and what it is held out of has one",
            where=second.origin.source,
            remedy="hold out a table of one pose",
        )
    one = diagnosis.close_the_loop(run, known, wanted, **how)
    return replace(one, notes=(*_seen(run, second), *left_unused(run), *one.notes))


def _seen(run: Run, second: Run | None) -> tuple[str, ...]:
    """Return what is to be said where the table that is held out is the first one again."""
    if second is None or len(second) != len(run):
        return ()
    pairs = [(axis, second.axes[name]) for name, axis in run.axes.items() if name in second.axes]
    if not all(np.allclose(a.readings, b.readings, rtol=0, atol=1e-9) for a, b in pairs):
        return ()
    return ("the second table holds the same readings: none of its cycles is unseen",)


def _at_poses(
    run: Run, model: Model | None, wanted: CyclesWanted, how: dict[str, Any], **asked: Any
) -> DiagnosisOfPoses:
    """Return what is found at the poses, traced to the joints where a model is named.

    ``asked`` for a pose that is held out, or the map.
    """
    seen = [rows for label, rows in run.rows_by_pose() if label != asked["held_out"]]
    if len(seen) <= 1:
        raise UsageError("fewer than two poses are left to fit", remedy="leave `hold_out=` out")
    fitted = run.take(np.sort(np.concatenate(seen)))
    found = diagnosis.close_the_loop_at_poses(fitted, model, wanted, **how)
    if model is not None:
        return diagnosis.with_joint_scatter(found, run, model, wanted, **asked)
    if asked["held_out"] is not None or asked["reach"]:
        raise UsageError(
            "to predict a pose from the others takes the joints of a model",
            remedy="name a model that gives links and [pose.P1] joint_deg: `model=`",
        )
    return found


def are_unrelated(tables: Sequence[str], reading: inputs.Reading) -> bool:
    """Say whether tables are several tests: one names no pose, and they share an axis."""
    if len(tables) == 1 or all(inputs.names_a_pose(table, reading) for table in tables):
        return False
    known: set[str] = set()
    for table in tables:
        try:
            axes = {*inputs.read_run(table, reading).axes}
        except ScaraIsoError:
            return True
        if axes & known:
            return True
        known |= axes
    return False


def diagnose_analysis(
    analysis: Analysis, model: Model | None, wanted: CyclesWanted, own: Sequence[OwnEffect] = ()
) -> tuple[dict[str | None, Diagnosis | Failure], tuple[FoundAtPoses, ...]]:
    """Return the diagnosis of each pose, and the effects of all together where there are several.

    Too few cycles for one are said, a wrong model raises.
    """
    labels = [pose.label for pose in poses_in_cycles(analysis)]
    if not labels:  # a drift test is its own course
        return {}, ()
    try:
        if len(labels) > 1:
            found = diagnosis.close_the_loop_at_poses(
                analysis.run, model, wanted, seed=SEED, own=own
            )
            return {label: found[str(label)] for label in labels}, found.effects
        one = diagnosis.close_the_loop(analysis.run, model, wanted, seed=SEED, own=own)
        return {labels[0]: one}, ()
    except ScaraIsoError as error:
        if model is not None:
            raise
        return dict.fromkeys(labels, Failure(error.headline, error.exit_code)), ()


def _limit_of_map(texts: Sequence[str]) -> float | str:
    given = opt.parse_limits(texts)
    for other in sorted(given.keys() - {"", "XY"}):
        raise UsageError(f"--limit {other}: the map is of RP in XY", remedy="write --limit XY=0.02")
    return next(iter(given.values()))


@opt.takes_options_of(
    diagnose,
    table=opt.argument(
        "Tables of readings, or a folder: poses of one test, or unrelated tests.",
        "TABLE...",
        list[str] | None,
    ),
    model=opt.option("Model file of the robot [none: a constant pose].", metavar="MODEL"),
    hold_out=opt.option(
        "Second table, on which the error is measured, or pose of the test to be predicted.",
        metavar="TABLE|POSE",
    ),
    limit=opt.option(
        "Limit of RP in XY: shows where in the reach it is kept.",
        kind=list[str] | None,
        read=_limit_of_map,
        metavar="XY=SIZE",
    ),
    pose=opt.option("Pose to diagnose, where the table has several."),
    sigma=opt.option("Scatter without any effect [mm], known or assumed for a plan [0.005]."),
    seed=opt.option("Seed of the shuffles.", min=0),
    save_model=opt.option("Model file to write, with the effects found.", metavar="NEW"),
    plot=opt.option("Picture of the readings before and after, .svg or .png."),
    map_=opt.option("Map of RP over the robot's reach: .png, .svg or .csv.", "--map"),
    design=opt.option(
        "Show what a planned test will tell; no readings are needed. --columns are then "
        "those of the plan: approach,temperature_C."
    ),
)
def diagnose_command(
    asked: opt.Asked[Diagnosis | DiagnosisOfPoses],
    *,
    save_model: Path | None = None,
    plot: Path | None = None,
    map_: Path | None = None,
    design: bool = False,
    full: bool = False,
    json: bool = False,
) -> None:
    """Find what besides scatter is in the readings: effect, cause, how much it explains.

    Example: scara-iso diagnose run.csv --model robot.toml --save-model new.toml
    """
    tables: list[str] = asked["table"] or []
    given = {
        "--hold-out": asked["hold_out"],
        "--limit": asked["limit"] or None,
        "--sigma": asked["sigma"],
        "--save-model": save_model,
        "--plot": plot,
        "--map": map_,
    }
    if design:
        _refuse({**given, "--sigma": None}, "does not go with --design", "leave it out")
        _design(asked).give(json=json)
        return
    _check(tables, asked["model"], given)
    files = [*tables, asked["model"], asked["own_effects"], asked["hold_out"]]
    out.check_outputs([save_model, map_], files, pictures=[plot])
    if asked["condition"] is None and are_unrelated(tables, asked.reading):
        from scara_iso.commands.diagnose_many import answer_of_many

        of_test = {name: given[name] for name in ("--hold-out", "--map", "--limit")}
        _refuse(of_test, "is for one test", "name its tables by their poses, P1.csv P2.csv")
        answer_of_many(tables, asked).give(json=json)
        return
    found = inputs.each_series(tables, asked.reading, asked["condition"])
    maps = {one.name: out.path_under(map_, one.name, found) for one in found}
    out.check_outputs([*maps.values()], [])
    measured, results = out.recorded_among(found), []
    for one in measured:
        results.append(_diagnosis(one, asked, save_model, plot, maps[one.name]))
        if not json:
            out.say_condition(one, found)
            again = partial(opt.command_line, tables, _read_again(one, asked))
            out.write_report(_report(results[-1], again), full=full)
    if json:
        out.write_results(measured, results, of=len(found))


def _read_again(one: MeasurementSeries, asked: opt.Asked[Any]) -> dict[str, object]:
    """Return the options by which another command reads the same readings."""
    if one.under:
        return {"condition": one.name, "effects": asked["own_effects"]}
    return asked.stated(*opt.READING, "pose", *opt.COUNTING, "own_effects")


def _diagnosis(
    one: MeasurementSeries,
    asked: opt.Asked[Diagnosis | DiagnosisOfPoses],
    save_to: Path | None,
    plot: Path | None,
    map_: Path | None,
) -> Diagnosis | DiagnosisOfPoses:
    run, second = one.readings, asked["hold_out"]
    options = asked.options("table", "condition", *opt.READING)
    if second is not None and inputs.held_out_pose(run, second) is None:
        labels = [label for label, _ in run.rows_by_pose()]
        if asked["pose"] is None and len(labels) > 1 and not Path(second).exists():
            raise no_such_pose(second, labels, run.origin.source)
        options["hold_out"] = inputs.read_run(second, asked.reading)
    own = inputs.load_effects(asked["own_effects"])
    found = diagnose(one, **options | {"own_effects": own, "reach": map_ is not None})
    if save_to is not None:
        notes = diagnosis.save_model(found, asked["model"], save_to, own)
        out.tell_written(save_to)
        found = replace(found, notes=(*found.notes, *notes))
    out.write_picture(found, plot)
    if map_ is not None and isinstance(found, DiagnosisOfPoses) and found.joint_scatter:
        render.save_map(found.joint_scatter, map_)
        out.tell_written(map_)
    return found


def _report(found: Diagnosis | DiagnosisOfPoses, again: partial[str]) -> reporting.Report:
    if isinstance(found, Diagnosis):
        return reporting.diagnosis_report(found, again)
    return reporting.poses_report(found, again)


def _check(tables: Sequence[str], model: str | None, given: Mapping[str, Any]) -> None:
    if not tables:
        raise UsageError("no table is named", remedy="name one, or ask for --design")
    if len(tables) > 1:
        single = {name: given[name] for name in ("--save-model", "--plot", "--sigma")}
        _refuse(single, "is for one table", "diagnose the tables one by one")
    if model is None:
        joints = "name one that gives links and [pose.P1] joint_deg"
        whole = "name the model to add to; a file with a line [indicator.X] for each axis is one"
        _refuse({"--save-model": given["--save-model"]}, "needs --model", whole)
        _refuse({name: given[name] for name in ("--map", "--limit")}, "needs --model", joints)
    if given["--limit"] is not None:
        _limit_of_map(given["--limit"])
    if given["--map"] is not None:
        render.check_map(given["--map"])


def _refuse(given: Mapping[str, object], what: str, remedy: str) -> None:
    for name, value in given.items():
        if value is not None:
            raise UsageError(f"{name} {what}", remedy=remedy)


def _design(asked: opt.Asked[Any]) -> out.Answer:
    """Return what a test like that of a table, or of the options, will find.

    With a model it is one of several poses, and what it finds is in the joints.
    """
    tables, sigma, seed = asked["table"] or [], asked["sigma"], asked["seed"]
    if len(tables) > 1:
        raise UsageError("--design takes one table at most", remedy="name one of them")
    if sigma is not None and not 0 < sigma < math.inf:
        raise UsageError(
            f"--sigma {sigma:g}: not a positive, finite length",
            remedy="write it in mm, as --sigma 0.005",
        )
    effects = find_effects(inputs.load_effects(asked["own_effects"]))
    reading, wanted = asked.reading, CyclesWanted(asked["pose"], asked.counting)
    run = inputs.read_run(tables[0], reading) if tables else None
    if asked["model"] is not None:
        test = _of_poses(read_model(asked["model"]), run, reading, wanted, sigma)
        of_poses = diagnosis.design_of_poses(test, seed=seed, effects=effects)
        return out.Answer(of_poses, lambda: reporting.design_of_poses_report(of_poses))
    plan = _planned(reading, wanted, sigma) if run is None else _like(wanted.take(run), sigma)
    found = diagnosis.design(plan, seed=seed, effects=effects)
    return out.Answer(found, lambda: reporting.design_report(found))


def _of_poses(
    model: Model,
    run: Run | None,
    reading: inputs.Reading,
    wanted: CyclesWanted,
    sigma: float | None,
) -> diagnosis.PlannedPosesTest:
    """Return the test of a model's poses, like that of a table where one is named."""
    arm, poses = _arm_at(model, run)
    if run is None:
        dial = _planned(reading, wanted, sigma)
        variances = np.array([0.0, 0.0, dial.sigma**2, 0.0])
        steps = (dial.division, dial.division)
        return diagnosis.PlannedPosesTest(dial.conditions, arm, poses, variances, steps)
    used = wanted.used(run.unwrapped())
    rows = {str(pose): rows for pose, rows in zip(used.poses, used.rows, strict=True)}
    test = diagnosis.like_test(diagnosis.whole_cycles(run, rows), arm, poses)
    if sigma is None:
        return test
    return replace(test, variances=np.array([0.0, 0.0, sigma**2, 0.0]))


def _arm_at(model: Model, run: Run | None) -> tuple[Arm, dict[str, tuple[float, float]]]:
    """Return the arm, and its joints at each arrival of a table's cycle, or at a model's poses."""
    at = {pose: pose for pose in model.poses}
    if run is not None:
        at = {str(label): str(run.arrival_at(label)[0]) for label, _ in run.rows_by_pose()}
    known = {arrival: model.poses[pose] for arrival, pose in at.items() if pose in model.poses}
    if model.arm is None or len(set(at.values())) < _FEWEST_POSES or len(known) < len(at):
        raise UsageError(
            "--model does not go with --design but for a test of several poses",
            remedy="give links and [pose.P1] joint_deg at each of them, or leave it out",
        )
    return model.arm, known


def _like(run: Run, sigma: float | None) -> diagnosis.PlannedRun:
    """Return the test of a table: its columns, its dial, its scatter from cycle to cycle."""
    lengths = [axis for axis in run.axes.values() if axis.dimension is Dimension.LENGTH]
    if not lengths:
        raise DataError(
            "no axis in mm",
            where=run.origin.source,
            remedy="plan without the table: --sigma and --resolution, angles read as mm",
        )
    axis = max(lengths, key=lambda axis: _scatter(axis.readings))
    scatter = sigma or _scatter(axis.readings) or (axis.resolution or _RESOLUTION_MM)
    return diagnosis.PlannedRun(
        Conditions(run.cycle, run.covariates), scatter, axis.resolution or 0.0
    )


def _scatter(readings: FloatArray) -> float:
    """Return the standard deviation from successive differences, which a slow course leaves."""
    return float(np.sqrt((np.diff(readings) ** 2).mean() / 2)) if len(readings) > 1 else 0.0


def _planned(
    reading: inputs.Reading, wanted: CyclesWanted, sigma: float | None
) -> diagnosis.PlannedRun:
    """Return the cycles that are planned, with the columns that are named, and their dial."""
    cycle = np.arange(2, (wanted.counting.cycles or iso9283.CYCLES_RUN) + 1)
    known = diagnosis.planned_columns(cycle)
    names = [name.strip() for name in str(reading.get("columns") or "").split(",") if name.strip()]
    if unknown := [name for name in names if name not in known]:
        raise UsageError(
            f"--columns {unknown[0]}: no such column", remedy=f"known are {', '.join(known)}"
        )
    conditions = Conditions(cycle, {name: known[name] for name in names})
    division = reading.get("resolution")
    return diagnosis.PlannedRun(
        conditions, sigma or _SIGMA_MM, _RESOLUTION_MM if division is None else division
    )
