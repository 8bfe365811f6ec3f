"""``scara-iso visits``: a fast sensor's stream to a table of visits."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.cli.options import (
    AsJson,
    ExcelLocale,
    Full,
    takes_tables,
)
from scara_iso.cli.output import check_outputs, command_line, write_json, write_report, write_text
from scara_iso.library import TableOptions

if TYPE_CHECKING:
    from scara_iso.run import Run

Stream = Annotated[
    str,
    typer.Argument(
        metavar="STREAM", help="Table with time_s and one to four axes, or NAME.raw.jsonl."
    ),
]
Dwell = Annotated[float, typer.Option(help="Shortest rest that is a visit [s].")]
Still = Annotated[
    float | None,
    typer.Option(help="Largest range at rest, within a window [mm]; else found from the stream."),
]
Band = Annotated[
    float | None,
    typer.Option(help="Half width of the limit band [mm]; else five times the scatter at rest."),
]
Poses = Annotated[
    str | None,
    typer.Option(metavar="P1,P2,..", help="Poses in the order of the rests; - is no pose."),
]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", help="The visits as a table of readings.")
]


@takes_tables
def visits_command(
    stream: Stream,
    *,
    dwell: Dwell = 1.0,
    still: Still = None,
    band: Band = None,
    poses: Poses = None,
    reading: TableOptions,
    output: Output = None,
    excel_locale: ExcelLocale = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Turn a stream of 50 to 500 samples a second into one reading for each visit.

    Example: scara-iso visits examples/stream.csv --poses P1,- -o run.csv
    """
    from scara_iso.library import visits
    from scara_iso.tables import find_locale, write_table

    check_outputs([output], [stream])
    found = visits(
        stream,
        dwell=dwell,
        still=still,
        band=band,
        poses=poses or (),
        **asdict(reading),
    )
    if output is not None:
        write_text(write_table(found.run, find_locale(excel_locale)), output)
    if json:
        from scara_iso.base.published import to_json
        from scara_iso.iso9283 import published_visits

        write_json(to_json(published_visits(found)))
    else:
        from scara_iso.reporting import NextStep, visits_brief, visits_report

        given = {
            "dwell": dwell if dwell != 1 else None,
            "still": still,
            "band": band,
            "poses": poses,
            **asdict(reading),
        }
        following = (
            NextStep(f"scara-iso visits {command_line([stream], given)} -o run.csv", "the table")
            if output is None
            else NextStep(f"scara-iso analyze {command_line([str(output)], _counted(found.run))}")
        )
        write_report(visits_report(found) if full else visits_brief(found, following))


def _counted(run: Run) -> dict[str, object]:
    """Return the options by which every visit counts, of which a table has seldom 30."""
    visits = [len(rows) for _, rows in run.rows_by_pose()]
    alike = len(set(visits)) == 1
    return {"all_count": True, "cycles": max(visits), "allow_gaps": not alike}
