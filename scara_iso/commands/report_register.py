"""Which table and number each report of a folder is of, so that none is lost under another.

A report says by its text of which table it is. What it does not say, a number in whatever language
or format, stands in the folder's `.scara-iso-reports.json`.
"""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
import zlib
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from scara_iso.base.disk import target_of, write_file
from scara_iso.base.errors import CannotCreateError

REGISTER = ".scara-iso-reports.json"
_LARGEST = 200_000_000
"""Bytes of a report, unpacked."""
_BEFORE, _BEHIND = rb"(?<![\w./\x80-\xff-])", rb"(?![\w\x80-\xff-])"
"""A path is not the end of a longer one, nor the beginning."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One report."""

    tables: Collection[str]
    """Paths of its tables from the folder of the report, else their SHA-256."""
    number: str
    """As it is stated; empty where it is not."""

    def is_of(self, other: Entry) -> bool:
        """Say whether both are of one test: its tables may have become more."""
        return bool(set(self.tables) & set(other.tables))


def entry_of(path: Path, tables: Sequence[Path], hashes: Sequence[str], number: str) -> Entry:
    """Return the entry of a report that is to be written to ``path``."""
    folder = path.resolve().parent
    paths = [Path(os.path.relpath(table.resolve(), folder)).as_posix() for table in tables]
    return Entry(paths or list(hashes), number)


def refuse_another(path: Path, entry: Entry) -> None:
    """Raise `CannotCreateError` where ``path`` holds another report, or one has that number."""
    target = target_of(path)
    if target is None:
        return
    known = _read(target.parent)
    numbered = [name for name, one in known.items() if one.number and one.number == entry.number]
    for name in numbered:
        if not known[name].is_of(entry):
            _refuse(path, f"number {entry.number} is that of {name}, of another table")
    there = known.get(target.name)
    if there is None:
        text = _text(target) if target.is_file() else b""
        if b"scara-iso" in text and not _names(text, entry, target.parent):
            _refuse(path, "is a report of another table")
    elif not there.is_of(entry):
        _refuse(path, f"is the report of another table, {', '.join(there.tables)}")
    elif there.number and there.number != entry.number:
        _refuse(path, f"is report {there.number}")


def register(path: Path, entry: Entry) -> None:
    """Note whose report stands in ``path``, where its text does not say it or it has a number."""
    target = target_of(path)
    if target is None:
        return
    if (
        entry.number
        or target.name in _read(target.parent)
        or not _names(_text(target), entry, target.parent)
    ):
        known = _read(target.parent) | {target.name: entry}
        lines = {name: asdict(one) for name, one in known.items()}
        text = json.dumps(lines, indent=1, sort_keys=True)
        write_file(target.parent / REGISTER, f"{text}\n".encode("ascii"))


def _text(path: Path) -> bytes:
    """Return the bytes of a report, of a workbook those of its parts, without Markdown's escapes.

    Empty of what is no report: it cannot be read, or is larger than any.
    """
    try:
        if path.stat().st_size > _LARGEST:
            return b""
        data = path.read_bytes()
        if zipfile.is_zipfile(io.BytesIO(data)):
            with zipfile.ZipFile(io.BytesIO(data)) as parts:
                if sum(part.file_size for part in parts.infolist()) > _LARGEST:
                    return b""
                data = b"".join(map(parts.read, parts.namelist()))
    except (OSError, RuntimeError, ValueError, EOFError, zipfile.BadZipFile, zlib.error):
        return b""
    return data.replace(b"\\", b"")


def _names(text: bytes, entry: Entry, folder: Path) -> bool:
    """Say whether a text names a table of ``entry``, by its path from ``folder`` or in full."""
    paths = {os.fsencode(one) for name in entry.tables for one in (name, folder / name)}
    spelled = b"|".join(re.escape(os.path.normpath(path)) for path in paths)
    return re.search(_BEFORE + b"(?:" + spelled + b")" + _BEHIND, text) is not None


def _refuse(path: Path, what: str) -> None:
    raise CannotCreateError(
        what, where=str(path), remedy="name another file or number, or say `replace=True`"
    )


def _read(folder: Path) -> dict[str, Entry]:
    """Return the entries of the reports that are still there, by the names of their files."""
    try:
        lines = json.loads((folder / REGISTER).read_bytes())
        there = [name for name in lines if (folder / name).is_file()]
        return {
            name: Entry([str(one) for one in lines[name]["tables"]], str(lines[name]["number"]))
            for name in there
        }
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return {}
