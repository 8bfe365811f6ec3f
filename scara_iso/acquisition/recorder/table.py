"""The table of a raw file, and its manifest: made of what that file holds and of nothing else."""

from __future__ import annotations

from pathlib import Path

from scara_iso.acquisition.manifest import find_doubts, manifest_of, manifest_path, raw_path
from scara_iso.acquisition.recorder.history import History, read_history
from scara_iso.disk import Disk, check_output, write_atomically
from scara_iso.errors import CannotCreateError, UsageError, WriteError

_RAW = ".raw.jsonl"


def table_of(history: History, excel_locale: str | None = None) -> bytes:
    """Return the table, spelled as the recording says where ``excel_locale`` is None.

    Raises `DataError` where no cycle is complete.
    """
    from scara_iso.tables import find_locale, write_table  # noqa: PLC0415 - only once, at the end

    run = history.run()
    locale = find_locale(excel_locale or history.header.get("excel_locale"))
    # A file name or option need not be valid text; the readings must not be lost for that.
    return write_table(run, locale).encode("utf-8", "backslashreplace")


def write_table_of(
    history: History, table: Path, data: bytes, *, disk: Disk, beside: bool = True
) -> None:
    """Write a table and, where its raw file is ``beside`` it, their manifest.

    What a crash between the two leaves must not look as if someone had changed it: a new table
    comes after its manifest, one that is replaced before.
    """
    files, manifest = {table: data}, manifest_path(table)
    try:
        if beside:
            made = manifest_of(table, data, complete=history.is_complete, doubts=history.doubts)
            both = [(table, data), (manifest, made)]
            files = dict(both if manifest.exists() else reversed(both))
        write_atomically(disk, files)
    except OSError as error:
        raise _cannot_write(table, error) from error


def remove(path: Path, disk: Disk) -> None:
    """Remove a file of a recording if it is there."""
    try:
        disk.remove(path)
        disk.sync_folder(path.parent)
    except OSError as error:
        raise _cannot_write(path, error) from error


def rebuild(
    raw: Path, table: Path | None, *, disk: Disk, excel_locale: str | None = None
) -> tuple[Path, History]:
    """Write the table that a raw file holds, by default beside it; return both.

    Raises `NoInputError`, `DataError`, or `CannotCreateError` where another table is there.
    """
    if table is None:
        if not raw.name.endswith(_RAW):
            raise UsageError(f"{raw.name} is not called NAME{_RAW}", remedy="name OUT.csv too")
        table = _table_beside(raw)
    check_output(table)
    history = read_history(raw)
    found, plain = doubts_beside(raw, history), table_of(history, excel_locale)
    history.inherit(found)
    data = table_of(history, excel_locale)
    if table.exists() and table.read_bytes() not in (plain, data):
        raise CannotCreateError(
            "exists already, with other contents", where=str(table), remedy="name another OUT.csv"
        )
    beside = raw_path(table).resolve() == raw.resolve()
    write_table_of(history, table, data, disk=disk, beside=beside)
    return table, history


def doubts_beside(raw: Path, history: History) -> tuple[str, ...]:
    """Return what the manifest beside a raw file says against it, where there should be one."""
    table = _table_beside(raw)
    if not (history.has_table or manifest_path(table).exists() or table.exists()):
        return ()
    return find_doubts(table).recording


def _table_beside(raw: Path) -> Path:
    return raw.with_name(f"{raw.name.removesuffix(_RAW)}.csv")


def _cannot_write(path: Path, error: OSError) -> WriteError:
    return WriteError(
        f"cannot be written ({error.strerror or error})",
        where=str(path),
        remedy="the raw file holds every reading: record it elsewhere with `rebuild=True`",
    )
