"""A run over a fleet: its pieces mapped by an executor, each done once, whoever dies on the way.

A piece is named after what it is made of: its parts, the SHA-256 of each, and which share of them
it is. So a piece whose name stands in the checkpoint file, with its result on the disk, is done;
one of a part that has changed has another name, and is done anew.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

from scara_iso.base.errors import CannotCreateError, DataError, ScaraIsoError, WriteError
from scara_iso.base.files import Disk, write_file, write_whole
from scara_iso.base.published import INTERNAL, Count, published
from scara_iso.diagnosis import SEED, CyclesWanted
from scara_iso.fleets.database import as_parquet, connect
from scara_iso.fleets.engines import Engine, done_by
from scara_iso.fleets.parts import (
    WHOLE,
    FleetTable,
    PartFile,
    ReadAs,
    Share,
    folders_left,
    part_at,
    parts_of,
)
from scara_iso.iso9283 import moment_of_test
from scara_iso.run import Run, make_frame

SCHEMA = "scara-iso/fleet-manifest/6"
NAME = "manifest.jsonl"
RESULTS = "parts"
Figure: TypeAlias = Literal["X", "Y", "Z", "theta", "XY", "XYZ"]
FIGURES: tuple[Figure, ...] = get_args(Figure)
_BEGUN = b'{"schema": "scara-iso/fleet-manifest/'
_LINES = 4
"""Of an error, the first of its faults among them."""

Track = Callable[[Iterator[Any], int], Iterator[Any]]
"""Passes results on as they come, of so many."""
Row: TypeAlias = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Piece:
    """What is worked on at once: some parts, or a share of one."""

    parts: tuple[PartFile, ...]
    share: Share = WHOLE

    @property
    def name(self) -> str:
        """After its first part and all that it is made of: no other has it."""
        made = [(part.path.name, part.sha256) for part in self.parts]
        whole = json.dumps([made, *self.share])
        return f"{made[0][0]}-{hashlib.sha256(whole.encode()).hexdigest()[:16]}"


@dataclass(frozen=True, slots=True)
class PieceResult:
    """What is made of a piece."""

    tables: int
    failed: int
    """Of these tables."""
    errors: Mapping[str, str] = field(default_factory=dict)
    """Why parts could not be read, by name."""
    rows: bytes = b""
    """As a Parquet file; empty without tables."""


PartRows: TypeAlias = tuple[int, int, Sequence[Any]]
"""What is found in one part: how many tables, how many of these failed, rows as pandas tables."""


def own_version() -> str:
    """Return the version of this program."""
    from scara_iso import __version__  # noqa: PLC0415 - the face of all

    return __version__


@dataclass(frozen=True, slots=True)
class Task:
    """What is to be done with every part."""

    reading: ReadAs
    wanted: CyclesWanted
    seed: int = SEED
    threads: int = 1
    """Of DuckDB, for figures."""
    version: str = field(default_factory=own_version)


class HasChangedError(Exception):
    """A part is no longer what it was when the run began."""

    def __str__(self) -> str:
        return "has changed since it was read: run it again"


def check_unchanged(piece: Piece, task: Task) -> None:
    """Raise `HasChangedError` for other bytes, `DataError` where this is another version."""
    if task.version != own_version():
        raise DataError(
            f"a worker has scara-iso {own_version()}, and this is {task.version}",
            where=piece.parts[0].path.name,
            remedy="install the same version on all of them",
        )
    if any(part_at(part.path) != part for part in piece.parts):
        raise HasChangedError


def found_in(
    piece: Piece,
    task: Task,
    kinds: Mapping[str, str],
    work: Callable[[Path, Task, Share], PartRows],
) -> PieceResult:
    """Return what ``work`` finds in the parts of a piece, as columns of these SQL types.

    A part that cannot be read is an error in it. Raises as `check_unchanged`, and `WriteError`.
    """
    check_unchanged(piece, task)
    tables, failed, errors, rows = 0, 0, dict[str, str](), list[Any]()
    for path in (part.path for part in piece.parts):
        try:
            count, unreadable, own = work(path, task, piece.share)
        except WriteError:
            raise
        except ScaraIsoError as error:
            errors[path.name] = in_one_line(error)
        else:
            tables, failed, rows = tables + count, failed + unreadable, [*rows, *own]
    return PieceResult(tables, failed, errors, as_parquet(rows, kinds) if tables else b"")


def rows_as_table(rows: Sequence[Row], kinds: Mapping[str, str]) -> Any:
    """Return rows as a pandas table with the columns of ``kinds``."""
    return make_frame({name: [row.get(name) for row in rows] for name in kinds}, {})


def date_of(run: Run) -> str | None:
    """Return when a table was made, as it states it."""
    moment = moment_of_test(run)
    return None if moment is None else moment.replace(tzinfo=None).isoformat()


def why(table: FleetTable, error: ScaraIsoError) -> str:
    """Return why there is nothing of a table, and where it may be two under one name."""
    run, message = table.run, in_one_line(error)
    if isinstance(run, ScaraIsoError):
        return message
    keys = [run.cycle, *(one for one in (run.pose, run.direction) if one is not None)]
    if len(set(zip(*keys, strict=True))) == len(run):
        return message
    return f"{message}; if two tests have this name, tell them apart by the column test"


def in_one_line(error: ScaraIsoError) -> str:
    """Return an error, the first of its faults and what to do about it on one line."""
    lines = [line.strip() for line in str(error).splitlines()]
    more = [f"and {len(lines) - _LINES} more"] if len(lines) > _LINES else []
    remedy = [error.remedy] if error.remedy else []
    return "; ".join((*lines[:_LINES], *more, *remedy))


# ---- the checkpoint file


class Checkpoint:
    """The manifest of an output folder, locked as long as it is open: a line for each piece done.

    A line is added after its result is on the disk.
    """

    def __init__(self, folder: Path, version: str, options: Mapping[str, Any]) -> None:
        """Open or begin it.

        Raises `DataError` where it is of another version or other options, `CannotCreateError`
        where it cannot be there or another run has it.
        """
        self._disk, self._path = Disk(), folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._disk.open(self._path, new=False)
        except OSError as error:
            taken = isinstance(error, BlockingIOError)
            raise CannotCreateError(
                "another run writes here" if taken else f"cannot be written: {error.strerror}",
                where=str(folder),
                remedy="wait for it" if taken else "name another folder",
            ) from error
        try:
            self.done = self._read(version, dict(options))
        except BaseException:
            self.close()
            raise

    def _read(self, version: str, options: Row) -> dict[str, Row]:
        data = self._path.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]
        if not whole and not data.startswith(_BEGUN[: len(data)]):
            whole = data  # another's, and no head that a kill left unfinished
        lines = [line for line in whole.splitlines() if line.strip()]
        if not lines:
            self._begin({"schema": SCHEMA, "version": version, "options": options})
            return {}
        try:
            head, *rows = map(json.loads, lines)
            if head.get("schema") != SCHEMA:
                raise self._refused(f"is not a manifest of this form, but {head.get('schema')!r}")
            begun = {"version": head.get("version"), **head.get("options", {})}
            found = {row["result"]: row for row in rows}
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise self._refused(f"is not a manifest: {error}") from error
        mine = {"version": version, **options}
        names = [name for name in {**begun, **mine} if begun.get(name) != mine.get(name)]
        if names:
            other = (f"{name} was {begun.get(name)} and is {mine.get(name)}" for name in names)
            raise self._refused(f"was begun otherwise: {'; '.join(other)}")
        if len(whole) < len(data):  # a line that a kill left unfinished
            os.truncate(self._path, len(whole))
        return found

    def _begin(self, head: Row) -> None:
        folder = self._path.parent
        for other in (path.name for path in folder.iterdir() if path.name != NAME):
            self._path.unlink()
            raise CannotCreateError(
                f"is not empty: {other}", where=str(folder), remedy="name another folder"
            )
        os.truncate(self._path, 0)
        self._write(head)

    def _refused(self, what: str) -> DataError:
        remedy = f"name another folder with -o, or remove {self._path.parent}"
        return DataError(what, where=str(self._path), remedy=remedy)

    def has(self, name: str, to: Path) -> bool:
        """Say whether a piece is done and its result is there."""
        done = self.done.get(name)
        return done is not None and (not done["tables"] or result_path(to, name).exists())

    def add(self, piece: Piece, found: PieceResult) -> None:
        """Note that a piece is done, once its result is on the disk."""
        sha256 = {part.path.name: part.sha256 for part in piece.parts}
        row = {"result": piece.name, "sha256": sha256, "tables": found.tables}
        row |= {"failed": found.failed, "errors": found.errors}
        self._write(row)
        self.done[piece.name] = row

    def _write(self, row: Row) -> None:
        try:
            write_whole(self._disk, self._file, json.dumps(row).encode() + b"\n")
            self._disk.sync(self._file)
        except OSError as error:
            raise WriteError(
                f"cannot be written: {error.strerror or error}",
                where=str(self._path),
                remedy="make room; the same command continues where it stopped",
            ) from error

    def close(self) -> None:
        """Let another run have it."""
        self._disk.close(self._file)


# ---- the run


@dataclass(frozen=True, slots=True)
class FleetRun:
    """What became of the parts of the source."""

    folder: Path = field(metadata=INTERNAL)
    """Where the results stand."""
    parts: Count = field(metadata=published("count"))
    """How many there are."""
    before: Count = field(metadata=published("done_before"))
    """By an earlier run."""
    tables: int = field(metadata=INTERNAL)
    """How many were examined, without those of which there is nothing."""
    failed: Mapping[str, str]
    """Those that could not be read or were given up, with why."""
    doubts: tuple[str, ...] = field(default=(), metadata=INTERNAL)
    """Parts with the same bytes, and folders of tables that are not looked at."""


def result_path(to: Path, name: str) -> Path:
    """Return where the result of a piece of this name stands."""
    return to / RESULTS / f"{name}.parquet"


def run_pieces(
    source: Path,
    to: Path,
    options: Mapping[str, Any],
    pieces_of: Callable[[Sequence[PartFile]], Sequence[Piece]],
    work: Callable[[Piece], PieceResult],
    engine: Engine,
    track: Track,
    *,
    after: Callable[[Mapping[str, Piece]], Mapping[str, str]] = lambda _: {},
) -> FleetRun:
    """Leave in ``to`` what ``work`` finds of every part of ``source``.

    ``pieces_of`` the parts are worked on. ``after`` gets those that are done, by
    name, and returns what failed of which part. Raises `NoInputError` where no part is there, as
    `Checkpoint`, `WriteError` for a full disk, `DataError` where a worker is of another version.
    """
    connect().close()  # before anything is computed
    paths = parts_of(source)
    with closing(Checkpoint(to, own_version(), options)) as checkpoint:
        (to / RESULTS).mkdir(exist_ok=True)
        parts, failed = _looked_at(paths)
        pieces = {piece.name: piece for piece in pieces_of(parts)}
        left = {name: one for name, one in pieces.items() if not checkpoint.has(name, to)}
        for path in (to / RESULTS).glob("*.parquet"):
            if path.stem not in pieces.keys() - left.keys():  # of a part as it was once
                path.unlink()
        for piece, found in track(done_by(engine, work, list(left.values())), len(left)):
            if isinstance(found, PieceResult):
                if found.rows:
                    write_file(result_path(to, piece.name), found.rows)
                checkpoint.add(piece, found)
            else:  # nothing is kept of it: the next run tries again
                failed |= {part.path.name: given_up(found) for part in piece.parts}
        pieces = {name: one for name, one in pieces.items() if name in checkpoint.done}
        done = [checkpoint.done[name] for name in pieces]
        failed |= {part: why for one in done for part, why in one["errors"].items()}
        failed |= after(pieces)
    undone = {part for piece in left.values() for part in piece.parts}
    return FleetRun(
        folder=to,
        parts=len(paths),
        before=len(parts) - len(undone),
        tables=sum(one["tables"] - one["failed"] for one in done),
        failed=failed,
        doubts=(*_copies(parts), *folders_left(source, NAME)),
    )


def _copies(parts: Sequence[PartFile]) -> Iterator[str]:
    """Yield the parts that are copies of each other: each counts."""
    named: dict[str, list[str]] = {}
    for part in parts:
        named.setdefault(part.sha256, []).append(part.path.name)
    for names in named.values():
        if len(names) > 1:
            yield f"{', '.join(names)} have the same bytes, and each counts: remove the copies"


def _looked_at(paths: Sequence[Path]) -> tuple[list[PartFile], dict[str, str]]:
    found, failed = list[PartFile](), dict[str, str]()
    for path in paths:
        try:
            found.append(part_at(path.absolute()))
        except ScaraIsoError as error:
            failed[path.name] = in_one_line(error)
    return found, failed


def given_up(error: Exception) -> str:
    """Return what became of a part without a result; raises an error of ours."""
    if isinstance(error, ScaraIsoError):
        raise error
    if isinstance(error, HasChangedError):
        return str(error)
    return f"given up: {type(error).__name__}: {error}"
