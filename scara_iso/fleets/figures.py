"""The figures of one part: RP of every pose, without a diagnosis.

The tables of a Parquet file that are as most are, cycles 1 to n, each once, every reading there,
are added up by DuckDB: eq. 2-6 and ISO 9283 7.2.2 once more, since the same in numpy takes 4 times
as much of the processor (107,526 tables; most of it for sorting and for what Python makes of
names). That holds only where nothing has to be judged: all columns are known. All other tables, and
parts in other forms than Parquet, are read one by one as for a diagnosis.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from scara_iso.base.errors import DataError, ScaraIsoError
from scara_iso.base.quantities import Dimension, Unit, parse_unit
from scara_iso.diagnosis import CyclesWanted
from scara_iso.fleets import runs
from scara_iso.fleets.database import Query, alone, workspace
from scara_iso.fleets.engines import Engine, done_by
from scara_iso.fleets.parts import (
    FleetTable,
    ReadAs,
    TableName,
    columns_of,
    is_parquet,
    tables_in,
)
from scara_iso.iso9283 import repeatability
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
_EVEN = 1e-3
"""Share of S_l in the mean square of a distance below which too many of its digits are lost."""
_FEWEST_CYCLES = 2
_SHARED = 1 << 20
"""Bytes of parts that share a file of results (benchmarks/limits.py)."""
_PLANES: dict[str, tuple[str, ...]] = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}
KINDS = {
    **dict.fromkeys(("robot", "test", "pose"), "VARCHAR"),
    "cycles": "INTEGER",
    **{f"mean_{name}": "DOUBLE" for name in AXES},
    **{f"RP_{name}": "DOUBLE" for name in runs.FIGURES},
    **dict.fromkeys(("date", "name", "error", "part"), "VARCHAR"),
}
"""The columns of the results and their SQL types: a row for each pose [mm, deg]."""


@dataclass(frozen=True, slots=True)
class FiguresTask:
    """What is to be done with every part; ``threads`` of DuckDB."""

    reading: ReadAs
    wanted: CyclesWanted
    threads: int = 1


def run_figures(
    source: Path,
    to: Path,
    task: FiguresTask,
    engine: Engine,
    *,
    track: runs.Track = lambda each, _: each,
) -> runs.FleetRun:
    """Have the figures of every part of ``source`` in a Parquet file of its own in ``to``.

    Raises as `run_parts`.
    """
    options = {"figures": True, **asdict(task.reading), **asdict(task.wanted)}
    work = partial(figures_of, task=task)

    def results(parts: Sequence[str]) -> runs.Results:
        groups = _grouped(parts)
        broken = []
        for group, found in track(done_by(engine, work, groups), len(groups)):
            if isinstance(found, Exception) and len(group) > 1:
                broken += [(part,) for part in group]
            else:
                yield group, found
        yield from done_by(engine, work, broken)

    return runs.run_parts(source, to, options, KINDS, results)


def _grouped(parts: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the parts, adjacent small ones of text together: a file for each is slow."""
    found: list[tuple[str, ...]] = []
    room = 0
    for part in parts:
        size = _SHARED + 1 if is_parquet(Path(part)) else _size(part)
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


def figures_of(parts: Sequence[str], task: FiguresTask) -> list[runs.PartResult]:
    """Return the figures of parts, the rows of all with one of them; of a Parquet file alone.

    What cannot be read is said in them, and raises nothing.
    """
    if is_parquet(Path(parts[0])):
        return [runs.result_of(Path(parts[0]), partial(_of_parquet, task=task))]
    rows: list[runs.Row] = []
    found = [runs.result_of(Path(part), partial(_of_text, task=task, rows=rows)) for part in parts]
    holder = next((k for k, one in enumerate(found) if one.tables), None)
    if holder is not None:
        found[holder] = replace(found[holder], rows=(runs.rows_as_table(rows, KINDS),))
    return found


def _of_text(path: Path, task: FiguresTask, rows: list[runs.Row]) -> runs.PartRows:
    own = list(_one_by_one(path, task, None))
    rows += own
    return *_counted(own), ()


def _of_parquet(path: Path, task: FiguresTask) -> runs.PartRows:
    whole, others, together = _together(path, task)
    rows = list(_one_by_one(path, task, others))
    tables, failed = _counted(rows)
    return whole + tables, failed, (*together, runs.rows_as_table(rows, KINDS))


def _counted(rows: Sequence[runs.Row]) -> tuple[int, int]:
    tables = {(row["robot"], row["test"]) for row in rows}
    return len(tables), sum("error" in row for row in rows)


# ---- one by one


def _one_by_one(
    path: Path, task: FiguresTask, only: frozenset[TableName] | None
) -> Iterator[runs.Row]:
    """Yield the figures of the tables of a part, ``only`` some."""
    if only is not None and not only:
        return
    for table in tables_in(path, task.reading, only):
        own = {"robot": table.robot, "test": table.test, "part": path.name}
        yield from ({**own, **row} for row in _figures_of(table, task.wanted))


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
    lengths = [name for name, axis in run.axes.items() if axis.unit == "mm"]
    figures: dict[str, tuple[str, ...]] = {name: (name,) for name in run.axes}
    figures |= _planes(lengths)
    for pose, rows in zip(used.poses, used.rows, strict=True):
        readings = {name: axis.readings[rows] for name, axis in run.axes.items()}
        row: runs.Row = {"pose": pose, "cycles": len(rows)}
        for name, axes in figures.items():
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


def _together(path: Path, task: FiguresTask) -> _Together:
    """Return the figures of the tables of a part that are as most are."""
    with workspace(path, task.threads) as query:
        types = columns_of(query, path)
        axes, unit = _axes(types), _length(task.reading.unit)
        if not axes or unit is None:
            return _NONE
        rows, where = _rows(types, axes), alone(path)
        cycles = _cycles(query, rows, where, task.wanted)
        if cycles is None:
            return _NONE
        names = tuple(axes.values())
        query(f"CREATE TEMP TABLE means AS {_barycentres(query, rows, names, cycles)}", where)
        if query("FROM means WHERE robot IS NULL OR pose IS NULL LIMIT 1").fetchall():
            return _NONE
        query(f"CREATE TEMP TABLE sums AS {_distances(rows, names, cycles, unit)}", where)
        query(
            "CREATE TEMP TABLE odd AS SELECT DISTINCT robot, test FROM means "
            "LEFT JOIN sums USING (key) WHERE NOT whole OR sound IS NOT TRUE"
        )
        others = frozenset(query("FROM odd").fetchall())
        (tables,) = query("SELECT count(DISTINCT (robot, test)) FROM means").fetchone()
        found = query(_selected(names, cycles, unit)).df().assign(part=path.name)
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


def _length(unit: str | None) -> Unit | None:
    found = None if unit is None else parse_unit(unit)
    return found if found is not None and found.dimension is Dimension.LENGTH else None


def _rows(types: Mapping[str, str], axes: Mapping[str, str]) -> str:
    test = "coalesce(test::VARCHAR, '')" if "test" in types else "''"
    pose = "pose::VARCHAR" if "pose" in types else "''"
    readings = ", ".join(f'"{column}"::DOUBLE AS {axis}' for column, axis in axes.items())
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


def _barycentres(query: Query, rows: str, axes: Sequence[str], cycles: _Cycles) -> str:
    """Return the SQL of the barycentre of each pose, and whether it is as most are; eq. 2."""
    count = cycles.last - cycles.first + 1
    means = ", ".join(
        f"sum(CASE WHEN cycle >= {cycles.counts_from} THEN {a} END) / {cycles.used} AS mean_{a}"
        for a in axes
    )
    ends = cycles.first, cycles.last + 1
    (numbers,) = query("SELECT bit_xor(hash(c)) FROM range(?, ?) r(c)", *ends).fetchone()
    return (
        f"SELECT robot, test, pose, hash(robot, test, pose) AS key, {means}, "
        f"coalesce(count(*) = {count} AND bit_xor(hash(cycle)) = {numbers} "
        f"AND count({' + '.join(axes)}) = {count}, false) AS whole "
        f"FROM {rows} GROUP BY robot, test, pose"
    )


def _planes(axes: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the axes of each figure."""
    own: dict[str, tuple[str, ...]] = {axis: (axis,) for axis in axes}
    return own | {name: plane for name, plane in _PLANES.items() if set(plane) <= set(axes)}


def _distances(rows: str, axes: Sequence[str], cycles: _Cycles, unit: Unit) -> str:
    """Return the SQL of RP by the sums of the distances to the barycentre and their squares.

    Eq. 3-6. It is ``sound`` where few digits are lost, and no reading is absurd.
    """
    n, figures = cycles.used, _planes(axes)
    apart = ", ".join(f"{axis} - mean_{axis} AS {axis}" for axis in axes)
    squares = {name: " + ".join(f"{a} * {a}" for a in own) for name, own in figures.items()}
    sums = ", ".join(
        f"sum(sqrt({square})) AS l_{name}, sum({square}) AS ll_{name}"
        for name, square in squares.items()
    )
    spread = {name: f"ll_{name} - l_{name} * l_{name} / {n}" for name in figures}
    sound = " AND ".join(
        f"{spread[name]} > {_EVEN} * ll_{name} AND ll_{name} < {FARTHEST!r}" for name in figures
    )
    RP = ", ".join(
        f"l_{name} / {n} + 3 * sqrt(greatest({spread[name]}, 0) / {n - 1}) AS RP_{name}"
        for name in figures
    )
    near = " AND ".join(f"abs(mean_{a}) < {FARTHEST / unit.to_base(10.0)!r}" for a in axes)
    return (
        f"SELECT key, {RP}, {sound} AS sound FROM (SELECT key, {sums} FROM (SELECT key, {apart} "
        f"FROM (SELECT *, hash(robot, test, pose) AS key FROM {rows} "
        f"WHERE cycle >= {cycles.counts_from}) "
        f"JOIN (SELECT * EXCLUDE (robot, test, pose) FROM means WHERE whole AND {near}) "
        "USING (key)) GROUP BY key)"
    )


def _selected(axes: Sequence[str], cycles: _Cycles, unit: Unit) -> str:
    """Return the SQL of the figures of the tables that are not odd, in mm."""
    names = [*(f"mean_{axis}" for axis in axes), *(f"RP_{name}" for name in _planes(axes))]
    sizes = ", ".join(f"{n} * {unit.numerator!r} / {unit.denominator!r} AS {n}" for n in names)
    return (
        f"SELECT robot, test, nullif(pose, '') AS pose, {cycles.used} AS cycles, {sizes}, "
        "robot AS name FROM means JOIN sums USING (key) ANTI JOIN odd USING (robot, test)"
    )
