"""Tables with a row for each axis of a visit, as tables with a row for each visit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from scara_iso.tables.faults import Faults
from scara_iso.tables.grid import Cell, CellGrid, Line, head_of, is_filled, text_row
from scara_iso.tables.names import Column, Kind, is_axis, names_and_units, read_name, read_names
from scara_iso.tables.numbers import parse_cell
from scara_iso.tables.words import clean

_ONCE = "write a row for each axis of each visit, alike but for axis and reading"


def by_visit(grid: CellGrid) -> CellGrid | None:
    """Return a grid of a row for each axis of a visit as one of a row for each visit, or None.

    One column names the axis of each row, one holds the readings; those of all axes but the first
    come behind the columns of the file. Raises `DataError` for an axis that a visit lacks, or has
    twice.
    """
    head = (row for row in grid.head if any(map(is_axis, row.cells)) and _holds_numbers(row.cells))
    first = next(head, None)
    if first is None or grid.hidden_rows or grid.hidden_columns:
        return None
    at = [*map(is_axis, first.cells)].index(True)
    every = [row for row in grid.rows() if any(map(is_filled, row[1]))]
    k = [line for line, _ in every].index(first.line)
    rows = [row for row in every[k:] if _holds_numbers(row[1])]
    columns = read_names(text_row(*every[k - 1]).cells if k else ())
    readings = _readings(columns, rows, at)
    if readings is None:
        return None
    visits = _visits(grid, columns, rows, (at, readings.position))
    of_axes = (_headings(columns, readings, str(cells[at])) for _, cells in visits[0])
    visits = [[(every[k - 1][0], names) for names in of_axes], *visits]
    lines, places = [*every[: k - 1]], dict[tuple[int, int], tuple[int, int]]()
    for (line, cells), *more in visits:
        turned = ["" if j == at else cell for j, cell in enumerate(cells)]
        lines.append((line, [*turned, *(one[readings.position] for _, one in more)]))
        behind = enumerate(more, len(columns) + 1)
        places |= {(line, j): (own, readings.position + 1) for j, (own, _) in behind}
    lines += [row for row in every[k:] if not _holds_numbers(row[1])]
    how = f"{grid.how}, a row for each axis"
    return replace(grid, how=how, lines=lines, head=head_of(lines), places=places)


def _holds_numbers(cells: Sequence[Cell]) -> bool:
    return any(isinstance(cell, float) or parse_cell(cell) for cell in cells)


def _readings(columns: Sequence[Column], rows: Sequence[Line], at: int) -> Column | None:
    """Return the only column of numbers of no known meaning beside one of cycles."""
    if any(len(cells) != len(columns) or not is_axis(str(cells[at])) for _, cells in rows):
        return None
    free = [c for c in columns if c.kind is Kind.COVARIATE and not c.condition and c.position != at]
    numbers = {c: sum(_holds_numbers([cells[c.position]]) for _, cells in rows) for c in free}
    found = [c for c, count in numbers.items() if 2 * count > len(rows)]
    return found[0] if len(found) == 1 and any(c.kind is Kind.CYCLE for c in columns) else None


def _visits(
    grid: CellGrid, columns: Sequence[Column], rows: Sequence[Line], own: tuple[int, int]
) -> list[list[Line]]:
    """Return the rows of each visit by axis: they are alike but for their ``own`` two columns."""
    visits, faults = dict[str, dict[str, Line]](), Faults(grid.where, sheet=grid.title)
    for line, cells in rows:
        texts = zip(columns, text_row(line, cells).cells, strict=True)
        shared = (f"{c.heading} {x}" for c, x in texts if c.position not in own and is_filled(x))
        visit = visits.setdefault(", ".join(shared), {})
        before, _ = visit.setdefault(read_name(str(cells[own[0]])).name, (line, cells))
        if before != line:
            what = f"{cells[own[0]]} again, as in {faults.place(before)}"
            faults.add(what, line, own[0] + 1, remedy=_ONCE)
    axes = dict.fromkeys(axis for visit in visits.values() for axis in visit)
    for called, visit in visits.items():
        for axis in (axis for axis in axes if axis not in visit):
            faults.add(f"{called} has no {axis}", min(visit.values())[0], remedy=_ONCE)
    faults.check()
    return [[visit[axis] for axis in axes] for visit in visits.values()]


def _headings(columns: Sequence[Column], readings: Column, cell: str) -> list[str]:
    """Return the headings of an axis: its name stands in front of the unit of the readings."""
    *_, (name, unit) = names_and_units(clean(readings.heading))
    axis = read_name(cell)
    units = " over ".join(dict.fromkeys(filter(None, (axis.unit, unit))))
    called = f"{name} {axis.name} [{units}]" if units else f"{name} {axis.name}"
    return [called if c is readings else c.heading for c in columns]
