"""Each table of a part diagnosed, by whichever process or machine; and finer p-values.

1,000 orders of its cycles give a table a p-value of 0.001 at best, and a lone ill robot among more
than 47 needs a smaller one. So the tables that none of their orders came as far as are compared
with more orders: with as many as name all of their robots together, if none of these comes as far
either. Some drop out, fewer robots need more orders, and so on until all that are left are named.

The p-values stay valid: below what the orders so far could give, p is that of all orders of a
step (Besag and Clifford 1991), and their number depends on the other tables only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeAlias

from scara_iso.base.disk import write_file
from scara_iso.base.errors import ScaraIsoError
from scara_iso.diagnosis import PERMUTATIONS, SEED, CyclesWanted, finer, floor_of, screen
from scara_iso.fleets import runs
from scara_iso.fleets.database import alone, as_parquet, results_in, workspace
from scara_iso.fleets.engines import Engine, done_by
from scara_iso.fleets.parts import WHOLE, FleetTable, ReadAs, Share, TableName, digest, tables_in
from scara_iso.run import Run

MOST_ORDERS = 250_000
"""Enough for a lone ill robot among 11,000; minutes of one core for a table."""
_ALIKE = 1 + 1e-9
KINDS = {
    **dict.fromkeys(("robot", "test"), "VARCHAR"),
    **dict.fromkeys(("cycles", "poses"), "INTEGER"),
    "verdict": "VARCHAR",
    "p_value": "DOUBLE",
    "at_floor": "BOOLEAN",
    "orders": "INTEGER",
    **dict.fromkeys(("date", "name", "effects"), "VARCHAR"),
    **{f"RP_{name}": "DOUBLE" for name in runs.FIGURES},
    **dict.fromkeys(("error", "part"), "VARCHAR"),
}
"""The columns of the results and their SQL types.

A row for each table, all its poses together: ``p_value``, ``at_floor`` where nothing drawn came as
far, ``orders`` of its cycles that it was compared with at most, ``effects`` each once, the largest
RP of a pose [mm, deg]; or ``error``, why there is nothing of it.
"""


@dataclass(frozen=True, slots=True)
class Task:
    """What is to be done with every part."""

    reading: ReadAs
    wanted: CyclesWanted
    seed: int = SEED


@dataclass(frozen=True, slots=True)
class Piece:
    """Some tables of a part: a share of them, or those of these names."""

    path: str
    share: Share = WHOLE
    tables: tuple[TableName, ...] | None = None


def run_fleet(
    source: Path,
    to: Path,
    task: Task,
    engine: Engine,
    *,
    level: float,
    track: runs.Track = lambda each, _: each,
) -> runs.FleetRun:
    """Have every part of ``source`` examined, and leave a Parquet file for each in ``to``.

    The p-values are as fine as the false discovery ``level`` needs. ``track`` may watch the results
    as they come. Raises as `run_parts`.
    """

    def closer(paths: Mapping[str, Path], read: Mapping[str, str]) -> Mapping[str, str]:
        return _look_closer(to / runs.RESULTS, paths, read, task, engine, level, track)

    def results(parts: Sequence[str]) -> runs.Results:
        return _examined(parts, task, engine, track)

    options = {**asdict(task.reading), **asdict(task.wanted), "seed": task.seed}
    return runs.run_parts(source, to, options, KINDS, results, after=closer)


def _examined(parts: Sequence[str], task: Task, engine: Engine, track: runs.Track) -> runs.Results:
    """Yield the result of each part once all of its pieces are examined."""
    own = engine.shares_of_each(len(parts))
    pieces = [Piece(part, share) for part in parts for share in own]
    found: dict[str, dict[Share, runs.PartResult]] = {part: {} for part in parts}
    for piece, result in track(done_by(engine, partial(examine, task=task), pieces), len(pieces)):
        if piece.path not in found:  # given up
            continue
        if isinstance(result, Exception):
            del found[piece.path]
            yield (piece.path,), result
        else:
            done = found[piece.path]
            done[piece.share] = result
            if len(done) == len(own):
                del found[piece.path]
                yield (piece.path,), [whole_part([done[share] for share in own])]


def examine(piece: Piece, task: Task) -> runs.PartResult:
    """Return what is found of a piece; what cannot be read is said in it, and raises nothing."""
    return runs.result_of(Path(piece.path), partial(_diagnosed, task=task, share=piece.share))


def _diagnosed(path: Path, task: Task, share: Share) -> runs.PartRows:
    tables = tables_in(path, task.reading, share=share)
    rows = [{**_row(table, task), "part": path.name} for table in tables]
    return len(rows), sum("error" in row for row in rows), (runs.rows_as_table(rows, KINDS),)


def _row(table: FleetTable, task: Task) -> runs.Row:
    if isinstance(table.run, ScaraIsoError):
        return _without_result(table, table.run)
    try:
        found = screen(table.run, task.wanted, seed=task.seed)
    except ScaraIsoError as error:
        return _without_result(table, error)
    return {
        "robot": table.robot,
        "test": table.test,
        "cycles": found.cycles,
        "poses": found.poses,
        "verdict": found.verdict.value,
        "p_value": found.p_value,
        "at_floor": found.at_floor,
        "orders": PERMUTATIONS,
        "date": runs.date_of(table.run),
        "name": table.name,
        "effects": ",".join(found.effects),
        **{f"RP_{name}": RP for name, RP in found.RP.items()},
    }


def _without_result(table: FleetTable, error: ScaraIsoError) -> runs.Row:
    nothing = {"cycles": 0, "poses": 0, "at_floor": False, "orders": PERMUTATIONS, "effects": ""}
    return {"robot": table.robot, "test": table.test, **nothing, "error": runs.why(table, error)}


def whole_part(pieces: Sequence[runs.PartResult]) -> runs.PartResult:
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
        rows=tuple(table for one in pieces for table in one.rows),
    )


# ---- finer p-values


PValues: TypeAlias = Mapping[TableName, tuple[float, bool]]
"""The p-values of tables by more orders, and whether each is at its floor."""


def _look_closer(
    results: Path,
    paths: Mapping[str, Path],
    read_before: Mapping[str, str],
    task: Task,
    engine: Engine,
    level: float,
    track: runs.Track,
) -> dict[str, str]:
    """Put finer p-values into the ``results`` where the false discovery ``level`` needs them.

    ``paths`` are the parts and ``read_before`` the SHA-256 of what was read of each. Returns why a
    part was left as it is, by part.
    """
    orders, failed = PERMUTATIONS, dict[str, str]()
    while True:
        needed, behind = _at_floor(results, orders, level)
        if needed <= orders or orders == MOST_ORDERS:
            return failed
        orders = min(needed, MOST_ORDERS)
        behind = {part: names for part, names in behind.items() if part not in failed}
        pieces = [
            Piece(str(paths[part].absolute()), tables=tuple(own))
            for share in engine.shares_of_each(len(behind))
            for part, names in behind.items()
            if (own := share.take(sorted(names)))
        ]
        work = partial(_looked, task=task, orders=orders)
        for piece, look in track(done_by(engine, work, pieces), len(pieces)):
            part = Path(piece.path).name
            if isinstance(look, Exception):
                failed[part] = f"its p-values stay coarse: {type(look).__name__}: {look}"
            elif look[0] != read_before.get(part):
                failed[part] = "has changed since it was read: run it again"
            else:
                _put(results / f"{part}.parquet", look[1], orders)


def _at_floor(results: Path, orders: int, level: float) -> tuple[int, dict[str, set[TableName]]]:
    """Return how many orders name all robots at the floor together, if none comes as far.

    With them the tables, by part, that were compared with no more orders than ``orders``; others
    may have gone on.
    """
    sql = (
        "WITH fleet AS (SELECT *, count(*) OVER (PARTITION BY robot) AS tables FROM fleet "
        "WHERE p_value IS NOT NULL), everything AS (SELECT count(DISTINCT robot) AS robots "
        "FROM fleet) SELECT part, robot, as_read, test, orders, tables, robots FROM fleet, "
        "everything "
        "WHERE orders > ? OR (orders = ? AND at_floor AND p_value <= ?) ORDER BY part"
    )
    with results_in(results) as query:
        rows = query(sql, orders, orders, floor_of(orders) * _ALIKE)
    if not rows:
        return 0, {}
    behind: dict[str, set[TableName]] = {}
    for part, _, as_read, test, so_far, *_ in rows:
        if so_far == orders:
            behind.setdefault(part, set()).add((as_read, test))
    named, robots = {row[1] for row in rows}, rows[0][6]
    share = level * len(named) / (robots * max(row[5] for row in rows))
    return math.ceil(floor_of(0) / share), behind


def _looked(piece: Piece, task: Task, orders: int) -> tuple[str, PValues]:
    """Return the SHA-256 of a part, and the finer p-values of some tables of it."""
    path = Path(piece.path)
    tables = tables_in(path, task.reading, piece.tables)
    found = {
        (table.robot, table.test): finer(table.run, task.wanted, orders, seed=task.seed)
        for table in tables
        if isinstance(table.run, Run)
    }
    return digest(path), found


def _put(path: Path, p_values: PValues, orders: int) -> None:
    """Put p-values, and whether they are at their floor, into a file of results."""
    sql = "UPDATE rows SET p_value = ?, at_floor = ?, orders = ? WHERE robot = ? AND test = ?"
    with workspace(path) as query:
        query("CREATE TABLE rows AS FROM parquet(?)", alone(path))
        for name, found in p_values.items():
            query(sql, *found, orders, *name)
        rows = query("FROM rows").df()
    write_file(path, as_parquet([rows], KINDS))
