"""Finer p-values, where so many robots are judged together that those of a table are too coarse.

1,000 orders of its cycles give a table a p-value of 0.001 at best, and a lone ill robot among more
than 47 needs a smaller one. So the tables that none of their orders came as far as are compared
with more orders: with as many as name all of their robots together, if none of these comes as far
either. Some drop out, fewer robots need more orders, and so on until all that are left are named.

The p-values stay valid: below what the orders so far could give, p is that of all orders of a
step (Besag and Clifford 1991), and their number depends on the other tables only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from scara_iso.diagnosis import PERMUTATIONS, finer, floor_of
from scara_iso.fleets.database import results_in, rewrite_parquet
from scara_iso.fleets.dispatch import Engine, done_by
from scara_iso.fleets.parts import TableName, digest, tables_in
from scara_iso.fleets.work import Task
from scara_iso.run import Run

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
