"""`visits`: a fast sensor's stream to a table of visits."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Unpack

import typer

from scara_iso import reporting, tables
from scara_iso.commands.inputs import ReadingOptions, Table, TableOptions
from scara_iso.commands.options import AsJson, ExcelLocale, Full, takes_tables
from scara_iso.commands.output import (
    check_outputs,
    command_line,
    write_report,
    write_result,
    write_text,
)
from scara_iso.iso9283 import StreamVisits, with_arrivals
from scara_iso.run import Run
from scara_iso.signals import Wanted, find_visits
from scara_iso.tables import read_bytes

_RECORDING = ".raw.jsonl"


def visits(
    stream: Table,
    *,
    dwell: float = 1.0,
    still: float | None = None,
    band: float | None = None,
    poses: str | Sequence[str] = (),
    **reading: Unpack[ReadingOptions],
) -> StreamVisits:
    """Return the visits of a stream: a row for each sample, time_s and the axes as columns.

    ``stream`` is a table, or the raw file of a recording (NAME.raw.jsonl). ``dwell`` is the
    shortest rest that is a visit [s]; ``still`` the largest range of the readings within a window
    at rest and ``band`` the half width of the limit band (7.4), both in mm (degrees where there are
    angles only); without them both are found from the stream. ``poses`` names the rests in turn,
    ``-`` one that is no pose: ``"P1,-"``, or a sequence. ``reading`` is as in `read_table`.
    Raises `DataError` for what cannot be read or told apart.
    """
    order = poses.split(",") if poses and isinstance(poses, str) else list(poses)
    wanted = Wanted(dwell, still, band, tuple(name.strip() for name in order))
    run, digest = _read(stream, TableOptions(**reading))
    found = with_arrivals(find_visits(run, wanted))
    source = {} if digest is None else {"stream_sha256": digest}
    named = {"stream": Path(run.origin.source).name} if run.origin.source else {}
    return replace(
        found, run=replace(found.run, metadata={**named, **source, **found.run.metadata})
    )


def _read(stream: Table, options: TableOptions) -> tuple[Run, str | None]:
    """Return the run of the samples and the SHA-256 of the bytes that it was read from."""
    if isinstance(stream, str | Path) and str(stream).endswith(_RECORDING):
        from scara_iso.rawfile import read_history

        run = read_history(Path(stream)).run()
        return run, hashlib.sha256(read_bytes(stream)[0]).hexdigest()
    if isinstance(stream, str | Path) and str(stream) != "-":
        digest = hashlib.sha256(read_bytes(stream)[0]).hexdigest()
        return options.read(stream), digest
    if isinstance(stream, bytes) or (isinstance(stream, str) and stream == "-"):
        data, _ = read_bytes(stream)
        return options.read(data), hashlib.sha256(data).hexdigest()
    return options.read(stream), None


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
        write_text(tables.write_table(found.run, tables.find_locale(excel_locale)), output)
    if json:
        write_result(found)
    else:
        given = {
            "dwell": dwell if dwell != 1 else None,
            "still": still,
            "band": band,
            "poses": poses,
            **asdict(reading),
        }
        again = f"scara-iso visits {command_line([stream], given)} -o run.csv"
        following = reporting.NextStep(again, "the table")
        if output is not None:
            counted = command_line([str(output)], _counted(found.run))
            following = reporting.NextStep(f"scara-iso analyze {counted}")
        write_report(reporting.visits_report(found, following), full=full)


def _counted(run: Run) -> dict[str, object]:
    """Return the options by which every visit counts, of which a table has seldom 30."""
    visits = [len(rows) for _, rows in run.rows_by_pose()]
    alike = len(set(visits)) == 1
    return {"all_count": True, "cycles": max(visits), "allow_gaps": not alike}
