"""The figures of one part: RP of every pose, without a diagnosis.

The tables of a Parquet file that are as most are, cycles 1 to n, each once, every reading there,
are added up by DuckDB: eq. 2-6 and ISO 9283 7.2.2 once more, since the same in numpy takes 4 times
as much of the processor (107,526 tables; most of it for sorting and for what Python makes of
names). That holds only where nothing has to be judged: all columns are known. All other tables, and
parts in other forms than Parquet, are read one by one as for a diagnosis.
"""

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from scara_iso.base.errors import DataError, ScaraIsoError
from scara_iso.base.quantities import Dimension, Unit, parse_unit
from scara_iso.diagnosis import CyclesWanted
from scara_iso.fleets import runs
from scara_iso.fleets.database import Query, alone, workspace
from scara_iso.fleets.engines import Engine
from scara_iso.fleets.parts import (
    FleetTable,
    PartFile,
    Share,
    TableName,
    columns_of,
    is_parquet,
    tables_in,
)
from scara_iso.iso9283 import components, repeatability
from scara_iso.run import AXES, FARTHEST, Axis, Run, make_frame

# ruff: noqa: S608 - what is put into the SQL are names and numbers of this module

_WHOLE = ("TINYINT", "SMALLINT", "INTEGER", "BIGINT", "UTINYINT", "USMALLINT", "UINTEGER")
_NUMBERS = (*_WHOLE, "FLOAT", "DOUBLE")
_NAMES = ("VARCHAR", *_WHOLE)
_WITHOUT_INFLUENCE = ("temperature_C", "time_s", "payload_kg", "speed")
"""Columns that change no figure."""
_LONGEST = 10_000
_LOOKED_AT = 1000
"""Rows whose tables show which cycles most tables have."""
_FEWEST_CYCLES = 2
_SMALL, _TOGETHER = 1 << 14, 64
"""Bytes of a part that shares a file of results, and how many do (benchmarks/limits.py)."""
_PLANES: dict[str, tuple[str, ...]] = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}
KINDS = {
    **dict.fromkeys(("robot", "test", "pose"), "VARCHAR"),
    "cycles": "INTEGER",
    **{f"mean_{name}": "DOUBLE" for name in AXES},
    **{f"RP_{name}": "DOUBLE" for name in runs.FIGURES},
    **dict.fromkeys(("date", "name", "error", "part"), "VARCHAR"),
}
"""The columns of the results and their SQL types: a row for each pose [mm, deg]."""


def run_figures(
    source: Path,
    to: Path,
    task: runs.Task,
    engine: Engine,
    *,
    track: runs.Track = lambda each, _: each,
) -> runs.FleetRun:
    """Have the figures of every part of ``source`` as Parquet in ``to``; raises as `run_pieces`."""
    options = {"figures": True, **asdict(task.reading), **asdict(task.wanted)}
    return runs.run_pieces(
        source, to, options, grouped, partial(figures_of, task=task), engine, track
    )


def grouped(parts: Sequence[PartFile]) -> list[runs.Piece]:
    """Return the parts, adjacent small ones together: a file for each is slow.

    Where a group ends is told by a name alone, so another part changes no other group.
    """
    groups: list[list[PartFile]] = []
    together = False
    for part in parts:
        small = part.size < _SMALL and not is_parquet(part.path)
        if not (together and small):
            groups.append([])
        groups[-1].append(part)
        together = small and zlib.crc32(part.path.name.encode()) % _TOGETHER != 0
    return [runs.Piece(tuple(group)) for group in groups]


def figures_of(piece: runs.Piece, task: runs.Task) -> runs.PieceResult:
    """Return the figures of parts; raises as `found_in`."""
    return runs.found_in(piece, task, KINDS, _of_part)


def _of_part(path: Path, task: runs.Task, _: Share) -> runs.PartRows:
    whole, others, together = _together(path, task) if is_parquet(path) else _NONE
    alone = () if others == frozenset() else tables_in(path, task.reading, others)
    rows: list[runs.Row] = [
        {"robot": table.robot, "test": table.test, "part": path.name, **row}
        for table in alone
        for row in _figures_of(table, task.wanted)
    ]
    tables = {(row["robot"], row["test"]) for row in rows}
    failed = sum("error" in row for row in rows)
    return whole + len(tables), failed, (*together, runs.rows_as_table(rows, KINDS))


# ---- one by one


def _figures_of(table: FleetTable, wanted: CyclesWanted) -> list[runs.Row]:
    if isinstance(table.run, ScaraIsoError):
        return [{"cycles": 0, "error": runs.why(table, table.run)}]
    try:
        stated = {"date": runs.date_of(table.run), "name": table.name}
        return [{**row, **stated} for row in _poses(table.run.unwrapped(), wanted)]
    except ScaraIsoError as error:
        return [{"cycles": 0, "error": runs.why(table, error)}]


def _poses(run: Run, wanted: CyclesWanted) -> Iterator[runs.Row]:
    used = wanted.used(run)
    if used.used < _FEWEST_CYCLES:
        raise DataError(
            f"{used.used} cycle counts: no scatter can be computed",
            remedy=f"run {_FEWEST_CYCLES} cycles that count, or more",
        )
    for pose, rows in zip(used.poses, used.rows, strict=True):
        readings = {name: axis.readings[rows] for name, axis in run.axes.items()}
        row: runs.Row = {"pose": pose, "cycles": len(rows)}
        for name, axes in components(run):
            one = repeatability(np.stack([readings[axis] for axis in axes]))
            row |= {f"RP_{name}": float(one.RP)}
            row |= {f"mean_{name}": float(one.mean[0])} if name in readings else {}
        yield row


# ---- together


_Together: TypeAlias = tuple[int, frozenset[TableName] | None, tuple[Any, ...]]
"""How many tables of a part were computed together, which were not (None: all), and their rows."""
_NONE: _Together = (0, None, ())


@dataclass(frozen=True, slots=True)
class _Cycles:
    """The cycles of a table, and the first that counts."""

    first: int
    last: int
    counts_from: int

    @property
    def used(self) -> int:
        return self.last - self.counts_from + 1


def _together(path: Path, task: runs.Task) -> _Together:
    """Return the figures of the tables of a part that are as most are."""
    with workspace(path, task.threads) as query:
        types = columns_of(query, path)
        axes, stated = _axes(types), task.reading.unit
        unit = None if stated is None else parse_unit(stated)
        if not axes or unit is None or unit.dimension is not Dimension.LENGTH:
            return _NONE
        query(f"CREATE TEMP MACRO readings(path) AS TABLE {_readings(types, axes)}")
        where, names = alone(path), [*axes.values()]
        cycles = _cycles(query, where, task.wanted)
        if cycles is None:
            return _NONE
        query(f"CREATE TEMP TABLE means AS {_barycentres(query, names, cycles, unit)}", where)
        if query("FROM means WHERE robot IS NULL OR pose IS NULL LIMIT 1").fetchall():
            return _NONE
        query("CREATE TEMP TABLE odd AS SELECT DISTINCT robot, test FROM means WHERE NOT whole")
        others = frozenset(query("FROM odd").fetchall())
        (tables,) = query("SELECT count(DISTINCT (robot, test)) FROM means").fetchone()
        found = query(_figures(names, cycles, unit), where).df().assign(part=path.name)
    columns = {name: found.get(name) for name in KINDS}
    return tables - len(others), others, (make_frame(columns, {}),)


def _axes(types: Mapping[str, str]) -> dict[str, str]:
    """Return the axes by their columns; none where something has to be judged."""
    by_name = {name.lower(): name for name in types}
    axes = {by_name[name.lower()]: name for name in AXES if name.lower() in by_name}
    names = [name for name in ("robot", "test", "pose") if name in types]
    known = (
        {"robot", "cycle"} <= set(types) <= {*names, "cycle", *axes, *_WITHOUT_INFLUENCE}
        and all(types[name] in _NAMES for name in names)
        and all(types[name] in _NUMBERS for name in axes)
        and types["cycle"] in _WHOLE
    )
    return axes if known else {}


def _readings(types: Mapping[str, str], axes: Mapping[str, str]) -> str:
    """Return the SQL of the rows of a file, with a number for each robot, test and pose."""
    test = "coalesce(test::VARCHAR, '')" if "test" in types else "''"
    pose = "pose::VARCHAR" if "pose" in types else "''"
    readings = ", ".join(f'"{column}"::DOUBLE AS {axis}' for column, axis in axes.items())
    return (
        f"SELECT robot::VARCHAR AS robot, {test} AS test, {pose} AS pose, cycle::BIGINT AS cycle, "
        f"hash(robot::VARCHAR, {test}, {pose}) AS key, {readings} FROM parquet(path)"
    )


def _cycles(query: Query, path: str, wanted: CyclesWanted) -> _Cycles | None:
    """Return the cycles that most tables have, None where they may not count."""
    found = query(
        "SELECT low, high FROM (SELECT min(cycle) AS low, max(cycle) AS high FROM readings($1) "
        f"SEMI JOIN (FROM readings($1) LIMIT {_LOOKED_AT}) USING (key) GROUP BY key) "
        "GROUP BY low, high ORDER BY count(*) DESC, low, high LIMIT 1",
        path,
    ).fetchone()
    first, last = found or (None, None)
    if first is None or last is None or last - first > _LONGEST:
        return None
    numbers = np.arange(first, last + 1)
    try:
        used = wanted.used(Run(numbers, {"X": Axis("X", numbers.astype(np.float64))}))
    except ScaraIsoError:
        return None
    return _Cycles(first, last, int(numbers[used.rows[0][0]])) if used.used > 1 else None


def _barycentres(query: Query, axes: Sequence[str], cycles: _Cycles, unit: Unit) -> str:
    """Return the SQL of the barycentre of each pose, eq. 2, and whether it is as most are.

    It is ``whole`` where every cycle is there once, no reading is absurd and no axis stands still.
    """
    count = cycles.last - cycles.first + 1
    means = ", ".join(
        f"sum(CASE WHEN cycle >= {cycles.counts_from} THEN {a} END) / {cycles.used} AS mean_{a}"
        for a in axes
    )
    ends = cycles.first, cycles.last + 1
    (numbers,) = query("SELECT bit_xor(hash(c)) FROM range(?, ?) r(c)", *ends).fetchone()
    near = " AND ".join(f"abs({a}) < {FARTHEST / unit.to_base(1.0)!r}" for a in axes)
    moves = " AND ".join(f"min({a}) < max({a})" for a in axes)  # a sum of equals is rounded
    return (
        f"SELECT any_value(robot) AS robot, any_value(test) AS test, any_value(pose) AS pose, key, "
        f"{means}, count(*) = {count} AND bit_xor(hash(cycle)) = {numbers} "
        f"AND count(*) FILTER ({near}) = {count} AND {moves} AS whole FROM readings(?) GROUP BY key"
    )


def _planes(axes: Sequence[str]) -> dict[str, tuple[str, ...]]:
    own: dict[str, tuple[str, ...]] = {axis: (axis,) for axis in axes}
    return own | {name: plane for name, plane in _PLANES.items() if set(plane) <= set(axes)}


def _figures(axes: Sequence[str], cycles: _Cycles, unit: Unit) -> str:
    """Return the SQL of barycentre and RP, eq. 3-6, in mm, of the tables that are not odd."""
    apart = ", ".join(f"{axis} - mean_{axis} AS {axis}" for axis in axes)
    lengths = ", ".join(
        f"sqrt({' + '.join(f'{a} * {a}' for a in own)}) AS {name}"
        for name, own in _planes(axes).items()
    )
    in_mm = f"* {unit.numerator!r} / {unit.denominator!r}"
    means = ", ".join(f"mean_{a} {in_mm} AS mean_{a}" for a in axes)
    RP = ", ".join(
        f"(avg({name}) + 3 * stddev_samp({name})) {in_mm} AS RP_{name}" for name in _planes(axes)
    )
    return (
        f"WITH apart AS (SELECT key, {apart} FROM readings(?) JOIN means USING (key) "
        f"WHERE whole AND cycle >= {cycles.counts_from}), "
        f"RP AS (SELECT key, {RP} FROM (SELECT key, {lengths} FROM apart) GROUP BY key) "
        f"SELECT robot, test, nullif(pose, '') AS pose, {cycles.used} AS cycles, robot AS name, "
        f"{means}, RP.* EXCLUDE key FROM means JOIN RP USING (key) "
        "ANTI JOIN odd USING (robot, test)"
    )
