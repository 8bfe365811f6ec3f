"""A run over a fleet: each part done once, its result on the disk, whoever dies on the way."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from scara_iso.disk import write_file
from scara_iso.errors import DataError, ScaraIsoError
from scara_iso.fleets.closer import look_closer
from scara_iso.fleets.database import connect
from scara_iso.fleets.dispatch import Engine, done_by
from scara_iso.fleets.ledger import PartDone, PartLedger
from scara_iso.fleets.parts import digest, parts_of
from scara_iso.fleets.pieces import Piece, Share
from scara_iso.fleets.work import PartResult, Task, examine, whole_part

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
