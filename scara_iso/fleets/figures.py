"""The figures of one part: RP of every pose, without a diagnosis.

DuckDB adds up the tables that are as most are: cycles 1 to n, each once, every reading there. RP
needs the barycentre first, so it reads a part twice; the rows never come into this process. All
other tables, and parts in other forms than Parquet, are read one by one as for a diagnosis.

RP of the tables of a Parquet file, added up by DuckDB: eq. 2-6 and ISO 9283 7.2.2.

Only where nothing has to be judged: all columns are known, and the cycles of a table are those of
most, each once. In which order its rows stand does not matter then. The rest is left to others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from scara_iso.base.errors import DataError, ScaraIsoError
from scara_iso.base.quantities import Dimension, Unit, parse_unit
from scara_iso.diagnosis import CyclesWanted
from scara_iso.fleets.database import Columns, Query, alone, as_parquet, unnested, workspace
from scara_iso.fleets.parts import FleetTable, ReadAs, TableName, columns_of, tables_in
from scara_iso.fleets.runs import FleetRun, Results, Track, run_parts
from scara_iso.fleets.work import (
    FIGURES,
    Engine,
    PartResult,
    date_of,
    done_by,
    in_one_line,
    refused,
    result_of,
)
from scara_iso.iso9283 import repeatability
from scara_iso.run import AXES, FARTHEST, Axis, Run

# ruff: noqa: S608 - what is put into the SQL are names and numbers of this module


_WHOLE = ("TINYINT", "SMALLINT", "INTEGER", "BIGINT", "UTINYINT", "USMALLINT", "UINTEGER")
_NUMBERS = (*_WHOLE, "FLOAT", "DOUBLE")
_NAMES = ("VARCHAR", *_WHOLE)
_BESIDE = ("temperature_C", "time_s", "payload_kg", "speed")
"""Columns that change no figure."""
_LOOKED_AT = 1000
"""Rows whose tables show which cycles most tables have."""
_LONGEST = 10_000
_NEAR = 1.0
"""[mm] of a mean: below, its rounding is less than 1e-12 of the scatter that a dial shows."""
_EVEN = 1e-3
"""Share of S_l in the mean square of a distance below which too many of its digits are lost."""


@dataclass(frozen=True, slots=True)
class Summed:
    """What was summed up of a part."""

    tables: int = 0
    left: frozenset[TableName] | None = None
    """The tables that were not; None for all."""
    figures: str = ""
    """The SQL that gives the figures of the others, a row for each pose."""


@dataclass(frozen=True, slots=True)
class _Cycles:
    """The cycles of a table, and the first that counts."""

    first: int
    last: int
    counts_from: int

    @property
    def used(self) -> int:
        return self.last - self.counts_from + 1


@dataclass(frozen=True, slots=True)
class _Part:
    """What is added up: rows as SQL, their axes by the name in the file, their unit and cycles."""

    rows: str
    path: str
    axes: tuple[str, ...]
    unit: Unit
    cycles: _Cycles


def sum_up(
    query: Query, path: Path, columns: Mapping[str, str], unit: str | None, wanted: CyclesWanted
) -> Summed:
    """Return the figures of what can be summed up in a Parquet file of such ``columns``."""
    part = _part(query, path, columns, unit, wanted)
    if part is None:
        return Summed()
    _barycentres(query, part)
    if query("SELECT 1 FROM means WHERE robot IS NULL OR pose IS NULL LIMIT 1"):
        return Summed()
    _distances(query, part, far=_far(query, part))
    query(
        "CREATE TEMP TABLE odd AS SELECT DISTINCT robot, test FROM means "
        "LEFT JOIN sums USING (key) WHERE NOT whole OR sound IS NOT TRUE"
    )
    left = frozenset(query("SELECT robot, test FROM odd"))
    (tables,) = query("SELECT count(DISTINCT (robot, test)) FROM means")[0]
    return Summed(tables - len(left), left, _figures(part))


def _part(
    query: Query, path: Path, columns: Mapping[str, str], unit: str | None, wanted: CyclesWanted
) -> _Part | None:
    by_name = {name.lower(): name for name in columns}
    axes = {name: by_name[name.lower()] for name in AXES if name.lower() in by_name}
    names = [name for name in ("robot", "test", "pose") if name in columns]
    known = {*names, "cycle", *axes.values(), *_BESIDE}
    size = None if unit is None else parse_unit(unit)
    if (
        not axes
        or not {"robot", "cycle"} <= set(columns) <= known
        or any(columns[name] not in _NAMES for name in names)
        or any(columns[name] not in _NUMBERS for name in axes.values())
        or columns["cycle"] not in _WHOLE
        or size is None
        or size.dimension is not Dimension.LENGTH
    ):
        return None
    rows = _rows(columns, axes)
    cycles = _cycles(query, rows, alone(path), wanted)
    return None if cycles is None else _Part(rows, alone(path), tuple(axes), size, cycles)


def _rows(columns: Mapping[str, str], axes: Mapping[str, str]) -> str:
    test = "coalesce(test::VARCHAR, '')" if "test" in columns else "''"
    pose = "pose::VARCHAR" if "pose" in columns else "''"
    readings = ", ".join(f'"{name}"::DOUBLE AS {axis}' for axis, name in axes.items())
    return (
        f"(SELECT robot::VARCHAR AS robot, {test} AS test, {pose} AS pose, "
        f"cycle::BIGINT AS cycle, {readings} FROM parquet(?))"
    )


def _cycles(query: Query, rows: str, path: str, wanted: CyclesWanted) -> _Cycles | None:
    """Return the cycles that most tables have, None where they may not count."""
    found = query(
        f"SELECT low, high FROM (SELECT min(cycle) AS low, max(cycle) AS high "
        f"FROM {rows} SEMI JOIN (FROM {rows} LIMIT {_LOOKED_AT}) USING (robot, test, pose) "
        "GROUP BY robot, test, pose) "
        "GROUP BY low, high ORDER BY count(*) DESC, low, high LIMIT 1",
        path,
        path,
    )
    if not found or None in found[0] or found[0][1] - found[0][0] > _LONGEST:
        return None
    low, high = found[0]
    numbers = np.arange(low, high + 1)
    try:
        used = wanted.used(Run(numbers, {"X": Axis("X", numbers.astype(np.float64))}))
    except ScaraIsoError:
        return None
    return _Cycles(low, high, int(numbers[used.rows[0][0]])) if used.used > 1 else None


def _barycentres(query: Query, part: _Part) -> None:
    """Make the table ``means``, with whether each table is as most are; eq. 2."""
    cycles, axes = part.cycles, part.axes
    count = cycles.last - cycles.first + 1
    counted = "{0}"
    if cycles.counts_from > cycles.first:
        counted = f"CASE WHEN cycle >= {cycles.counts_from} THEN {{0}} END"
    means = ", ".join(f"sum({counted.format(a)}) / {cycles.used} AS mean_{a}" for a in axes)
    there = f"count({' + '.join(axes)}) = {count}"
    (numbers,) = query(
        "SELECT bit_xor(hash(c)) FROM range(?, ?) r(c)", cycles.first, cycles.last + 1
    )[0]
    query(
        f"CREATE TEMP TABLE means AS SELECT robot, test, pose, hash(robot, test, pose) AS key, "
        f"coalesce(count(*) = {count} AND bit_xor(hash(cycle)) = {numbers} AND {there}, false) "
        f"AS whole, {means} FROM {part.rows} GROUP BY robot, test, pose",
        part.path,
    )


def _far(query: Query, part: _Part) -> bool:
    """Say whether digits of the means are lost; then give ``means`` what is left of each."""
    far = " OR ".join(f"abs(mean_{a}) > {_NEAR / part.unit.to_base(1.0)!r}" for a in part.axes)
    if not query(f"SELECT 1 FROM means WHERE whole AND ({far}) LIMIT 1"):
        return False
    rest = ", ".join(f"avg({axis} - mean_{axis}) AS rest_{axis}" for axis in part.axes)
    query(
        f"CREATE OR REPLACE TEMP TABLE means AS FROM means LEFT JOIN "
        f"(SELECT key, {rest} FROM {_own(part)} GROUP BY key) USING (key)",
        part.path,
    )
    return True


def _own(part: _Part) -> str:
    """Return the rows that count of the tables that are as most, beside their barycentres."""
    readings = ", ".join(part.axes)
    return (
        f"(SELECT hash(robot, test, pose) AS key, {readings} FROM {part.rows} "
        f"WHERE cycle >= {part.cycles.counts_from}) JOIN (FROM means WHERE whole) USING (key)"
    )


def _distances(query: Query, part: _Part, *, far: bool) -> None:
    """Make the table ``sums``: of the distances to the barycentre, and of their squares; eq. 3."""
    n, axes = part.cycles.used, part.axes
    rest = " - rest_{0}" if far else ""
    from_mean = ", ".join(f"{a} - mean_{a}{rest.format(a)} AS {a}" for a in axes)
    squares = {axis: f"{axis} * {axis}" for axis in axes}
    for plane in ("XY", "XYZ"):
        if set(plane) <= set(axes):
            squares[plane] = " + ".join(squares[axis] for axis in plane)
    sums = ", ".join(
        f"sum(sqrt({square})) AS l_{name}, sum({square}) AS ll_{name}"
        for name, square in squares.items()
    )
    sound = " AND ".join(
        f"ll_{f} - l_{f} * l_{f} / {n} > {_EVEN} * ll_{f} AND isfinite(ll_{f})" for f in squares
    )
    near = " AND ".join(f"abs(mean_{axis}) < {FARTHEST / 10!r}" for axis in axes)
    RP = ", ".join(
        f"l_{f} / {n} + 3 * sqrt(greatest(ll_{f} - l_{f} * l_{f} / {n}, 0) / {n - 1}) AS RP_{f}"
        for f in squares
    )
    query(
        f"CREATE TEMP TABLE sums AS SELECT key, {RP}, {sound} AS sound FROM ("
        f"SELECT key, {sums} FROM (SELECT key, {from_mean} FROM {_own(part)}) GROUP BY key)",
        part.path,
    )
    query(f"UPDATE sums SET sound = false FROM means WHERE means.key = sums.key AND NOT ({near})")


def _figures(part: _Part) -> str:
    """Return the SQL of the figures of the tables that are not odd, in mm."""
    planes = [plane for plane in ("XY", "XYZ") if set(plane) <= set(part.axes)]
    names = [*(f"mean_{a}" for a in part.axes), *(f"RP_{f}" for f in (*part.axes, *planes))]
    unit = part.unit
    figures = ", ".join(
        f"{name} * {unit.numerator!r} / {unit.denominator!r} AS {name}" for name in names
    )
    return (
        f"SELECT robot, test, nullif(pose, '') AS pose, {part.cycles.used} AS cycles, {figures}, "
        "robot AS name "
        "FROM means JOIN sums USING (key) ANTI JOIN odd USING (robot, test)"
    )


_FEWEST_CYCLES = 2
_SHARED = 1 << 20
"""Bytes of parts that share a file of results (benchmarks/limits.py)."""
_PLANES = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}


@dataclass(frozen=True, slots=True)
class FiguresTask:
    """What is to be done with every part; ``threads`` of DuckDB."""

    reading: ReadAs
    wanted: CyclesWanted
    threads: int = 1


@dataclass(frozen=True, slots=True)
class FigureRow:
    """The figures of one pose of a table [mm, deg], or why there are none of the table."""

    robot: str
    test: str
    pose: str | None = None
    cycles: int = 0
    mean: Mapping[str, float] = field(default_factory=dict)
    RP: Mapping[str, float] = field(default_factory=dict)
    date: str | None = None
    name: str | None = None
    """Of the robot, as the table states it."""
    error: str | None = None


def run_figures(
    source: Path,
    to: Path,
    task: FiguresTask,
    engine: Engine,
    *,
    track: Track = lambda each, _: each,
) -> FleetRun:
    """Have the figures of every part of ``source`` in a Parquet file of its own in ``to``.

    Raises as `run_parts`.
    """
    options = {"figures": True, **asdict(task.reading), **asdict(task.wanted)}
    work = partial(figures_of, task=task)

    def results(parts: Sequence[str]) -> Results:
        together = _together(parts)
        done = track(done_by(engine, work, together), len(together))
        broken = []
        for some, found in done:
            if isinstance(found, Exception) and len(some) > 1:
                broken += [(part,) for part in some]
            else:
                yield some, found
        yield from done_by(engine, work, broken)

    return run_parts(source, to, options, results)


def _together(parts: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the parts, small ones of text beside each other together: a file for each is slow."""
    found: list[tuple[str, ...]] = []
    room = 0
    for part in parts:
        size = _SHARED + 1 if _is_parquet(part) else _size(part)
        if size > room:
            found.append(())
            room = _SHARED
        found[-1] += (part,)
        room -= size
    return found


def _size(part: str) -> int:
    try:
        return Path(part).stat().st_size
    except OSError:
        return 0  # what is wrong with it is said where it is read


def _is_parquet(part: str) -> bool:
    return part.lower().endswith(".parquet")


def figures_of(parts: Sequence[str], task: FiguresTask) -> list[PartResult]:
    """Return the figures of parts, those of all with the first; of a Parquet file alone.

    What cannot be read is said in them, and raises nothing.
    """
    if _is_parquet(parts[0]):
        return [result_of(Path(parts[0]), partial(_summed, task=task))]
    rows: list[tuple[str, FigureRow]] = []
    found = [result_of(Path(part), partial(_read, task=task, rows=rows)) for part in parts]
    made = as_parquet(*unnested(_columns(rows))) if rows else b""
    return [replace(found[0], parquet=made), *found[1:]]


def _read(
    path: Path, task: FiguresTask, rows: list[tuple[str, FigureRow]]
) -> tuple[int, int, bytes]:
    own = list(_others(path, task, Summed()))
    rows += [(path.name, row) for row in own]
    return *_counted(own), b""


def _summed(path: Path, task: FiguresTask) -> tuple[int, int, bytes]:
    with workspace(path, task.threads) as query:
        columns = columns_of(query, path)
        summed = sum_up(query, path, columns, task.reading.unit, task.wanted)
        rows = list(_others(path, task, summed))
        sql, parameters = unnested(_columns([(path.name, row) for row in rows]))
        if summed.figures:
            figures = f"SELECT *, ? AS part FROM ({summed.figures})"
            sql = f"({sql}) UNION ALL BY NAME ({figures})"
        made = as_parquet(sql, [*parameters, *[path.name] * bool(summed.figures)], query)
    tables, failed = _counted(rows)
    return summed.tables + tables, failed, made


def _counted(rows: Sequence[FigureRow]) -> tuple[int, int]:
    tables = {(row.robot, row.test) for row in rows}
    return len(tables), sum(row.error is not None for row in rows)


def _others(path: Path, task: FiguresTask, summed: Summed) -> Iterator[FigureRow]:
    """Yield the figures of the tables that were not summed up."""
    if summed.left is None or summed.left:
        for table in tables_in(path, task.reading, summed.left):
            yield from _figures_of(table, task.wanted)


def _figures_of(table: FleetTable, wanted: CyclesWanted) -> list[FigureRow]:
    if isinstance(table.run, ScaraIsoError):
        return [FigureRow(table.robot, table.test, error=in_one_line(table.run))]
    try:
        return list(_poses(table, table.run.unwrapped(), wanted))
    except ScaraIsoError as error:
        return [FigureRow(table.robot, table.test, error=refused(error, table.run))]


def _poses(table: FleetTable, run: Run, wanted: CyclesWanted) -> Iterator[FigureRow]:
    used = wanted.used(run)
    if used.used < _FEWEST_CYCLES:
        raise DataError(
            f"{used.used} cycle counts: no scatter can be computed",
            remedy=f"run {_FEWEST_CYCLES} cycles that count, or more",
        )
    lengths = {name for name, axis in run.axes.items() if axis.unit == "mm"}
    planes = {name: own for name, own in _PLANES.items() if lengths >= set(own)}
    for pose, rows in zip(used.poses, used.rows, strict=True):
        readings = {name: axis.readings[rows] for name, axis in run.axes.items()}
        figures = {name: (name,) for name in readings} | planes
        found = {
            name: repeatability(np.stack([readings[axis] for axis in axes]))
            for name, axes in figures.items()
        }
        yield FigureRow(
            robot=table.robot,
            test=table.test,
            pose=pose,
            cycles=len(rows),
            mean={name: float(found[name].mean[0]) for name in readings},
            RP={name: float(one.RP) for name, one in found.items()},
            date=date_of(run),
            name=table.name,
        )


_KINDS = {
    **dict.fromkeys(("robot", "test", "pose"), "VARCHAR"),
    "cycles": "INTEGER",
    **{f"mean_{name}": "DOUBLE" for name in AXES},
    **{f"RP_{name}": "DOUBLE" for name in FIGURES},
    "date": "VARCHAR",
    "name": "VARCHAR",
    "error": "VARCHAR",
}


def _columns(rows: Sequence[tuple[str, FigureRow]]) -> Columns:
    def cell(row: FigureRow, name: str) -> object:
        kind, _, figure = name.partition("_")
        return getattr(row, kind).get(figure) if figure else getattr(row, name)

    own = {name: (kind, [cell(row, name) for _, row in rows]) for name, kind in _KINDS.items()}
    return {**own, "part": ("VARCHAR", [part for part, _ in rows])}
