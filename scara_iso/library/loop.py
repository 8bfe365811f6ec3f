"""`diagnose` and `diagnose_many`: what a model leaves unexplained in a table, or in several."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from scara_iso.diagnosis import (
    SEED,
    CyclesWanted,
    Diagnosis,
    close_the_loop,
    close_the_loop_at_poses,
)
from scara_iso.errors import ScaraIsoError
from scara_iso.library.diagnoses import Diagnoses
from scara_iso.library.inputs import Table, TableOptions
from scara_iso.library.models import described
from scara_iso.reporting import Failure
from scara_iso.robot import Model, read_model


def diagnose(
    table: Table,
    model: Model | str | Path | None = None,
    *,
    pose: str | None = None,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    sheet: str | None = None,
    first_cycle_discarded: bool = False,
    cycles: int | None = None,
    all_count: bool = False,
    allow_gaps: bool = False,
    hold_out: Table | None = None,
    sigma: float | None = None,
    seed: int = SEED,
) -> Diagnosis | Diagnoses:
    """Return what a model (or its file; None: a constant pose) leaves unexplained in a table.

    A table of several poses gives the diagnosis of each by name, each against a constant, unless
    ``pose`` names one; ``model``, ``hold_out`` (a second table, for the error on unseen cycles) and
    ``sigma`` (the known scatter in mm) are for one pose. The other options are those of `analyze`,
    for both tables. Same arguments, same result. Raises `DataError` for a table that cannot be
    read, breaks the cycle rule, or is not of the model, and `UsageError` for a pose that is not
    there.
    """
    reading = TableOptions(unit, resolution, decimal, sheet)
    wanted = CyclesWanted(pose, first_cycle_discarded, cycles, all_count, allow_gaps)
    run = reading.read(table)
    for_one_pose = (pose, model, hold_out, sigma)
    if all(one is None for one in for_one_pose) and len(list(run.rows_by_pose())) > 1:
        poses = close_the_loop_at_poses(run, wanted, seed=seed)
        return Diagnoses(tuple(poses), tuple(poses.values()))
    return close_the_loop(
        run,
        None if model is None else described(model),
        wanted,
        hold_out=None if hold_out is None else reading.read(hold_out),
        sigma=sigma,
        seed=seed,
    )


def diagnose_many(
    tables: Sequence[str | Path],
    model: str | Path | None = None,
    *,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    sheet: str | None = None,
    first_cycle_discarded: bool = False,
    cycles: int | None = None,
    all_count: bool = False,
    allow_gaps: bool = False,
    seed: int = SEED,
) -> Diagnoses:
    """Return the diagnosis of each of several unrelated tables, by number or by file name.

    They are shared among as many processes as there are cores. A table that cannot be diagnosed
    gives a `Failure` with its message. Options are those of `diagnose`.
    """
    reading = TableOptions(unit, resolution, decimal, sheet)
    wanted = CyclesWanted(None, first_cycle_discarded, cycles, all_count, allow_gaps)
    each = diagnose_each(tables, model, reading, wanted, seed=seed)
    return Diagnoses(tuple(map(str, tables)), tuple(each))


def diagnose_each(
    tables: Sequence[str | Path],
    model: str | Path | None,
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    seed: int,
) -> Iterator[Diagnosis | Failure]:
    """Yield the diagnoses of `diagnose_many`, as they come."""
    work = partial(_diagnose_one, model=model, reading=reading, wanted=wanted, seed=seed)
    with ProcessPoolExecutor() as pool:
        yield from pool.map(work, tables)


def _diagnose_one(
    table: str | Path,
    *,
    model: str | Path | None,
    reading: TableOptions,
    wanted: CyclesWanted,
    seed: int,
) -> Diagnosis | Failure:
    try:
        run, known = reading.read(table), None if model is None else read_model(model)
        return close_the_loop(run, known, wanted, seed=seed)
    except ScaraIsoError as error:
        return Failure(error.headline, error.exit_code)
