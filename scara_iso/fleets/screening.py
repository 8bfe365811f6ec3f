"""Each table of a part diagnosed, by whichever process or machine; and finer p-values.

1,000 orders of its cycles give a table a p-value of 0.001 at best, and a lone ill robot among more
than 47 needs a smaller one. So the tables that none of their orders came as far as are compared
with more orders: with as many as name all of their robots together, if none of these comes as far
either. Some drop out, fewer robots need more orders, and so on until all that are left are named.

The p-values stay valid: below what the orders so far could give, p is that of all orders of a
step (Besag and Clifford 1991), and their number depends on the other tables only.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TypeAlias

from scara_iso.base.errors import ScaraIsoError
from scara_iso.base.files import write_file
from scara_iso.diagnosis import PERMUTATIONS, finer, floor_of, screen
from scara_iso.fleets import runs
from scara_iso.fleets.database import alone, as_parquet, results_in, workspace
from scara_iso.fleets.engines import Engine, done_by
from scara_iso.fleets.parts import FleetTable, PartFile, Share, TableName, tables_in
from scara_iso.run import Run

MOST_ORDERS = 250_000
"""Enough for a lone ill robot among 11,000; minutes of one core for a table."""
_ALIKE = 1 + 1e-9
_SHARE, _SHARES = 1 << 15, 16
"""Bytes of a part that are worked on at once, and how often a part is read at most for that."""
_AT_ONCE = 4
"""Tables that are compared with more orders at once."""
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


def run_fleet(
    source: Path,
    to: Path,
    task: runs.Task,
    engine: Engine,
    *,
    level: float,
    track: runs.Track = lambda each, _: each,
) -> runs.FleetRun:
    """Have every part of ``source`` examined, and leave its results as Parquet in ``to``.

    The p-values are as fine as the false discovery ``level`` needs. ``track`` may watch the results
    as they come. Raises as `run_pieces`.
    """
    options = {**asdict(task.reading), **asdict(task.wanted), "seed": task.seed}
    work = partial(examine, task=task)
    closer = partial(_look_closer, to, task=task, engine=engine, level=level, track=track)
    return runs.run_pieces(source, to, options, in_shares, work, engine, track, after=closer)


def in_shares(parts: Sequence[PartFile]) -> list[runs.Piece]:
    """Return parts in shares that are worked on at once, so that no process waits long."""
    counts = [min(math.ceil(part.size / _SHARE), _SHARES) or 1 for part in parts]
    return [
        runs.Piece((part,), (number, count))
        for part, count in zip(parts, counts, strict=True)
        for number in range(count)
    ]


def examine(piece: runs.Piece, task: runs.Task) -> runs.PieceResult:
    """Return what is found of a piece; raises as `found_in`."""
    return runs.found_in(piece, task, KINDS, _diagnosed)


def _diagnosed(path: Path, task: runs.Task, share: Share) -> runs.PartRows:
    tables = tables_in(path, task.reading, share=share)
    rows = [{**_row(table, task), "part": path.name} for table in tables]
    return len(rows), sum("error" in row for row in rows), (runs.rows_as_table(rows, KINDS),)


def _row(table: FleetTable, task: runs.Task) -> runs.Row:
    own: runs.Row = {"robot": table.robot, "test": table.test, "orders": PERMUTATIONS}
    try:
        if isinstance(table.run, ScaraIsoError):
            raise table.run
        found = screen(table.run, task.wanted, seed=task.seed)
    except ScaraIsoError as error:
        nothing = {"cycles": 0, "poses": 0, "at_floor": False, "effects": ""}
        return own | nothing | {"error": runs.why(table, error)}
    return own | {
        "cycles": found.cycles,
        "poses": found.poses,
        "verdict": found.verdict.value,
        "p_value": found.p_value,
        "at_floor": found.at_floor,
        "date": runs.date_of(table.run),
        "name": table.name,
        "effects": ",".join(found.effects),
        **{f"RP_{name}": RP for name, RP in found.RP.items()},
    }


# ---- finer p-values


PValues: TypeAlias = Mapping[TableName, tuple[float, bool]]
"""The p-values of tables by more orders, and whether each is at its floor."""


_Look: TypeAlias = tuple[runs.Piece, tuple[TableName, ...]]
"""Some tables of a piece."""


def _look_closer(
    to: Path,
    pieces: Mapping[str, runs.Piece],
    task: runs.Task,
    engine: Engine,
    level: float,
    track: runs.Track,
) -> dict[str, str]:
    """Put finer p-values into the results in ``to`` where the false discovery ``level`` needs them.

    Returns why a part was left as it is, by part.
    """
    orders, failed = PERMUTATIONS, dict[str, str]()
    while True:
        needed, behind = _at_floor(to / runs.RESULTS, orders, level)
        if needed <= orders or orders == MOST_ORDERS:
            return failed
        orders = min(needed, MOST_ORDERS)
        looks: list[_Look] = [
            (pieces[name], tuple(tables[first : first + _AT_ONCE]))
            for name, tables in behind.items()
            if pieces[name].parts[0].path.name not in failed
            for first in range(0, len(tables), _AT_ONCE)
        ]
        work = partial(_looked, task=task, orders=orders)
        for (piece, _), found in track(done_by(engine, work, looks), len(looks)):
            if isinstance(found, Exception):
                part = piece.parts[0].path.name
                failed[part] = f"its p-values stay coarse: {runs.given_up(found)}"
            else:
                _put(runs.result_path(to, piece.name), found, orders)


def _at_floor(results: Path, orders: int, level: float) -> tuple[int, dict[str, list[TableName]]]:
    """Return how many orders name all robots at the floor together, if none comes as far.

    With them the tables, by the name of their result, that were compared with no more orders than
    ``orders``; others may have gone on.
    """
    sql = (
        "WITH fleet AS (SELECT *, count(*) OVER (PARTITION BY robot) AS tables FROM fleet "
        "WHERE p_value IS NOT NULL), everything AS (SELECT count(DISTINCT robot) AS robots "
        "FROM fleet) SELECT filename, robot, as_read, test, orders, tables, robots FROM fleet, "
        "everything WHERE orders > ? OR (orders = ? AND at_floor AND p_value <= ?) ORDER BY ALL"
    )
    with results_in(results) as query:
        rows = query(sql, orders, orders, floor_of(orders) * _ALIKE)
    if not rows:
        return 0, {}
    behind: dict[str, list[TableName]] = {}
    for file, _, as_read, test, so_far, *_ in rows:
        if so_far == orders:
            behind.setdefault(Path(file).stem, []).append((as_read, test))
    named, robots = {row[1] for row in rows}, rows[0][6]
    share = level * len(named) / (robots * max(row[5] for row in rows))
    return math.ceil(floor_of(0) / share), behind


def _looked(look: _Look, task: runs.Task, orders: int) -> PValues:
    """Return the finer p-values of some tables; raises as `check_unchanged`."""
    piece, names = look
    runs.check_unchanged(piece, task)
    tables = tables_in(piece.parts[0].path, task.reading, names)
    return {
        (table.robot, table.test): finer(table.run, task.wanted, orders, seed=task.seed)
        for table in tables
        if isinstance(table.run, Run)
    }


def _put(path: Path, p_values: PValues, orders: int) -> None:
    sql = "UPDATE rows SET p_value = ?, at_floor = ?, orders = ? WHERE robot = ? AND test = ?"
    with workspace(path) as query:
        query("CREATE TABLE rows AS FROM parquet(?)", alone(path))
        for name, found in p_values.items():
            query(sql, *found, orders, *name)
        rows = query("FROM rows").df()
    write_file(path, as_parquet([rows], KINDS))
