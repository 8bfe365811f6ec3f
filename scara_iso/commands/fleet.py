"""`fleet`: the tables of many robots, on this machine or a cluster."""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Unpack

from scara_iso import fleets
from scara_iso.base.errors import StoppedError, UsageError
from scara_iso.base.files import check_folder
from scara_iso.base.quantities import parse_unit
from scara_iso.commands.shared import output as out
from scara_iso.commands.shared.inputs import DialOptions, refuse_unknown
from scara_iso.commands.shared.options import Asked, argument, option, output_file, takes_options_of
from scara_iso.diagnosis import SEED, CyclesWanted
from scara_iso.iso9283 import Counting, CountingOptions
from scara_iso.reporting import Document, Report, fleet_figures_report, fleet_report

LEVEL = 0.05


class FleetOptions(DialOptions, CountingOptions, total=False):
    """How the tables of a fleet are read, and which of their cycles count."""


def fleet(
    source: str | Path,
    to: str | Path,
    *,
    engine: str = fleets.LOCAL,
    workers: int | None = None,
    level: float = LEVEL,
    seed: int = SEED,
    track: fleets.Track = lambda each, _: each,
    **options: Unpack[FleetOptions],
) -> fleets.FleetSummary:
    """Return which of many robots stand out, and leave a Parquet file for each part in ``to``.

    ``source`` is a folder of parts: .parquet or .csv with the columns robot, X, Y, Z or theta and
    as they are there test, pose, cycle and others, or .csv of one robot each. ``engine`` is
    ``local`` (as many processes as ``workers``, else as there are cores) or ``dask://HOST:PORT``;
    the result is the same. A part that is done is not done again: the same call goes on where one
    that died stopped. What cannot be read is listed. ``level`` is the false discovery rate among
    the robots that are named. The other options are those of `diagnose`, for every table; ``track``
    may watch the results come. Raises `NoInputError` without parts, `DataError` where ``to`` is of
    another version or other options, `UsageError`, `ServiceError` for a cluster that is not there.
    """
    if not 0 < level < 1:
        raise UsageError(f"`level={level:g}`: not between 0 and 1", remedy="`level=0.05`")
    task = fleets.Task(*_checked(fleet, to, options), seed)
    with fleets.engine_of(engine, workers) as where:
        run = fleets.run_fleet(Path(source), Path(to), task, where, level=level, track=track)
    return fleets.summarise(run, level)


def fleet_figures(
    source: str | Path,
    to: str | Path,
    *,
    engine: str = fleets.LOCAL,
    workers: int | None = None,
    track: fleets.Track = lambda each, _: each,
    **options: Unpack[FleetOptions],
) -> fleets.FleetFigures:
    """Return RP of many robots, and leave that of every pose in ``to``, without a diagnosis.

    DuckDB adds the tables of Parquet files up, in as many threads as ``workers``; the figures are
    those of `analyze`. The other options, and what is raised, as of `fleet`.
    """
    threads = (workers or fleets.cores()) if engine == fleets.LOCAL else 1
    task = fleets.Task(*_checked(fleet_figures, to, options), threads=threads)
    with fleets.engine_of(engine, workers, in_process=True) as where:
        run = fleets.run_figures(Path(source), Path(to), task, where, track=track)
    return fleets.summarise_figures(run)


def _checked(
    function: Callable[..., Any], to: str | Path, options: FleetOptions
) -> tuple[fleets.ReadAs, CyclesWanted]:
    """Return how tables are read and which cycles count, once all of it is known to make sense."""
    refuse_unknown(function, options)
    check_folder(Path(to))
    given: dict[str, Any] = dict(options)
    read = fleets.ReadAs(**{name: given.pop(name, None) for name in DialOptions.__annotations__})
    if read.unit is not None:
        parse_unit(read.unit)
    if read.decimal not in (None, ",", "."):
        raise UsageError(f"`decimal={read.decimal}`: not a decimal mark", remedy="use , or .")
    return read, CyclesWanted(counting=Counting(**given))


UNREADABLE = 65
_KEPT = "the parts that are done are kept; the same command goes on where it stopped"


@takes_options_of(
    fleet,
    "full",
    "json",
    source=argument(
        "Folder of .parquet or .csv files with the columns robot, test, pose, cycle, X, Y, ..; "
        "or with a table for each robot.",
        "SOURCE",
        str,
    ),
    to=output_file("Folder of the results.", Path, metavar="DIR"),
    engine=option("Engine: local, or dask://HOST:PORT of a scheduler.", metavar="WHERE"),
    workers=option("Number of processes of the local engine [one a core].", metavar="N", min=1),
    level=option("False discovery rate among the robots named."),
    figures=option("Compute RP only, by DuckDB; nothing is diagnosed."),
    page=option("Page of the results: .html .csv .xlsx."),
)
def fleet_command(
    asked: Asked[fleets.FleetSummary],
    *,
    figures: bool = False,
    page: Path | None = None,
) -> out.Answer:
    """Diagnose many robots, and find which stand out, corrected for their number.

    Example: scara-iso fleet tables -o results --engine local

    After an interruption the same command continues.
    """
    out.check_outputs([], [], pages=[page])

    if not out.settings.debug:
        logging.disable()  # of Dask: what a person should know is said here
    report: Callable[[], Report]
    try:
        if figures:
            made = fleet_figures(**asked.options("level"), track=out.with_progress)
            run, failed, report = made.run, made.failed, partial(fleet_figures_report, made)
        else:
            found = asked.result(track=out.with_progress)
            run, failed, report = found.run, found.failed, partial(fleet_report, found)
    except KeyboardInterrupt as error:
        raise StoppedError("interrupted", remedy=_KEPT) from error
    if page is not None:
        out.write_page(Document("Fleet", report()), page)
    code = UNREADABLE if failed or run.failed else 0
    return out.Answer(made if figures else found, report, page, code=code)
