"""`diagnose` and `diagnose_many`: what a model leaves unexplained in a table, or in several."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial
from pathlib import Path

from scara_iso import diagnosis
from scara_iso.diagnosis import SEED, CyclesWanted, Diagnosis
from scara_iso.errors import ScaraIsoError
from scara_iso.library.inputs import Table, TableOptions
from scara_iso.library.notebook import shows_itself
from scara_iso.reporting import Failure, Report
from scara_iso.robot import Model


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
) -> Diagnosis:
    """Return what a model (or its file; None: a constant pose) leaves unexplained in a table.

    ``pose`` names one of several; the other options are those of `analyze`, for both tables:
    ``hold_out`` is a second one that measures the error on unseen cycles. ``sigma`` is the known
    scatter in mm. Same arguments, same result. Raises `DataError` for a table that cannot be read,
    breaks the cycle rule, or is not of the model, and `UsageError` for a pose that is not there.
    """
    reading = TableOptions(unit, resolution, decimal, sheet)
    return diagnosis.diagnose(
        reading.read(table),
        model,
        pose=pose,
        first_cycle_discarded=first_cycle_discarded,
        cycles=cycles,
        all_count=all_count,
        allow_gaps=allow_gaps,
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
) -> tuple[Diagnosis | Failure, ...]:
    """Return the diagnosis of each of several unrelated tables, in their order.

    They are shared among as many processes as there are cores. A table that cannot be diagnosed
    gives a `Failure` with its message. Options are those of `diagnose`.
    """
    reading = TableOptions(unit, resolution, decimal, sheet)
    wanted = CyclesWanted(None, first_cycle_discarded, cycles, all_count, allow_gaps)
    return tuple(diagnose_each(tables, model, reading, wanted, seed=seed))


def diagnose_each(
    tables: Sequence[str | Path],
    model: str | Path | None,
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    seed: int,
) -> Iterator[Diagnosis | Failure]:
    """Yield what `diagnose_many` returns, as it comes."""
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
        return diagnosis.diagnose(reading.read(table), model, **asdict(wanted), seed=seed)
    except ScaraIsoError as error:
        return Failure(error.headline, error.exit_code)


def _page(found: Diagnosis) -> Report:
    from scara_iso.reporting import diagnosis_report

    return diagnosis_report(found, "")


shows_itself(Diagnosis, _page, "Diagnosis")
