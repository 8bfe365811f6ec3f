"""Poses in one grid, below or beside each other or named by headings; axes named by rows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from scara_iso.tables.faults import refuse
from scara_iso.tables.grid import Cell, CellGrid, Line, Row, head_of, is_filled
from scara_iso.tables.layout import find_layout, find_worded, names_an_axis
from scara_iso.tables.names import (
    Column,
    Kind,
    is_axis,
    names_and_units,
    pose_alone,
    pose_and_name,
    read_name,
    read_names,
)
from scara_iso.tables.numbers import parse_cell
from scara_iso.tables.statements import read_statements
from scara_iso.tables.words import clean

BESIDE = 300
"""Poses that may stand side by side: each is read for itself, with the columns of all."""


Block = tuple[str, CellGrid, str]
"""A pose, its grid, and what says whose pose it is.

The grid has the rows above all, and its own with other poses' cells empty: so lines and columns of
a fault are those of the file.
"""
_Poses = Sequence[tuple[int, str]]
"""The names of a row of poses, each with its column."""


def find_blocks(grid: CellGrid) -> list[Block]:
    """Return the blocks of a grid of several poses; none for another.

    Raises `DataError` for more than `BESIDE` side by side.
    """
    head = [(row.line, row.cells) for row in grid.head]
    if next(_titles(head), None):
        return _under_titles(grid, grid.rows())
    found = find_headings(grid.head)
    return _of_headings(grid, *found) if found else []


def _under_titles(grid: CellGrid, rows: Sequence[Line]) -> list[Block]:
    """Return a block for each pose's name above a header; none for fewer than two."""
    titles = list(_titles(rows))
    if sum(len(poses) for _, poses in titles) < 2:
        return []
    for at, poses in titles:
        _check_beside(len(poses), rows[at][0], grid.where)
    above = list(rows[: titles[0][0]])
    ends = [*(at for at, _ in titles[1:]), len(rows)]
    return [
        _block(pose, grid, [*above, *_columns(rows[at + 1 : end], poses, k)])
        for (at, poses), end in zip(titles, ends, strict=True)
        for k, (_, pose) in enumerate(poses)
    ]


def _block(pose: str, grid: CellGrid, rows: list[Line], place: str = "the name above it") -> Block:
    called = f"{grid.where}, block of {pose}"
    return pose, replace(grid, where=called, lines=rows, head=head_of(rows)), place


def _check_beside(poses: int, line: int, where: str) -> None:
    if poses > BESIDE:
        what = f"row {line} heads {poses} poses side by side, more than {BESIDE}"
        remedy = "put the rows of the poses below each other, with a column 'pose'"
        raise refuse(where, what, remedy=remedy)


def _titles(rows: Sequence[Line]) -> Iterator[tuple[int, _Poses]]:
    """Yield place and names of each row of names that a header follows, if the first has one."""
    waiting: tuple[int, _Poses] | None = None
    found = False
    for k, (_, cells) in enumerate(rows):
        texts = [cell if isinstance(cell, str) else repr(cell) for cell in cells]
        if poses := _poses(texts):
            waiting = k, poses
        elif names_an_axis(texts):
            if waiting is None and not found:
                return
            if waiting is not None:
                yield waiting
                found = True
            waiting = None
        elif sum(parse_cell(text) is not None for text in texts) > 1:
            waiting = None


def _poses(texts: Sequence[str]) -> _Poses:
    filled = [(k, text) for k, text in enumerate(texts) if is_filled(text)]
    stated = read_statements(Row(0, list(texts), "", 0)) if len(filled) == 2 else []
    if stated and stated[0].key == "pose":
        return [(filled[0][0], stated[0].value)]
    named = [(k, pose_alone(text)) for k, text in filled]
    return [(k, pose) for k, pose in named if pose] if all(p for _, p in named) else []


def _columns(rows: Sequence[Line], poses: _Poses, k: int) -> Iterator[Line]:
    """Yield the rows with the columns of the k-th pose, and those before the first one's."""
    if len(poses) == 1:
        yield from rows
        return
    shared, start = poses[0][0], poses[k][0]
    end = poses[k + 1][0] if k + 1 < len(poses) else None
    for line, cells in rows:
        kept = range(start, len(cells) if end is None else end)
        yield line, [cell if j < shared or j in kept else "" for j, cell in enumerate(cells)]


def find_headings(head: Sequence[Row]) -> tuple[int, Mapping[int, tuple[str, str]]] | None:
    """Return the first row that heads the axes of two poses or more, as ``P1 X [mm]``, ``X P2``.

    That is its line, and pose and name of each such cell by its column. There is none where a row
    names an axis of no pose: that is the header.
    """
    for row in head:
        named = {j: found for j, cell in enumerate(row.cells) if (found := pose_and_name(cell))}
        if len({p for p, name in named.values() if is_axis(name)}) > 1:
            return None if any(names_an_axis(one.cells) for one in head) else (row.line, named)
    return None


def _of_headings(grid: CellGrid, line: int, named: Mapping[int, tuple[str, str]]) -> list[Block]:
    rows, at = grid.rows(), line - 1
    poses = dict.fromkeys(pose for pose, _ in named.values())
    _check_beside(len(poses), line, grid.where)
    place = "the heading of its columns"
    return [_block(p, grid, [*rows[:at], *_of(p, rows[at:], named)], place) for p in poses]


def _of(pose: str, rows: Sequence[Line], named: Mapping[int, tuple[str, str]]) -> Iterator[Line]:
    """Yield the header and the rows below it with the columns of one pose."""
    others = {j for j, (of, _) in named.items() if of != pose}
    for k, (line, cells) in enumerate(rows):
        kept = ["" if j in others else cell for j, cell in enumerate(cells)]
        if k == 0:
            kept = [named[j][1] if j in named and cell else cell for j, cell in enumerate(kept)]
        yield line, kept


def find_axes(grid: CellGrid) -> list[CellGrid]:
    """Return a grid for each axis where a column names that of each row: it heads the readings."""
    named = (k for k, row in enumerate(grid.head) if any(map(is_axis, row.cells)))
    first = next((k for k in named if _hold_a_number(grid.head[k].cells)), 0)
    head = next((row for row in reversed(grid.head[:first]) if row.text), None)
    if head is None:
        return []
    at = [*map(is_axis, grid.head[first].cells)].index(True)
    below = [row for row in grid.rows() if row[0] > head.line]
    readings = _column_of_readings(head, at, [cells for _, cells in below if _hold_a_number(cells)])
    if readings is None:
        return []
    grids = list(_by_axis(grid, head, at, readings, below))
    return grids if find_layout(grids[0].head) or find_worded(grids[0].head) else []


def _column_of_readings(head: Row, at: int, rows: Sequence[Sequence[Cell]]) -> Column | None:
    """Return the one column of numbers besides cycle and conditions, where each row has an axis."""
    columns = read_names(head.cells)
    free = [c for c in columns if c.kind is Kind.COVARIATE and not c.condition and c.position != at]
    found = [
        c for c in free if 2 * sum(_hold_a_number(r[c.position :][:1]) for r in rows) > len(rows)
    ]
    counted = any(column.kind is Kind.CYCLE for column in columns)
    of_axes = all(len(cells) > at and is_axis(str(cells[at])) for cells in rows)
    return found[0] if len(found) == 1 and counted and of_axes else None


def _by_axis(
    grid: CellGrid, head: Row, at: int, readings: Column, below: Sequence[Line]
) -> Iterator[CellGrid]:
    """Yield the rows of each axis, whose name goes from its column into the heading."""
    *_, (name, unit) = names_and_units(clean(readings.heading))
    above: list[Line] = [(row.line, row.cells) for row in grid.head if row.line < head.line]
    rows = {line: cells for line, cells in below if _hold_a_number(cells)}
    others = [row for row in below if row[0] not in rows]
    for cell in dict.fromkeys(str(cells[at]) for cells in rows.values()):
        axis, names = read_name(cell), [*head.cells]
        called = "".join(f" [{one}]" for one in (axis.unit, unit) if one)
        names[at], names[readings.position] = "", f"{name} {axis.name}{called}"
        own = [(n, [*r[:at], "", *r[at + 1 :]]) for n, r in rows.items() if r[at] == cell]
        lines = [*above, (head.line, names), *own, *others]
        yield replace(grid, lines=lines, head=head_of(lines))


def _hold_a_number(cells: Sequence[Cell]) -> bool:
    return any(isinstance(cell, float) or parse_cell(cell) for cell in cells)
