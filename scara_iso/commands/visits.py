"""`visits`: a fast sensor's stream to a table of visits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Unpack

from scara_iso import rawfile, reporting, signals, tables
from scara_iso.commands.shared import options as opt
from scara_iso.commands.shared.inputs import (
    Reading,
    ReadingOptions,
    Table,
    read_series,
    refuse_unknown,
)
from scara_iso.commands.shared.output import Answer, check_outputs, write_text
from scara_iso.iso9283 import CYCLES_RUN, StreamVisits, with_arrivals
from scara_iso.run import Run

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
    angles only); without them both are found from the stream. ``poses`` names the rests in the
    order of arrival, ``-`` one that is no pose: ``"P1,-"``, or a sequence. ``reading`` is as in
    `read_table`.
    Raises `DataError` for what cannot be read or told apart.
    """
    refuse_unknown(visits, reading)
    order = poses.split(",") if poses and isinstance(poses, str) else list(poses)
    wanted = signals.Wanted(dwell, still, band, tuple(name.strip() for name in order))
    run, source = _read(stream, reading)
    found = with_arrivals(signals.find_visits(run, wanted))
    return replace(found, run=replace(found.run, metadata={**source, **found.run.metadata}))


def _read(stream: Table, reading: Reading) -> tuple[Run, dict[str, str]]:
    """Return the run of the samples, and name and SHA-256 of what it was read from."""
    if isinstance(stream, str | Path) and str(stream).endswith(_RECORDING):
        run, data = rawfile.read_history(Path(stream)).run(), tables.read_bytes(stream)[0]
    else:
        found = read_series(stream, reading)
        (kept,) = found.read
        run, data = found.readings, b"" if isinstance(kept, Run) else kept.getvalue()
    source = {"stream": Path(run.origin.source).name} if run.origin.source else {}
    return run, source | ({"stream_sha256": sha256(data).hexdigest()} if data else {})


@opt.takes_options_of(
    visits,
    "full",
    "json",
    stream=opt.argument(
        "Table with time_s and one to four axes, or NAME.raw.jsonl.", "STREAM", str
    ),
    dwell=opt.option("Shortest rest that is a visit [s]."),
    still=opt.option("Largest range at rest within a window [mm; found from the stream]."),
    band=opt.option("Half width of the limit band [mm; five times the scatter at rest]."),
    poses=opt.option("Poses in the order of arrival; - skips a rest.", metavar="P1,P2,.."),
    output=opt.output_file("Table of readings to write."),
)
def visits_command(
    asked: opt.Asked[StreamVisits],
    *,
    output: Path | None = None,
    excel_locale: opt.ExcelName | None = None,
) -> Answer:
    """Turn a stream of 50 to 500 samples a second into one reading for each visit.

    Example: scara-iso visits examples/stream.csv --poses P1,- -o run.csv
    """
    check_outputs([], [asked["stream"]], tables=[output])
    found = asked.result()
    if output is not None:
        write_text(tables.write_table(found.run, tables.find_locale(excel_locale)), output)
        visits = [len(rows) for _, rows in found.run.rows_by_pose()]
        of_procedure = min(visits) == CYCLES_RUN
        whole = {} if of_procedure else {"all_count": True, "cycles": min(visits)}
        lacking = "once the rows of the last turn, which is not whole, are removed"
        following = reporting.NextStep(
            f"scara-iso analyze {opt.command_line([str(output)], whole)}",
            lacking if len(set(visits)) > 1 else "",
        )
    else:
        following = reporting.NextStep(f"scara-iso visits {asked.line()} -o run.csv", "the table")
    return Answer(found, partial(reporting.visits_report, found, following))
