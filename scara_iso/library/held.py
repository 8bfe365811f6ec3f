"""The files that a report is made of, each with the very bytes that were read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import TypeAlias

from scara_iso.library.inputs import Table, TableOptions, Tables, every, tables_of, together_as
from scara_iso.reporting import InputFile
from scara_iso.run import Run, is_frame
from scara_iso.tables import read_bytes, write_table

Held: TypeAlias = tuple[InputFile, bytes]
"""A file that a report is made of, and the very bytes of it."""


def hold(role: str, path: Path) -> Held:
    """Return a file with its bytes."""
    return _held(role, str(path), path.read_bytes())


def named(held: Sequence[Held]) -> dict[str, bytes]:
    """Return the bytes by file name; of two files with one name the second is numbered."""
    found: dict[str, bytes] = {}
    for k, (file, data) in enumerate(held, 1):
        name = Path(file.name).name or "table"
        found[f"{k}-{name}" if name in found else name] = data
    return found


def read_held(tables: Tables, reading: TableOptions) -> tuple[Run, tuple[Held, ...]]:
    """Return the run of tables, and the very bytes that it was read from."""
    found = tables_of(tables)
    known = every(found, partial(_hold, reading=reading), f"of {len(found)} tables")
    run = reading.read([table for table, _ in known])
    if len(found) > 1 and (source := together_as(tables)):
        run = replace(run, origin=replace(run.origin, source=source))
    return run, tuple(held for _, held in known)


def _hold(table: Table, reading: TableOptions) -> tuple[Table, Held]:
    """Return a table whose bytes cannot change any more, and those."""
    if isinstance(table, Run) or is_frame(table):
        run = reading.read(table)
        data = write_table(run).encode()
        return table, _held("run, as write_table gives it", run.origin.source, data)
    data, name = read_bytes(table)
    file = BytesIO(data)
    setattr(file, "name", name)  # noqa: B010 - where errors and the report say it is from
    return file, _held("table", name, data)


def _held(role: str, name: str, data: bytes) -> Held:
    return InputFile(role, name, sha256(data).hexdigest()), data
