"""The figures of one part: RP of every pose, without a diagnosis.

DuckDB adds up the tables that are as most are: cycles 1 to n, each once, every reading there. RP
needs the barycentre first, so it reads a part twice; the rows never come into this process. All
other tables, and parts in other forms than Parquet, are read one by one as for a diagnosis.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from scara_iso.diagnosis import CyclesWanted
from scara_iso.errors import DataError, ScaraIsoError
from scara_iso.fleets.database import Columns, as_parquet, unnested, workspace
from scara_iso.fleets.dispatch import Engine, done_by
from scara_iso.fleets.parts import FleetTable, ReadAs, columns_of, tables_in
from scara_iso.fleets.runs import FleetRun, Track, run_parts
from scara_iso.fleets.sums import Summed, sum_up
from scara_iso.fleets.work import FIGURES, PartResult, date_of, in_one_line, refused, result_of
from scara_iso.iso9283 import repeatability
from scara_iso.run import AXES, Run

_FEWEST_CYCLES = 2
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
    work = partial(figures_of_part, task=task)
    return run_parts(
        source, to, options, lambda parts: track(done_by(engine, work, parts), len(parts))
    )


def figures_of_part(part: str, task: FiguresTask) -> PartResult:
    """Return the figures of a part; what cannot be read is said in it, and raises nothing."""
    return result_of(Path(part), partial(_made, task=task))


def _made(path: Path, task: FiguresTask) -> tuple[int, int, bytes]:
    with workspace(path, task.threads) as query:
        columns = columns_of(query, path) if path.suffix.lower() == ".parquet" else {}
        summed = sum_up(query, path, columns, task.reading.unit, task.wanted)
        rows = list(_others(path, task, summed))
        sql, parameters = unnested(_columns(rows))
        if summed.figures:
            sql = f"({sql}) UNION ALL BY NAME ({summed.figures})"
        sql = f"SELECT *, ? AS part FROM ({sql})"  # noqa: S608 - names of this package
        made = as_parquet(sql, [path.name, *parameters], query)
    tables = {(row.robot, row.test) for row in rows}
    failed = sum(row.error is not None for row in rows)
    return summed.tables + len(tables), failed, made


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


def _columns(rows: Sequence[FigureRow]) -> Columns:
    def cell(row: FigureRow, name: str) -> object:
        kind, _, figure = name.partition("_")
        return getattr(row, kind).get(figure) if figure else getattr(row, name)

    return {name: (kind, [cell(row, name) for row in rows]) for name, kind in _KINDS.items()}
