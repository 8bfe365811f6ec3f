"""`diagnose` and `diagnose_many`: what a model leaves unexplained in a table, or in several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np

from scara_iso import diagnosis, robot
from scara_iso.base.errors import DataError, ScaraIsoError, UsageError
from scara_iso.diagnosis import (
    SEED,
    CyclesWanted,
    close_the_loop,
    close_the_loop_at_poses,
)
from scara_iso.effects import OwnEffect
from scara_iso.iso9283 import Analysis, poses_in_cycles
from scara_iso.library.diagnoses import Diagnoses
from scara_iso.library.inputs import TableOptions, Tables, TablesOptions, parted
from scara_iso.library.model_files import OwnEffects, defined, described
from scara_iso.reporting import Failure
from scara_iso.run import Run
from scara_iso.tables import pose_in

if TYPE_CHECKING:
    from concurrent.futures import Executor

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


def held_out_pose(run: Run, hold_out: Tables | None) -> str | None:
    """Return the pose of a run that ``hold_out`` names, None where it is a table."""
    labels = [label for label, _ in run.rows_by_pose() if label is not None]
    return hold_out if isinstance(hold_out, str) and hold_out in labels else None


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


def diagnose_many(
    tables: Sequence[str | Path],
    model: str | Path | None = None,
    *,
    seed: int = SEED,
    own_effects: str | Path | None = None,
    executor: Executor | None = None,
    **options: Unpack[TablesOptions],
) -> Diagnoses:
    """Return the diagnosis of each of several unrelated tables, by number or by file name.

    ``executor`` shares the work, any of `concurrent.futures` (a cluster's too), else as many
    processes as there are cores; the result is the same. A table that cannot be diagnosed
    gives a `Failure` with its message. Options are those of `diagnose`; ``own_effects`` is a file.
    """
    reading, counting = parted(**options)
    files = (model, own_effects)
    wanted = CyclesWanted(counting=counting)
    each = diagnose_each(tables, files, reading, wanted, seed=seed, executor=executor)
    return Diagnoses(tuple(map(str, tables)), tuple(each))


def diagnose_each(
    tables: Sequence[str | Path],
    files: tuple[str | Path | None, str | Path | None],
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    seed: int,
    executor: Executor | None = None,
) -> Iterator[Diagnosis | Failure]:
    """Yield the diagnoses of `diagnose_many`, as they come.

    ``files`` are that of the model and that of the user's effects.
    """
    from scara_iso.fleets import open_processes

    work = partial(_diagnose_one, files=files, reading=reading, wanted=wanted, seed=seed)
    with nullcontext(executor) if executor is not None else open_processes() as pool:
        yield from pool.map(work, tables)


def _diagnose_one(
    table: str | Path,
    *,
    files: tuple[str | Path | None, str | Path | None],
    reading: TableOptions,
    wanted: CyclesWanted,
    seed: int,
) -> Diagnosis | Failure:
    model, effects = files
    try:
        own = () if effects is None else robot.read_effects(effects)
        known = None if model is None else robot.read_model(model, own)
        return close_the_loop(reading.read(table), known, wanted, seed=seed, own=own)
    except ScaraIsoError as error:
        return Failure(error.headline, error.exit_code)


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
