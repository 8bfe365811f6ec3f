"""Which table and number each report of a folder is of, so that none is lost under another.

The folder's `.scara-iso-reports.json` says it, whatever their format; a report without an entry is
known by the name of its table in its text.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from scara_iso.base.disk import write_file
from scara_iso.base.errors import CannotCreateError
from scara_iso.base.places import target_of

REGISTER = ".scara-iso-reports.json"


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
        text = target.read_bytes() if target.is_file() else b""
        if text and not any(Path(name).name.encode() in text for name in entry.tables):
            _refuse(path, "is not known as a report of this table")
    elif not there.is_of(entry):
        _refuse(path, f"is the report of {', '.join(there.tables)}")
    elif there.number and there.number != entry.number:
        _refuse(path, f"is report {there.number}")


def register(path: Path, entry: Entry) -> None:
    """Note whose report stands in ``path``."""
    target = target_of(path)
    if target is not None:
        known = _read(target.parent) | {target.name: entry}
        lines = {name: asdict(one) for name, one in known.items()}
        text = json.dumps(lines, indent=1, sort_keys=True, ensure_ascii=False)
        write_file(target.parent / REGISTER, f"{text}\n".encode())


def _refuse(path: Path, what: str) -> None:
    raise CannotCreateError(
        what, where=str(path), remedy="name another file or number, or say `replace=True`"
    )


def _read(folder: Path) -> dict[str, Entry]:
    """Return the entries of the reports that are still there, by the names of their files."""
    try:
        lines = json.loads((folder / REGISTER).read_bytes())
        there = [name for name in lines if (folder / name).is_file()]
        return {name: Entry(lines[name]["tables"], lines[name]["number"]) for name in there}
    except (OSError, ValueError, TypeError, KeyError):
        return {}
