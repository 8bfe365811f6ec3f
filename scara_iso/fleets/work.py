"""What is done with a piece of a part, by whichever process or machine: each table is diagnosed.

The one seam to where the work is done: an `Executor`, opened anew where it broke.

A process that dies breaks its pool and takes down what was under way in it. Those items are then
done alone, each in a pool of its own: only the one that kills its process again is given up.

Finer p-values, where so many robots are judged together that those of a table are too coarse.

1,000 orders of its cycles give a table a p-value of 0.001 at best, and a lone ill robot among more
than 47 needs a smaller one. So the tables that none of their orders came as far as are compared
with more orders: with as many as name all of their robots together, if none of these comes as far
either. Some drop out, fewer robots need more orders, and so on until all that are left are named.

The p-values stay valid: below what the orders so far could give, p is that of all orders of a
step (Besag and Clifford 1991), and their number depends on the other tables only.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from scara_iso.base.errors import ScaraIsoError, ServiceError, WriteError
from scara_iso.diagnosis import PERMUTATIONS, SEED, CyclesWanted, finer, floor_of, screen
from scara_iso.fleets.database import (
    Columns,
    as_parquet,
    joined_parquet,
    results_in,
    rewrite_parquet,
    unnested,
)
from scara_iso.fleets.parts import FleetTable, Piece, ReadAs, Share, TableName, digest, tables_in
from scara_iso.iso9283 import moment_of_test
from scara_iso.run import Run

Item = TypeVar("Item")
Result = TypeVar("Result")
_TRIES = 2
_GONE = "the cluster has gone away"
_GO_ON = "start it again; the same command then goes on where it stopped"
_LOOK_AGAIN = 10
"""Seconds after which it is looked who is there, where nothing is done meanwhile."""
_ROUNDS = 2
"""At least so often all that can be under way is: more evens the load, and reads a part oftener."""


@dataclass(frozen=True, slots=True)
class Engine:
    """Where the work is done: how an executor of it is opened, and how much is under way."""

    open: Callable[[], Executor]
    under_way: Callable[[], int]
    """Of the moment: a cluster grows and shrinks. Raises `ServiceError` where nobody is left."""

    def shares_of_each(self, several: int) -> list[Share]:
        """Return the shares in which each of several is given out, so that nobody waits long."""
        count = math.ceil(_ROUNDS * self.under_way() / max(several, 1))
        return [Share(number, count) for number in range(count)]


def done_by(
    engine: Engine, work: Callable[[Item], Result], items: Sequence[Item]
) -> Iterator[tuple[Item, Result | Exception]]:
    """Yield each item once, as it is done, with its result or what became of it."""
    waiting = deque(items)
    while waiting:
        with engine.open() as executor:
            try:
                suspects = yield from _until_broken(executor, engine.under_way, work, waiting)
            except ServiceError:
                executor.shutdown(wait=False)  # nobody is left to wait for
                raise
        for item in suspects:
            yield item, _alone(engine, work, item)


def _until_broken(
    executor: Executor,
    under_way: Callable[[], int],
    work: Callable[[Item], Result],
    waiting: deque[Item],
) -> Generator[tuple[Item, Result | Exception], None, list[Item]]:
    """Yield what is done; return what was under way where the executor broke, else nothing."""
    running: dict[Future[Result], Item] = {}
    broken = False
    while running or (waiting and not broken):
        room = under_way()
        while waiting and len(running) < room and not broken:
            try:
                running[executor.submit(work, waiting[0])] = waiting[0]
                waiting.popleft()
            except BrokenExecutor:
                broken = True
        finished, _ = wait(running, _LOOK_AGAIN, return_when=FIRST_COMPLETED)
        outcomes: dict[Future[Result], Result | Exception] = {}
        for future in finished:
            outcome = _outcome(future)
            outcomes[future] = outcome
        if broken or any(isinstance(one, BrokenExecutor) for one in outcomes.values()):
            return list(running.values())
        yield from ((running.pop(future), outcome) for future, outcome in outcomes.items())
    return []


def _outcome(future: Future[Result]) -> Result | Exception:
    try:
        error = future.exception()
    except CancelledError as gone:  # nothing here cancels
        raise ServiceError(_GONE, remedy=_GO_ON) from gone
    if error is None:
        return future.result()
    if isinstance(error, Exception):
        return error
    raise error


def _alone(engine: Engine, work: Callable[[Item], Result], item: Item) -> Result | Exception:
    failed: Exception = RuntimeError("not tried")
    for _ in range(_TRIES):
        with engine.open() as executor:
            found = _outcome(executor.submit(work, item))
        if not isinstance(found, BrokenExecutor):
            return found
        failed = found
    return failed


_LINES = 4
FIGURES = ("X", "Y", "Z", "theta", "XY", "XYZ")


@dataclass(frozen=True, slots=True)
class Task:
    """What is to be done with every part."""

    reading: ReadAs
    wanted: CyclesWanted
    seed: int = SEED


@dataclass(frozen=True, slots=True)
class TableRow:
    """What is found of one table, of all its poses together; the largest RP of a pose."""

    robot: str
    test: str
    cycles: int = 0
    poses: int = 0
    verdict: str | None = None
    p_value: float | None = None
    """Of all poses together."""
    at_floor: bool = False
    """Nothing drawn came as far: the p-value is a bound."""
    orders: int = PERMUTATIONS
    """How many orders of its cycles it was compared with at most."""
    effects: tuple[str, ...] = ()
    """Each once."""
    RP: dict[str, float] = field(default_factory=dict)
    """By figure [mm, deg]."""
    date: str | None = None
    """When it was made, as the table states it."""
    name: str | None = None
    """Of the robot, as the table states it."""
    error: str | None = None
    """Why there is nothing of it."""


@dataclass(frozen=True, slots=True)
class PartResult:
    """What is made of one part."""

    part: str
    sha256: str
    version: str
    """Of the program that worked on it."""
    tables: int
    failed: int
    """Of these tables."""
    parquet: bytes
    """A row for each table, as a file."""
    error: str | None = None
    """Why the part could not be read."""


def examine(piece: Piece, task: Task) -> PartResult:
    """Return what is found of a piece; what cannot be read is said in it, and raises nothing."""
    return result_of(Path(piece.path), partial(_diagnosed, task=task, share=piece.share))


def result_of(path: Path, made: Callable[[Path], tuple[int, int, bytes]]) -> PartResult:
    """Return what is ``made`` of a part: its tables, how many failed, and the file of results."""
    from scara_iso import __version__  # noqa: PLC0415 - the face of all

    sha256 = ""
    try:
        sha256 = digest(path)
        return PartResult(path.name, sha256, __version__, *made(path))
    except WriteError:
        raise
    except ScaraIsoError as error:
        return PartResult(path.name, sha256, __version__, 0, 0, b"", in_one_line(error))


def whole_part(pieces: Sequence[PartResult]) -> PartResult:
    """Return the result of a part that several pieces are, in their order.

    One of another version stands for all, and there is nothing of a part that cannot be read, or
    that has changed between two of them.
    """
    first = pieces[0]
    odd = [one for one in pieces if one.version != first.version or one.error]
    if len(pieces) == 1 or odd:
        return odd[0] if odd else first
    if len({one.sha256 for one in pieces}) > 1:
        return replace(first, sha256="", error="has changed while it was read: run it again")
    return replace(
        first,
        tables=sum(one.tables for one in pieces),
        failed=sum(one.failed for one in pieces),
        parquet=joined_parquet([one.parquet for one in pieces]),
    )


def _diagnosed(path: Path, task: Task, share: Share) -> tuple[int, int, bytes]:
    rows = [_row(table, task) for table in tables_in(path, task.reading, share=share)]
    failed = sum(row.error is not None for row in rows)
    return len(rows), failed, as_parquet(*unnested(_columns(rows, path.name)))


def _columns(rows: Sequence[TableRow], part: str) -> Columns:
    kinds = {
        "robot": "VARCHAR",
        "test": "VARCHAR",
        "cycles": "INTEGER",
        "poses": "INTEGER",
        "verdict": "VARCHAR",
        "p_value": "DOUBLE",
        "at_floor": "BOOLEAN",
        "orders": "INTEGER",
        "date": "VARCHAR",
        "name": "VARCHAR",
    }
    columns: dict[str, tuple[str, Sequence[object]]] = {
        name: (kind, [getattr(row, name) for row in rows]) for name, kind in kinds.items()
    }
    columns["effects"] = ("VARCHAR", [",".join(row.effects) for row in rows])
    for name in FIGURES:
        columns[f"RP_{name}"] = ("DOUBLE", [row.RP.get(name) for row in rows])
    columns["error"] = ("VARCHAR", [row.error for row in rows])
    columns["part"] = ("VARCHAR", [part] * len(rows))
    return columns


def _row(table: FleetTable, task: Task) -> TableRow:
    if isinstance(table.run, ScaraIsoError):
        return TableRow(table.robot, table.test, error=in_one_line(table.run))
    try:
        found = screen(table.run, task.wanted, seed=task.seed)
    except ScaraIsoError as error:
        return TableRow(table.robot, table.test, error=refused(error, table.run))
    return TableRow(
        robot=table.robot,
        test=table.test,
        cycles=found.cycles,
        poses=found.poses,
        verdict=found.verdict.value,
        p_value=found.p_value,
        at_floor=found.at_floor,
        effects=found.effects,
        RP=dict(found.RP),
        date=date_of(table.run),
        name=table.name,
    )


def date_of(run: Run) -> str | None:
    """Return when a table was made, as it states it."""
    moment = moment_of_test(run)
    return None if moment is None else moment.replace(tzinfo=None).isoformat()


def refused(error: ScaraIsoError, run: Run) -> str:
    """Return why there is nothing of a table, and where it may be two under one name."""
    told_apart = [run.cycle, *(one for one in (run.pose, run.direction) if one is not None)]
    if len(set(zip(*told_apart, strict=True))) == len(run):
        return in_one_line(error)
    return f"{in_one_line(error)}; if two tests have this name, tell them apart by the column test"


def in_one_line(error: ScaraIsoError) -> str:
    """Return an error, the first of its faults and what to do about it on one line."""
    lines = [line.strip() for line in str(error).splitlines()]
    more = [f"and {len(lines) - _LINES} more"] if len(lines) > _LINES else []
    remedy = [error.remedy] if error.remedy else []
    return "; ".join((*lines[:_LINES], *more, *remedy))


MOST_ORDERS = 250_000
"""Enough for a lone ill robot among 11,000; minutes of one core for a table."""
_ALIKE = 1 + 1e-9


@dataclass(frozen=True, slots=True)
class CloserLook:
    """The p-values of some tables of a part by more orders, and whether each is at its floor."""

    sha256: str
    p_values: Mapping[TableName, tuple[float, bool]]


@dataclass(frozen=True, slots=True)
class _Some:
    """Some tables of a part."""

    part: str
    path: str
    tables: tuple[TableName, ...]


@dataclass(frozen=True, slots=True)
class _AtFloor:
    """The tables that none of so many orders came as far as, by part."""

    robots: int
    """In the whole fleet."""
    named: frozenset[str]
    """Robots of the tables."""
    most_tables: int
    """Of one of these robots."""
    behind: Mapping[str, frozenset[TableName]]
    """Those that were compared with no more orders yet."""


def look_closer(
    results: Path,
    paths: Mapping[str, Path],
    read_before: Mapping[str, str],
    task: Task,
    engine: Engine,
    level: float,
    *,
    track: Callable[[Iterator[Any], int], Iterator[Any]],
) -> dict[str, str]:
    """Put finer p-values into the ``results`` where the false discovery ``level`` needs them.

    ``paths`` are the parts and ``read_before`` the SHA-256 of what was read of each. Returns why a
    part was left as it is, by part.
    """
    orders, failed = PERMUTATIONS, dict[str, str]()
    while True:
        found = _at_floor(results, orders)
        needed = _needed(found, level)
        if needed <= orders or orders == MOST_ORDERS:
            return failed
        orders = min(needed, MOST_ORDERS)
        behind = {part: tables for part, tables in found.behind.items() if part not in failed}
        shares = engine.shares_of_each(len(behind))
        tasks = [
            _Some(part, str(paths[part].absolute()), tuple(own))
            for part, tables in behind.items()
            for own in (share.take(sorted(tables)) for share in shares)
            if own
        ]
        work = partial(_looked, task=task, orders=orders)
        for some, look in track(done_by(engine, work, tasks), len(tasks)):
            part = some.part
            if isinstance(look, Exception):
                failed[part] = f"its p-values stay coarse: {type(look).__name__}: {look}"
            elif look.sha256 != read_before.get(part):
                failed[part] = "has changed since it was read: run it again"
            else:
                rewrite_parquet(results / f"{part}.parquet", look.p_values, orders)


def _needed(found: _AtFloor, level: float) -> int:
    """Return how many orders name all robots at the floor together, where none comes as far."""
    if not found.named:
        return 0
    share = level * len(found.named) / (found.robots * found.most_tables)
    return math.ceil(floor_of(0) / share)


def _at_floor(results: Path, orders: int) -> _AtFloor:
    """Return what so many orders leave at the floor, though later steps may have gone on."""
    sql = (
        "WITH fleet AS (SELECT *, count(*) OVER (PARTITION BY robot) AS tables FROM fleet "
        "WHERE p_value IS NOT NULL), everything AS (SELECT count(DISTINCT robot) AS robots "
        "FROM fleet) SELECT part, robot, as_read, test, orders, tables, robots FROM fleet, "
        "everything "
        "WHERE orders > ? OR (orders = ? AND at_floor AND p_value <= ?) ORDER BY part"
    )
    with results_in(results) as query:
        rows = query(sql, orders, orders, floor_of(orders) * _ALIKE)
    behind: dict[str, frozenset[TableName]] = {}
    for part, _, as_read, test, so_far, *_ in rows:
        if so_far == orders:
            behind[part] = behind.get(part, frozenset()) | {(as_read, test)}
    named = frozenset(row[1] for row in rows)
    return _AtFloor(rows[0][6] if rows else 0, named, max((r[5] for r in rows), default=1), behind)


def _looked(some: _Some, task: Task, orders: int) -> CloserLook:
    """Return the finer p-values of some tables of a part."""
    path, found = Path(some.path), {}
    for table in tables_in(path, task.reading, some.tables):
        if isinstance(table.run, Run):
            found[table.robot, table.test] = finer(table.run, task.wanted, orders, seed=task.seed)
    return CloserLook(digest(path), found)
