"""``scara-iso diagnose`` of several unrelated tables: side by side, with a summary."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import typer

from scara_iso.base.published import to_json
from scara_iso.cli.output import settings, write_json, write_report
from scara_iso.diagnosis import CyclesWanted, published_tables
from scara_iso.library import TableOptions, diagnose_each
from scara_iso.render import open_console, track
from scara_iso.reporting import Failure, summary_report


def show_many(
    tables: Sequence[str],
    files: tuple[str | None, str | None],
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    seed: int,
    as_json: bool,
) -> None:
    """Diagnose every table, in as many processes as there are cores, and write a summary.

    ``files`` are that of the model and that of the user's effects. A table that cannot be
    diagnosed is said in its row; the exit code is then the first one's.
    """
    console = open_console(sys.stderr, no_color=settings.no_color)
    each = diagnose_each(tables, files, reading, wanted, seed=seed)
    found = list(track(each, len(tables), console))
    if as_json:
        said = [one.message if isinstance(one, Failure) else one for one in found]
        write_json(to_json(published_tables(tables, said)))
    else:
        write_report(summary_report(tables, found))
    codes = [one.exit_code for one in found if isinstance(one, Failure)]
    if codes:
        raise typer.Exit(codes[0])
