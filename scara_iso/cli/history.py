"""``scara-iso history``: one robot over months."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from scara_iso import library, render, reporting
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AllCount,
    AllowGaps,
    AsJson,
    CyclesRun,
    DecimalMark,
    FirstDiscarded,
    Full,
    Limits,
    ResolutionOfTable,
    UnitOfTable,
    parse_limits,
)
from scara_iso.cli.output import check_outputs, command_line, named, write_json, write_report

TablesOfTests = Annotated[
    list[str],
    typer.Argument(metavar="DIR|TABLE...", help="Tables, one a test, or the folder of them."),
]
Events = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Services: date,what. Else events.csv of the folder."),
]
Robot = Annotated[
    str | None, typer.Option(metavar="NAME", help="Only the tests of this robot or serial number.")
]
Page = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="FILE", help="The page of the robot, by its ending: .html .md "
        ".csv .xlsx .pdf.",
    ),
]  # fmt: skip


def history_command(
    tables: TablesOfTests,
    *,
    events: Events = None,
    robot: Robot = None,
    limit: Limits = None,
    output: Page = None,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    first_cycle_discarded: FirstDiscarded = False,
    cycles: CyclesRun = None,
    all_count: AllCount = False,
    allow_gaps: AllowGaps = False,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Follow one robot over months: control charts, trend, when it meets a limit, services.

    Exits with 1 where a limit that was given is crossed since the last service.

    Example: scara-iso history examples/months --limit XY=0.03 -o robot.html
    """
    check_outputs([output], [*named(tables), None if events is None else str(events)])
    if output is not None:
        library.check_page(output)
    found = library.history(
        tables, events=events, robot=robot, limits=parse_limits(limit or ()), unit=unit,
        resolution=resolution, decimal=decimal, first_cycle_discarded=first_cycle_discarded,
        cycles=cycles, all_count=all_count, allow_gaps=allow_gaps,
    )  # fmt: skip
    for name, why in found.unreadable:
        typer.echo(reporting.printable(f"scara-iso: left out: {name}: {why}"), err=True)
    if output is not None:
        library.write_page(reporting.history_document(found), output)
    if json:
        write_json(render.history_json(found))
    else:
        given = {"unit": unit, "resolution": resolution, "decimal": decimal, "cycles": cycles,
                 "first_cycle_discarded": first_cycle_discarded, "all_count": all_count,
                 "allow_gaps": allow_gaps}  # fmt: skip
        last = command_line([found.tests[-1].source], given)
        following = reporting.NextStep(f"scara-iso diagnose {last}", "what is in the last test")
        write_report(
            reporting.history_report(found) if full else reporting.history_brief(found, following)
        )
    if output is not None:
        typer.echo(reporting.printable(f"{output} is written"), err=json)
    if found.crossed:
        raise typer.Exit(NOT_WITHIN_LIMITS)
