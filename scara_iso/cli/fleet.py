"""``scara-iso fleet``: the tables of many robots, on this machine or a cluster."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scara_iso.base.errors import StoppedError
from scara_iso.base.published import to_json
from scara_iso.cli.options import (
    AsJson,
    DecimalMark,
    Full,
    ResolutionOfTable,
    UnitOfTable,
    takes_tables,
)
from scara_iso.cli.output import settings, write_json, write_report
from scara_iso.iso9283 import Counting

if TYPE_CHECKING:
    from scara_iso.fleets import FleetFigures, FleetSummary

UNREADABLE = 65
_KEPT = "the parts that are done are kept; the same command goes on where it stopped"
Source = Annotated[
    str,
    typer.Argument(
        metavar="SOURCE",
        help="Folder of .parquet or .csv with the columns robot, test, pose, cycle, X, Y, ..; or "
        "of a table for each robot.",
    ),
]
Output = Annotated[
    Path,
    typer.Option("-o", "--output", metavar="DIR", help="Folder of the results; it is gone on."),
]
EngineName = Annotated[
    str,
    typer.Option("--engine", metavar="WHERE", help="local, or dask://HOST:PORT of a scheduler."),
]
Workers = Annotated[
    int | None, typer.Option(metavar="N", help="Processes of local; else the cores.", min=1)
]
Figures = Annotated[
    bool, typer.Option("--figures", help="RP only, added up by DuckDB: nothing is diagnosed.")
]
Level = Annotated[float, typer.Option(help="False discovery rate among the robots named.")]


@takes_tables
def fleet_command(
    source: Source,
    output: Output,
    *,
    engine: EngineName = "local",
    workers: Workers = None,
    level: Level = 0.05,
    figures: Figures = False,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    counting: Counting,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Diagnose the tables of many robots; say which stand out though all were looked at.

    Example: scara-iso fleet tables -o results --engine local

    The same command again goes on where one that died stopped.
    """
    from scara_iso.library import fleet, fleet_figures
    from scara_iso.render import open_console, track

    def watched(each: Iterator[Any], count: int) -> Iterator[Any]:
        return iter(track(each, count, open_console(sys.stderr, no_color=settings.no_color)))

    if not settings.debug:
        logging.disable()  # of Dask: what a person should know is said here
    options: dict[str, Any] = {
        "engine": engine,
        "workers": workers,
        "unit": unit,
        "resolution": resolution,
        "decimal": decimal,
        "track": watched,
        **asdict(counting),
    }
    found: FleetSummary | FleetFigures
    try:
        if figures:
            found = fleet_figures(source, output, **options)
        else:
            found = fleet(source, output, level=level, **options)
    except KeyboardInterrupt as error:
        raise StoppedError("interrupted", remedy=_KEPT) from error
    _say(found, full=full, json=json)
    if found.failed or found.run.failed:
        raise typer.Exit(UNREADABLE)


def _say(found: FleetSummary | FleetFigures, *, full: bool, json: bool) -> None:
    from scara_iso.fleets import FleetFigures, published_fleet, published_fleet_figures
    from scara_iso.reporting import fleet_figures_report, fleet_report

    if isinstance(found, FleetFigures):
        if json:
            write_json(to_json(published_fleet_figures(found)))
        else:
            write_report(fleet_figures_report(found, full=full))
    elif json:
        write_json(to_json(published_fleet(found)))
    else:
        write_report(fleet_report(found, full=full))
