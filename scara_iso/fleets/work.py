"""What is done with a piece of a part, by whichever process or machine: each table is diagnosed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from scara_iso.diagnosis import PERMUTATIONS, SEED, CyclesWanted, screen
from scara_iso.errors import ScaraIsoError, WriteError
from scara_iso.fleets.database import Columns, as_parquet, joined_parquet, unnested
from scara_iso.fleets.parts import FleetTable, ReadAs, digest, tables_in
from scara_iso.fleets.pieces import Piece, Share
from scara_iso.iso9283 import moment_of_test
from scara_iso.run import Run

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
