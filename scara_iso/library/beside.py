"""The tests of a folder beside its conditions: drift and pushes, read and analysed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scara_iso import iso9283
from scara_iso.iso9283 import Beside

if TYPE_CHECKING:
    from scara_iso.testfolder import Folder


def read_beside(folder: Folder) -> Beside:
    """Return what is recorded beside the conditions, held against the limits of each.

    Raises `DataError` for a table that is of another robot, damaged, or there twice.
    """
    from scara_iso.testfolder import drift_of, lacking, push_of, refuse_faulty

    refuse_faulty(folder, folder.beside)
    drift, pushes, test = None, {}, folder.test
    for state in folder.beside:
        if not state.is_whole or state.recording is None:
            continue
        if state.part.is_push:
            pushes[state.part.name] = push_of(state.recording, test)
        elif test.drift is not None:
            drift = iso9283.analyze(
                drift_of(state.recording, test), limits=test.drift.limits, decision=test.decision
            )
    return Beside(drift, pushes, tuple(lacking(one) for one in folder.beside if one.is_open))


def tables_beside(folder: Folder) -> Iterator[Path]:
    """Yield the tables that `read_beside` reads."""
    for state in folder.beside:
        if state.is_whole and state.recording is not None:
            yield state.recording.table


def files_of(tables: Sequence[Path]) -> Iterator[tuple[str, Path]]:
    """Yield tables and their raw files, each with what it is."""
    from scara_iso.rawfile import raw_path

    yield from ((f"table {table.name}", table) for table in tables)
    raws = [raw for raw in map(raw_path, tables) if raw.exists()]
    yield from ((f"raw file {raw.name}", raw) for raw in raws)
