"""Tables of several poses on one sheet: below or beside each other, each under its pose's name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import refuse
from scara_iso.tables.layout import names_an_axis
from scara_iso.tables.numbers import BLANKS, parse_cell
from scara_iso.tables.pose_names import pose_alone
from scara_iso.tables.preamble import read_statement
from scara_iso.tables.text import Row

Line = tuple[int, Sequence[Cell]]
"""A row's number and its cells."""
BESIDE = 300
"""Poses that may stand side by side: each is read for itself, with the columns of all."""


@dataclass(frozen=True, slots=True)
class Block:
    """The rows of one pose: those above all blocks, and its own with other blocks' cells empty.

    So lines and columns of a fault are those of the file.
    """

    pose: str
    rows: list[Line]
    place: str = "the name above it"
    """What says whose pose it is."""


@dataclass(frozen=True, slots=True)
class _Titles:
    """A row of poses' names: its place among the rows, and each name with its column."""

    at: int
    poses: tuple[tuple[int, str], ...]


def has_blocks(rows: Sequence[Row]) -> bool:
    """Say whether a pose's name stands above the first header among the rows of a file's head."""
    return next(_titles([(row.line, row.cells) for row in rows]), None) is not None


def find_blocks(rows: Sequence[Line], where: str) -> list[Block]:
    """Return the blocks of a sheet; none where fewer than two poses stand above a header.

    Raises `DataError` for more than `BESIDE` side by side.
    """
    titles = list(_titles(rows))
    if sum(len(one.poses) for one in titles) < 2:
        return []
    for one in titles:
        check_beside(len(one.poses), rows[one.at][0], where)
    above = list(rows[: titles[0].at])
    ends = [*(one.at for one in titles[1:]), len(rows)]
    return [
        Block(pose, [*above, *_columns(rows[one.at + 1 : end], one.poses, k)])
        for one, end in zip(titles, ends, strict=True)
        for k, (_, pose) in enumerate(one.poses)
    ]


def check_beside(poses: int, line: int, where: str) -> None:
    """Raise `DataError` where a row heads more poses than may stand side by side."""
    if poses > BESIDE:
        what = f"row {line} heads {poses} poses side by side, more than {BESIDE}"
        remedy = "put the rows of the poses below each other, with a column 'pose'"
        raise refuse(where, what, remedy=remedy)


def _titles(rows: Sequence[Line]) -> Iterator[_Titles]:
    """Yield the rows of names that a header follows, if the first header has one."""
    waiting: _Titles | None = None
    found = False
    for k, (_, cells) in enumerate(rows):
        texts = [cell if isinstance(cell, str) else repr(cell) for cell in cells]
        if poses := _poses(texts):
            waiting = _Titles(k, poses)
        elif names_an_axis(texts):
            if waiting is None and not found:
                return
            if waiting is not None:
                yield waiting
                found = True
            waiting = None
        elif sum(parse_cell(text) is not None for text in texts) > 1:
            waiting = None


def _poses(texts: Sequence[str]) -> tuple[tuple[int, str], ...]:
    filled = [(k, text) for k, text in enumerate(texts) if text.strip(BLANKS)]
    if len(filled) == 2 and (stated := read_statement(Row(0, list(texts), "", 0))):
        key, value = stated
        if key == "pose":
            return ((filled[0][0], value),)
    named = [(k, pose_alone(text)) for k, text in filled]
    return tuple((k, pose) for k, pose in named if pose) if all(p for _, p in named) else ()


def _columns(rows: Sequence[Line], poses: Sequence[tuple[int, str]], k: int) -> Iterator[Line]:
    """Yield the rows with the columns of the k-th pose, and those before the first one's."""
    if len(poses) == 1:
        yield from rows
        return
    shared, start = poses[0][0], poses[k][0]
    end = poses[k + 1][0] if k + 1 < len(poses) else None
    for line, cells in rows:
        mine = slice(start, len(cells) if end is None else end)
        kept = range(len(cells))[mine]
        yield line, [cell if j < shared or j in kept else "" for j, cell in enumerate(cells)]
