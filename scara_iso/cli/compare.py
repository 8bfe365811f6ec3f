"""``scara-iso compare``: what a repair changed."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from scara_iso import library
from scara_iso.base.errors import UsageError
from scara_iso.base.published import to_json
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AsJson,
    ConditionName,
    Full,
    parse_limits,
    takes_tables,
)
from scara_iso.cli.output import check_outputs, command_line, write_json, write_picture
from scara_iso.cli.show_comparison import show_comparison
from scara_iso.iso9283 import Conformity, Counting
from scara_iso.library import TableOptions
from scara_iso.testfolder import is_test_folder

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


@takes_tables
def compare_command(
    tables: Tables,
    *,
    plot: Plot = None,
    reading: TableOptions,
    counting: Counting,
    exchangeability: Annotated[
        bool, typer.Option("--exchangeability", help="The tables are of several robots (7.7).")
    ] = False,
    limit: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=LIMIT", help="exchangeability=0.05, in mm; decided as analyze."),
    ] = None,
    seed: Seed = 9283,
    condition: ConditionName = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Compare runs with the first: means and RP, with intervals, a test, and its power.

    Example: scara-iso compare examples/before_repair.csv examples/after_repair.csv
    """
    if tables.count("-") > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")
    check_outputs([], tables, pictures=[plot])
    read = asdict(reading) | asdict(counting)
    options: dict[str, Any] = {
        **read,
        "exchangeability": exchangeability,
        "limits": parse_limits(limit or ()),
        "seed": seed,
    }
    if any(map(is_test_folder, tables)):
        from scara_iso.cli.conditions import compare_folders

        found = compare_folders(tables, condition, plot, options, as_json=json, full=full)
    else:
        found = [library.compare(*tables, condition=condition, **options)]
        write_picture(found[0], plot)
        if json:
            from scara_iso.comparison import published_comparison

            write_json(to_json(published_comparison(found[0])))
        else:
            again = [command_line([table], read) for table in tables]
            show_comparison(found[0], again, full=full)
    held = [o.limit.verdict for one in found for o in one.characteristics if o.limit is not None]
    if any(verdict is not Conformity.PASS for verdict in held):
        raise typer.Exit(NOT_WITHIN_LIMITS)
