"""The figures of one part: RP of every pose, without a diagnosis.

DuckDB adds up the tables that are as most are: cycles 1 to n, each once, every reading there. RP
needs the barycentre first, so it reads a part twice; the rows never come into this process. All
other tables, and parts in other forms than Parquet, are read one by one as for a diagnosis.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from scara_iso.diagnosis import CyclesWanted
from scara_iso.errors import DataError, ScaraIsoError
from scara_iso.fleets.database import Columns, as_parquet, unnested, workspace
from scara_iso.fleets.dispatch import Engine, done_by
from scara_iso.fleets.parts import FleetTable, ReadAs, columns_of, tables_in
from scara_iso.fleets.runs import FleetRun, Results, Track, run_parts
from scara_iso.fleets.sums import Summed, sum_up
from scara_iso.fleets.work import FIGURES, PartResult, date_of, in_one_line, refused, result_of
from scara_iso.iso9283 import repeatability
from scara_iso.run import AXES, Run

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
            figures = f"SELECT *, ? AS part FROM ({summed.figures})"  # noqa: S608 - of this package
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
