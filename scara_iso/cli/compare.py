"""``scara-iso compare``: what a repair changed."""

from __future__ import annotations

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
from scara_iso.cli.output import check_outputs, named, write_json, write_report
from scara_iso.errors import UsageError

if TYPE_CHECKING:
    from scara_iso.comparison import Comparison

Tables = Annotated[
    list[str],
    typer.Argument(
        metavar="BEFORE AFTER [MORE]...",
        help="Tables of readings (a folder or workbook: of several poses), the first against "
        "each other one; - is standard input.",
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
    from scara_iso.library import compare

    if tables.count("-") > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")
    check_outputs([plot], named(tables))
    comparison = compare(
        *tables,
        unit=unit,
        resolution=resolution,
        decimal=decimal,
        sheet=sheet,
        first_cycle_discarded=first_cycle_discarded,
        cycles=cycles,
        all_count=all_count,
        allow_gaps=allow_gaps,
        seed=seed,
    )
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
