"""``scara-iso history``: one robot over months."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from scara_iso import library, reporting
from scara_iso.base.published import to_json
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AsJson,
    Full,
    Limits,
    parse_limits,
    takes_tables,
)
from scara_iso.cli.output import (
    check_outputs,
    command_line,
    say_written,
    write_json,
    write_report,
)
from scara_iso.iso9283 import Counting
from scara_iso.library import TableOptions

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
        "-o",
        "--output",
        metavar="FILE",
        help="The page of the robot, by its ending: .html .md .csv .xlsx .pdf.",
    ),
]


@takes_tables
def history_command(
    tables: TablesOfTests,
    *,
    events: Events = None,
    robot: Robot = None,
    limit: Limits = None,
    output: Page = None,
    reading: TableOptions,
    counting: Counting,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Follow one robot over months: control charts, trend, when it meets a limit, services.

    Exits with 1 where a limit that was given is crossed since the last service.

    Example: scara-iso history examples/months --limit XY=0.03 -o robot.html
    """
    check_outputs([output], [*tables, None if events is None else str(events)])
    if output is not None:
        library.check_page(output)
    read = asdict(reading) | asdict(counting)
    limits = parse_limits(limit or ())
    found = library.history(tables, events=events, robot=robot, limits=limits, **read)
    for name, why in found.unreadable:
        typer.echo(reporting.printable(f"scara-iso: left out: {name}: {why}"), err=True)
    if output is not None:
        library.write_page(reporting.history_document(found), output)
    if json:
        from scara_iso.comparison import published_history

        write_json(to_json(published_history(found)))
    else:
        last = command_line([found.tests[-1].source], read)
        following = reporting.NextStep(f"scara-iso diagnose {last}", "what is in the last test")
        write_report(
            reporting.history_report(found) if full else reporting.history_brief(found, following)
        )
    say_written(output, aside=json)
    if found.crossed:
        raise typer.Exit(NOT_WITHIN_LIMITS)
