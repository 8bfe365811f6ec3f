"""A run over a fleet: each part done once, its result on the disk, whoever dies on the way.

What is done of a fleet's parts, on the disk: a run that died goes on where it stopped.

A line for each part, added after its result is there. A part counts as done where the bytes that
it was made from are those of today, and its result is there; all else is done again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from scara_iso.base.disk import SystemDisk, write_file, write_whole
from scara_iso.base.errors import CannotCreateError, DataError, ScaraIsoError, WriteError
from scara_iso.fleets.database import connect
from scara_iso.fleets.parts import Piece, Share, digest, parts_of
from scara_iso.fleets.work import (
    Engine,
    PartResult,
    Task,
    done_by,
    examine,
    look_closer,
    whole_part,
)

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


RESULTS = "parts"

Track = Callable[[Iterator[Any], int], Iterator[Any]]
"""Passes results on as they come, of so many."""


Results = Iterator[tuple[Sequence[str], Sequence[PartResult] | Exception]]
"""What is found of parts that share a file of results, or what became of them, by their paths."""


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


def run_fleet(
    source: Path,
    to: Path,
    task: Task,
    engine: Engine,
    *,
    level: float,
    track: Track = lambda each, _: each,
) -> FleetRun:
    """Have every part of ``source`` examined, and leave a Parquet file for each in ``to``.

    The p-values are as fine as the false discovery ``level`` needs (`look_closer`). ``track`` may
    watch the results as they come. Raises as `run_parts`.
    """

    def closer(paths: Mapping[str, Path], read: Mapping[str, str]) -> Mapping[str, str]:
        return look_closer(to / RESULTS, paths, read, task, engine, level, track=track)

    options = {**asdict(task.reading), **asdict(task.wanted), "seed": task.seed}

    def results(parts: Sequence[str]) -> Results:
        return _examined(parts, task, engine, track)

    return run_parts(source, to, options, results, after=closer)


def _examined(parts: Sequence[str], task: Task, engine: Engine, track: Track) -> Results:
    """Yield the result of each part once all of its pieces are examined."""
    own = engine.shares_of_each(len(parts))
    pieces = [Piece(part, share) for part in parts for share in own]
    found: dict[str, dict[Share, PartResult]] = {part: {} for part in parts}
    given_up = set[str]()
    work = partial(examine, task=task)
    for piece, result in track(done_by(engine, work, pieces), len(pieces)):
        done = found[piece.path]
        if isinstance(result, PartResult):
            done[piece.share] = result
        elif piece.path not in given_up:
            given_up.add(piece.path)
            yield (piece.path,), result
        if len(done) == len(own):
            del found[piece.path]
            yield (piece.path,), (whole_part([done[share] for share in own]),)


def run_parts(
    source: Path,
    to: Path,
    options: Mapping[str, Any],
    results: Callable[[Sequence[str]], Results],
    *,
    after: Callable[[Mapping[str, Path], Mapping[str, str]], Mapping[str, str]] = lambda *_: {},
) -> FleetRun:
    """Leave in ``to`` what is found of every part of ``source``.

    ``results`` yields that of each path that it is given. ``after`` gets the parts and the SHA-256
    of what was read of each, and returns what failed. Raises `NoInputError` where no part is there,
    as `PartLedger`, `WriteError` for a full disk, `DataError` where a worker is of another version.
    """
    from scara_iso import __version__  # noqa: PLC0415 - the face of all

    connect().close()  # before anything is computed
    paths = {path.name: path for path in parts_of(source)}
    with closing(PartLedger(to, __version__, options)) as ledger:
        (to / RESULTS).mkdir(exist_ok=True)
        before = _done_before(ledger, to, paths)
        _forget(to, {ledger.done[name].result for name in before})
        missing = [name for name in paths if name not in before]
        given_up: dict[str, str] = {}
        for made in _by_name(missing, paths, results):
            for result in made:
                if result.version != __version__:
                    raise DataError(
                        f"a worker has scara-iso {result.version}, and this is {__version__}",
                        where=result.part,
                        remedy="install the same version on all of them",
                    )
                if not result.sha256:  # nothing is kept of it: the next run tries again
                    given_up[result.part] = result.error or "given up"
            _keep(ledger, to, made)
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


def _by_name(
    names: list[str],
    paths: Mapping[str, Path],
    results: Callable[[Sequence[str]], Results],
) -> Iterator[Sequence[PartResult]]:
    by_path = {str(paths[name].absolute()): name for name in names}
    for together, found in results(list(by_path)):
        if isinstance(found, ScaraIsoError):
            raise found
        if isinstance(found, Exception):
            said = f"given up: {type(found).__name__}: {found}"
            yield [PartResult(by_path[path], "", _version(), 0, 0, b"", said) for path in together]
        else:
            yield found


def _version() -> str:
    from scara_iso import __version__  # noqa: PLC0415 - the face of all

    return __version__


def _keep(ledger: PartLedger, to: Path, results: Sequence[PartResult]) -> None:
    """Put the results of parts, which one of them holds, on the disk; then add their lines."""
    kept = [one for one in results if one.sha256]
    if not kept:
        return
    name = _result_name(kept)
    if made := next((one.parquet for one in results if one.parquet), b""):
        write_file(_result_path(to, name), made)
    ledger.add(
        [PartDone(one.part, one.sha256, one.tables, one.failed, one.error, name) for one in kept]
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
