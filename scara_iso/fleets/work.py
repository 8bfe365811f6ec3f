"""What is done with one part, by whichever process or machine: every table of it is diagnosed."""

from __future__ import annotations

from dataclasses import field
from pathlib import Path

from scara_iso.diagnosis import PERMUTATIONS, SEED, CyclesWanted, screen
from scara_iso.errors import ScaraIsoError
from scara_iso.fleets.parts import FleetTable, ReadAs, digest, tables_in
from scara_iso.frozen import dataclass

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
    error: str | None = None
    """Why there is nothing of it."""


@dataclass(frozen=True, slots=True)
class PartResult:
    """What is found of one part."""

    part: str
    sha256: str
    version: str
    """Of the program that worked on it."""
    rows: tuple[TableRow, ...]
    error: str | None = None
    """Why the part could not be read."""


def examine(part: str, task: Task) -> PartResult:
    """Return what is found of a part; what cannot be read is said in it, and raises nothing."""
    from scara_iso import __version__  # noqa: PLC0415 - the face of all

    path, sha256 = Path(part), ""
    try:
        sha256 = digest(path)
        rows = tuple(_row(table, task) for table in tables_in(path, task.reading))
    except ScaraIsoError as error:
        return PartResult(path.name, sha256, __version__, (), str(error))
    return PartResult(path.name, sha256, __version__, rows)


def _row(table: FleetTable, task: Task) -> TableRow:
    if isinstance(table.run, ScaraIsoError):
        return TableRow(table.robot, table.test, error=_said(table.run))
    try:
        found = screen(table.run, task.wanted, seed=task.seed)
    except ScaraIsoError as error:
        return TableRow(table.robot, table.test, error=_said(error))
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
    )


def _said(error: ScaraIsoError) -> str:
    """Return an error with the first of its faults on one line."""
    lines = [line.strip() for line in str(error).splitlines()]
    more = [f"and {len(lines) - _LINES} more"] if len(lines) > _LINES else []
    return "; ".join((*lines[:_LINES], *more))
