"""``scara-iso compare``: what a repair changed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.cli.options import (
    AllCount,
    AllowGaps,
    AsJson,
    CyclesRun,
    DecimalMark,
    FirstDiscarded,
    ResolutionOfTable,
    Sheet,
    UnitOfTable,
)
from scara_iso.cli.output import check_outputs, write_json, write_report
from scara_iso.errors import DataError, Fault, NoInputError, ScaraIsoError, UsageError

if TYPE_CHECKING:
    from scara_iso.comparison import Comparison
    from scara_iso.iso9283 import Analysis

Tables = Annotated[
    list[str],
    typer.Argument(
        metavar="BEFORE AFTER [MORE]...",
        help="Tables of readings, the first against each other one; - is standard input.",
    ),
]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="The picture, as .svg or .png.")]
Seed = Annotated[int, typer.Option(help="Seed of the permutations.", min=0)]


def compare_command(
    tables: Tables,
    *,
    plot: Plot = None,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    sheet: Sheet = None,
    first_cycle_discarded: FirstDiscarded = False,
    cycles: CyclesRun = None,
    all_count: AllCount = False,
    allow_gaps: AllowGaps = False,
    seed: Seed = 9283,
    json: AsJson = False,
) -> None:
    """Compare runs with the first: means and RP, with intervals, a test, and its power.

    Example: scara-iso compare examples/before_repair.csv examples/after_repair.csv
    """
    from scara_iso import analyze, read_table
    from scara_iso.comparison import compare

    if tables.count("-") > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")

    check_outputs([plot], tables)

    def read(table: str) -> Analysis:
        run = read_table(table, unit=unit, resolution=resolution, decimal=decimal, sheet=sheet)
        return analyze(
            run,
            first_cycle_discarded=first_cycle_discarded,
            cycles=cycles,
            all_count=all_count,
            allow_gaps=allow_gaps,
        )

    found = _every(tables, read)
    comparison = compare(found, seed=seed)
    if plot is not None:
        from scara_iso.render import plot_comparison

        plot_comparison(comparison, plot)
    _write(comparison, as_json=json)


def _write(comparison: Comparison, *, as_json: bool) -> None:
    if as_json:
        from scara_iso.render import comparison_json

        write_json(comparison_json(comparison))
    else:
        from scara_iso.reporting import comparison_report

        write_report(comparison_report(comparison))


def _every(tables: Sequence[str], read: Callable[[str], Analysis]) -> list[Analysis]:
    """Return the analysis of every table, or one error with the faults of all."""
    found, errors = [], []
    for table in tables:
        try:
            found.append(read(table))
        except ScaraIsoError as error:
            errors.append(error)
    if errors:
        raise errors[0] if len(errors) == 1 else _together(errors, len(tables))
    return found


def _together(errors: Sequence[ScaraIsoError], tables: int) -> ScaraIsoError:
    what = f"{len(errors)} of {tables} tables cannot be compared"
    remedies = dict.fromkeys(error.remedy for error in errors if error.remedy)
    if all(isinstance(error, NoInputError) for error in errors):
        said = "; ".join(error.headline for error in errors)
        return NoInputError(f"{what}: {said}", remedy="; ".join(remedies))
    faults = [fault for error in errors for fault in _faults(error)]
    return DataError(what, remedy="; ".join(remedies), faults=faults)


def _faults(error: ScaraIsoError) -> list[Fault]:
    of_it = error.faults if isinstance(error, DataError) else ()
    below = (Fault(f"{error.where}: {fault}") for fault in of_it if fault.message != error.what)
    return [Fault(error.headline), *below]
