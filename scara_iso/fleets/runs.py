"""A run over a fleet: each part done once, its result on the disk, whoever dies on the way.

The manifest has a line for each part, added after its result is there. A part counts as done where
the bytes that it was made from are those of today, and its result is there; all else is done again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

from scara_iso.base.disk import Disk, write_file, write_whole
from scara_iso.base.errors import CannotCreateError, DataError, ScaraIsoError, WriteError
from scara_iso.fleets.database import as_parquet, connect
from scara_iso.fleets.parts import FleetTable, digest, parts_of
from scara_iso.iso9283 import moment_of_test
from scara_iso.run import Run, make_frame

SCHEMA = "scara-iso/fleet-manifest/5"
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
class PartResult:
    """What is made of one part."""

    part: str
    sha256: str
    version: str
    """Of the program that worked on it."""
    tables: int = 0
    failed: int = 0
    """Of these tables."""
    rows: tuple[Any, ...] = ()
    """Pandas tables."""
    error: str | None = None
    """Why the part could not be read."""


Results = Iterator[tuple[Sequence[str], Sequence[PartResult] | Exception]]
"""What is found of parts that share a file of results, or what became of them, by their paths."""


PartRows: TypeAlias = tuple[int, int, tuple[Any, ...]]
"""What is found of one part: how many tables, how many of these failed, rows as pandas tables."""


def result_of(path: Path, work: Callable[[Path], PartRows]) -> PartResult:
    """Return what ``work`` finds of a part, or why it cannot be read; raises `WriteError`."""
    sha256 = ""
    try:
        sha256 = digest(path)
        return PartResult(path.name, sha256, _version(), *work(path))
    except WriteError:
        raise
    except ScaraIsoError as error:
        return PartResult(path.name, sha256, _version(), error=in_one_line(error))


def rows_as_table(rows: Sequence[Row], kinds: Mapping[str, str]) -> Any:
    """Return rows as a pandas table with the columns of ``kinds``."""
    return make_frame({name: [row.get(name) for row in rows] for name in kinds}, {})


def date_of(run: Run) -> str | None:
    """Return when a table was made, as it states it."""
    moment = moment_of_test(run)
    return None if moment is None else moment.replace(tzinfo=None).isoformat()


def why(table: FleetTable, error: ScaraIsoError) -> str:
    """Return why there is nothing of a table, and where it may be two under one name."""
    run = table.run
    if isinstance(run, ScaraIsoError):
        return in_one_line(error)
    keys = [run.cycle, *(one for one in (run.pose, run.direction) if one is not None)]
    if len(set(zip(*keys, strict=True))) == len(run):
        return in_one_line(error)
    return f"{in_one_line(error)}; if two tests have this name, tell them apart by the column test"


def in_one_line(error: ScaraIsoError) -> str:
    """Return an error, the first of its faults and what to do about it on one line."""
    lines = [line.strip() for line in str(error).splitlines()]
    more = [f"and {len(lines) - _LINES} more"] if len(lines) > _LINES else []
    remedy = [error.remedy] if error.remedy else []
    return "; ".join((*lines[:_LINES], *more, *remedy))


# ---- the manifest


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
        self._disk, self._path = Disk(), folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._disk.open(self._path, new=False)
        except BlockingIOError as error:
            raise CannotCreateError(
                "another run writes here", where=str(folder), remedy="wait for it"
            ) from error
        except OSError as error:
            what, remedy = f"cannot be written: {error.strerror}", "name another folder"
            raise CannotCreateError(what, where=str(folder), remedy=remedy) from error
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
            self._begin({"schema": SCHEMA, "version": version, "options": options})
            return {}
        try:
            head, *rows = map(json.loads, lines)
            if head.get("schema") != SCHEMA:
                raise self._refused(f"is not a manifest of this form, but {head.get('schema')!r}")
            found = {row["part"]: PartDone(**row) for row in rows}
            begun = {"version": head.get("version"), **head.get("options", {})}
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise self._refused(f"is not a manifest: {error}") from error
        if other := _differing(begun, {"version": version, **options}):
            raise self._refused(f"was begun otherwise: {other}")
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
        self._write([head])

    def _refused(self, what: str) -> DataError:
        remedy = f"name another folder with -o, or remove {self._path.parent}"
        return DataError(what, where=str(self._path), remedy=remedy)

    def add(self, done: Sequence[PartDone]) -> None:
        """Note that parts are done, once their result is on the disk."""
        self._write([asdict(one) for one in done])
        self.done |= {one.part: one for one in done}

    def _write(self, rows: Sequence[Row]) -> None:
        data = b"".join(json.dumps(row).encode() + b"\n" for row in rows)
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


# ---- the run


@dataclass(frozen=True, slots=True)
class FleetRun:
    """What became of the parts."""

    folder: Path
    """Where the results stand."""
    parts: int
    """How many the source has."""
    before: int
    """Parts that an earlier run had done."""
    tables: int
    """How many tables were examined, without those of which there is nothing."""
    failed: Mapping[str, str]
    """Parts that could not be read or were given up, with why."""


def run_parts(
    source: Path,
    to: Path,
    options: Mapping[str, Any],
    kinds: Mapping[str, str],
    results: Callable[[Sequence[str]], Results],
    *,
    after: Callable[[Mapping[str, Path], Mapping[str, str]], Mapping[str, str]] = lambda *_: {},
) -> FleetRun:
    """Leave in ``to`` what is found of every part of ``source``: columns of these SQL types.

    ``results`` yields that of each path that it is given. ``after`` gets the parts and the SHA-256
    of what was read of each, and returns what failed. Raises `NoInputError` where no part is there,
    as `PartLedger`, `WriteError` for a full disk, `DataError` where a worker is of another version.
    """
    connect().close()  # before anything is computed
    paths = {path.name: path for path in parts_of(source)}
    with closing(PartLedger(to, _version(), options)) as ledger:
        (to / RESULTS).mkdir(exist_ok=True)
        before = _done_before(ledger, to, paths)
        _forget(to, {ledger.done[name].result for name in before})
        given_up: dict[str, str] = {}
        for together, found in results(
            [str(path.absolute()) for name, path in paths.items() if name not in before]
        ):
            made = _made_of(together, found)
            # nothing is kept of what was given up: the next run tries again
            given_up |= {one.part: one.error or "given up" for one in made if not one.sha256}
            _keep(ledger, to, kinds, [one for one in made if one.sha256])
        done = [one for one in ledger.done.values() if one.part in paths.keys() - given_up]
        failed = {one.part: one.error for one in done if one.error}
        later = after(paths, {one.part: one.sha256 for one in done})
    return FleetRun(
        folder=to,
        parts=len(paths),
        before=len(before),
        tables=sum(one.tables - one.failed for one in done),
        failed={**failed, **later, **given_up},
    )


def _made_of(
    together: Sequence[str], found: Sequence[PartResult] | Exception
) -> Sequence[PartResult]:
    """Return the results of parts; raises an error of ours, and for a worker of another version."""
    if isinstance(found, ScaraIsoError):
        raise found
    if isinstance(found, Exception):
        error = f"given up: {type(found).__name__}: {found}"
        return [PartResult(Path(path).name, "", _version(), error=error) for path in together]
    for result in found:
        if result.version != _version():
            raise DataError(
                f"a worker has scara-iso {result.version}, and this is {_version()}",
                where=result.part,
                remedy="install the same version on all of them",
            )
    return found


def _done_before(ledger: PartLedger, to: Path, paths: Mapping[str, Path]) -> set[str]:
    """Return the parts that are done: all that share a file of results are there, as they were."""
    sharing: dict[str, list[PartDone]] = {}
    for one in ledger.done.values():
        sharing.setdefault(one.result, []).append(one)
    return {
        one.part
        for result, together in sharing.items()
        if result == _result_name(together)  # a kill may leave the lines of some of them only
        and all(one.part in paths and _is_as_done(one, to, paths[one.part]) for one in together)
        for one in together
    }


def _is_as_done(done: PartDone, to: Path, path: Path) -> bool:
    if not (done.error or _result_path(to, done.result).exists()):
        return False
    try:
        return done.sha256 == digest(path)
    except ScaraIsoError:
        return False


def _result_path(to: Path, result: str) -> Path:
    return to / RESULTS / f"{result}.parquet"


def _forget(to: Path, results: Collection[str]) -> None:
    """Remove all results but those of parts as they are today: no other is of the fleet."""
    for path in (to / RESULTS).glob("*.parquet"):
        if path.name.removesuffix(".parquet") not in results:
            path.unlink()


def _version() -> str:
    from scara_iso import __version__  # noqa: PLC0415 - the face of all

    return __version__


def _keep(
    ledger: PartLedger, to: Path, kinds: Mapping[str, str], results: Sequence[PartResult]
) -> None:
    """Put the results of parts on the disk, in one file; then add their lines."""
    if not results:
        return
    name = _result_name(results)
    if tables := [table for one in results for table in one.rows]:
        write_file(_result_path(to, name), as_parquet(tables, kinds))
    ledger.add(
        [PartDone(one.part, one.sha256, one.tables, one.failed, one.error, name) for one in results]
    )


def _result_name(together: Sequence[PartDone | PartResult]) -> str:
    """Return the name of the file of results that parts share, after all that it is made from.

    Others never take it.
    """
    found = sorted(f"{one.part} {one.sha256}" for one in together)
    name = min(one.part for one in together)
    if len(found) == 1:
        return name
    all_of_them = "\n".join(found)
    return f"{name}-{hashlib.sha256(all_of_them.encode()).hexdigest()}"
