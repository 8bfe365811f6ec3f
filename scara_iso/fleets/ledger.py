"""What is done of a fleet's parts, on the disk: a run that died goes on where it stopped.

A line for each part, added after its result is there. A part counts as done where the bytes that
it was made from are those of today, and its result is there; all else is done again.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scara_iso.disk import SystemDisk, write_whole
from scara_iso.errors import CannotCreateError, DataError, WriteError

SCHEMA = "scara-iso/fleet-manifest/5"
NAME = "manifest.jsonl"
_BEGUN = b'{"schema": "scara-iso/fleet-manifest/'


@dataclass(frozen=True, slots=True)
class PartDone:
    """One part that was done: its input, how many tables it gave, and the file with the results."""

    part: str
    sha256: str
    tables: int
    failed: int
    error: str | None
    result: str
    """Name of the file of results, without its ending: several small parts share one."""


class PartLedger:
    """The manifest of an output folder, locked as long as it is open."""

    def __init__(self, folder: Path, version: str, options: Mapping[str, Any]) -> None:
        """Open or begin the manifest.

        Raises `DataError` where it is of another version or other options, `CannotCreateError`
        where it cannot be there or another run has it.
        """
        self._disk, self._path = SystemDisk(), folder / NAME
        self._another = f"name another folder with -o, or remove {folder}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._disk.open(self._path, new=False)
        except BlockingIOError as error:
            raise CannotCreateError(
                "another run writes here", where=str(folder), remedy="wait for it"
            ) from error
        except OSError as error:
            raise CannotCreateError(
                f"cannot be written: {error.strerror}",
                where=str(folder),
                remedy="name another folder",
            ) from error
        try:
            self.done = self._read(version, dict(options))
        except BaseException:
            self.close()
            raise

    def _read(self, version: str, options: dict[str, Any]) -> dict[str, PartDone]:
        data = self._path.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]
        if not whole and not data.startswith(_BEGUN[: len(data)]):
            whole = data  # another's, and no head that a kill left unfinished
        lines = [line for line in whole.splitlines() if line.strip()]
        if not lines:
            others = [path.name for path in self._path.parent.iterdir() if path.name != NAME]
            if others:
                self._path.unlink()
                raise CannotCreateError(
                    f"is not empty: {others[0]}",
                    where=str(self._path.parent),
                    remedy="name another folder",
                )
            os.truncate(self._path, 0)
            self._add([{"schema": SCHEMA, "version": version, "options": options}])
            return {}
        try:
            head, *rows = map(json.loads, lines)
            if head.get("schema") != SCHEMA:
                raise DataError(
                    f"is no manifest of this form, but {head.get('schema')!r}",
                    where=str(self._path),
                    remedy=self._another,
                )
            found = {row["part"]: PartDone(**row) for row in rows}
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise DataError(
                f"is no manifest: {error}", where=str(self._path), remedy=self._another
            ) from error
        begun = {"version": head.get("version"), **head.get("options", {})}
        other = _differing(begun, {"version": version, **options})
        if other:
            raise DataError(
                f"was begun otherwise: {other}", where=str(self._path), remedy=self._another
            )
        if len(whole) < len(data):  # a line that a kill left unfinished
            os.truncate(self._path, len(whole))
        return found

    def add(self, done: Sequence[PartDone]) -> None:
        """Note that parts are done, once their result is on the disk."""
        self._add([{name: getattr(one, name) for name in PartDone.__slots__} for one in done])
        self.done |= {one.part: one for one in done}

    def _add(self, rows: Sequence[Mapping[str, Any]]) -> None:
        self._write(b"".join(json.dumps(row).encode() + b"\n" for row in rows))

    def _write(self, data: bytes) -> None:
        try:
            write_whole(self._disk, self._file, data)
            self._disk.sync(self._file)
        except OSError as error:
            raise WriteError(
                f"cannot be written: {error.strerror or error}",
                where=str(self._path),
                remedy="make room; the same command goes on where it stopped",
            ) from error

    def close(self) -> None:
        """Let another run have it."""
        self._disk.close(self._file)


def _differing(begun: Mapping[str, Any], mine: Mapping[str, Any]) -> str:
    """Return in words what is not the same."""
    names = [name for name in {**begun, **mine} if begun.get(name) != mine.get(name)]
    return "; ".join(f"{name} was {begun.get(name)} and is {mine.get(name)}" for name in names)
