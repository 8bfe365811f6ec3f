"""``scara-iso diagnose`` of several tables: side by side, with a summary."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import typer

from scara_iso.cli.output import settings, write_json, write_report
from scara_iso.diagnosis import CyclesWanted, Diagnosis, close_the_loop_at_poses
from scara_iso.library import TableOptions, diagnose_each
from scara_iso.render import diagnosis_json, open_console, track
from scara_iso.reporting import Failure, summary_report
from scara_iso.run import Run


def show_many(
    tables: Sequence[str],
    model: str | None,
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    seed: int,
    as_json: bool,
) -> None:
    """Diagnose every table, in as many processes as there are cores, and write a summary.

    A table that cannot be diagnosed is said in its row; the exit code is then the first one's.
    """
    console = open_console(sys.stderr, no_color=settings.no_color)
    each = diagnose_each(tables, model, reading, wanted, seed=seed)
    found = list(track(each, len(tables), console))
    if as_json:
        write_json({"schema": "scara-iso/diagnose-many/1", "tables": _as_json(tables, found)})
    else:
        write_report(summary_report(tables, found))
    codes = [one.exit_code for one in found if isinstance(one, Failure)]
    if codes:
        raise typer.Exit(codes[0])


def diagnose_poses_of(
    run: Run,
    wanted: CyclesWanted,
    *,
    seed: int,
    as_json: bool,
    write: Callable[[Mapping[str, Any]], None] = write_json,
) -> None:
    """Write a summary of the diagnosis of each pose of a table of several."""
    found = close_the_loop_at_poses(run, wanted, seed=seed)
    names, diagnoses = [f"pose {pose}" for pose in found], list(found.values())
    if as_json:
        write({"schema": "scara-iso/diagnose-many/1", "tables": _as_json(names, diagnoses)})
    else:
        write_report(summary_report(names, diagnoses))


def _as_json(
    tables: Sequence[str], found: Sequence[Diagnosis | Failure]
) -> list[dict[str, object]]:
    return [
        {"table": table, "error": one.message}
        if isinstance(one, Failure)
        else {"table": table, **diagnosis_json(one)}
        for table, one in zip(tables, found, strict=True)
    ]
