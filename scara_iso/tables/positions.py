"""Columns that are named by their position: `columns=` for a header, and when to propose it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

from scara_iso.base.errors import UsageError
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.grid import COLUMNS, Row, is_filled
from scara_iso.tables.layout import Layout, header_cells, names_an_axis, runs_across
from scara_iso.tables.names import (
    LONGEST_NAME,
    Column,
    Kind,
    clean,
    is_axis,
    read_names,
    read_unit,
    settle,
)
from scara_iso.tables.numbers import parse_cell

_SKIPPED = "-"
ONE_A_ROW = (
    "write a row for each reading: pose,approach,cycle,X with the target as its pose; where the "
    "columns are of several poses, head them P1_X, P1_Y, P2_X"
)
_BRACKETS = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]")


def column_names(columns: str | Sequence[str]) -> tuple[str, ...]:
    """Return the names of ``X,Y,-`` or of a sequence; `UsageError` where none is an axis."""
    names = columns.split(",") if isinstance(columns, str) else columns
    found = tuple(name.strip() for name in names)
    if not names_an_axis(found) or not all(found) or len(found) > COLUMNS:
        raise UsageError(
            f"columns {quoted(','.join(found))} name no axis X, Y, Z or theta",
            remedy="name each field in turn, - for one to leave out: `columns=cycle,X,Y,-`",
        )
    return found


def place_columns(rows: Sequence[Row], names: Sequence[str]) -> Layout | None:
    """Return the layout that ``names`` give the first row of as many fields, numbers for axes."""
    columns = _named(names)
    fitting = [row for row in rows if _fits(row, columns)]
    # LabVIEW's "Samples 5 5" above its columns is not like the rows
    row = next((row for row in fitting if _is_like(row, fitting[-1])), None)
    if row is None:
        return None
    above = [one for one in rows if one.line < row.line]
    found = (settle(c, names[c.position], row.cells[c.position]) for c in columns)
    header = (f"field {k}" if n == _SKIPPED else n for k, n in enumerate(names, start=1))
    settled = tuple(_with_unit(column, above) for column in found)
    return Layout(settled, tuple(header), row.line, row.line, sure=True)


def count_fitting(rows: Iterable[Row], names: Sequence[str]) -> int:
    """Return how many rows have the named fields, with numbers for the axes."""
    columns = _named(names)
    return sum(_fits(row, columns) for row in rows)


def _named(names: Sequence[str]) -> list[Column]:
    return read_names(["note" if n == _SKIPPED else n for n in names], [""] * len(names))


def _fits(row: Row, columns: Sequence[Column]) -> bool:
    if len(row.cells) < len(columns) or any(map(is_filled, row.cells[len(columns) :])):
        return False
    sized = (c for c in columns if c.kind in (Kind.AXIS, Kind.CYCLE))
    return all(parse_cell(row.cells[c.position]) is not None for c in sized)


def _is_like(row: Row, other: Row) -> bool:
    """Say whether no field holds a number in one row and words in the other."""
    pairs = [p for p in zip(row.cells, other.cells, strict=False) if all(map(str.strip, p))]
    return all((parse_cell(a) is None) == (parse_cell(b) is None) for a, b in pairs)


def _unit_above(row: Row, column: Column) -> str:
    """Return the unit in brackets that a heading of the file gives the field, or nothing."""
    cell = row.cells[column.position] if column.position < len(row.cells) else ""
    found = _BRACKETS.search(cell) if len(cell) <= LONGEST_NAME else None
    return found[1].strip() if found and read_unit(found[1]) is not None else ""


def _with_unit(column: Column, above: Sequence[Row]) -> Column:
    """Return an axis with the unit of the file's own heading, where `columns=` states none."""
    stated = [unit for row in above if (unit := _unit_above(row, column))]
    lacks = column.kind is Kind.AXIS and not column.unit and stated
    return replace(column, unit=stated[-1]) if lacks else column


def check_names(rows: Iterable[Row], layout: Layout, faults: Faults) -> None:
    """Refuse names and units that the file's own header gives otherwise, and incomplete rows."""
    for row in rows:
        if row.line >= layout.header_line:
            break
        filled = [cell for cell in row.cells if cell.strip()]
        if filled and all(map(parse_cell, filled)):
            what = f"{len(filled)} numbers above the first row of {layout.width} fields"
            faults.add(what, row.line, remedy="complete the line, or remove it")
        for column in layout.of(Kind.AXIS):
            unit = _unit_above(row, column)
            if unit and read_unit(unit) != read_unit(column.unit):
                what = f"{quoted(unit)} heads {column.name}, and `columns=` states {column.unit}"
                place = row.line, column.position + 1
                faults.add(what, *place, remedy="name the unit that is true")
        own = header_cells(row.cells) if names_an_axis(row.cells) else []
        stated = {c.name: c.position for c in layout.of(Kind.AXIS)}
        for column in read_names(own, [""] * len(own)):
            k = stated.get(column.name, column.position)
            if column.kind is Kind.AXIS and k != column.position:
                what = f"{column.name} by the header, and `columns=` says it is field {k + 1}"
                remedy = "leave `columns=` out, or remove the header"
                faults.add(what, row.line, column.position + 1, remedy=remedy)


_TARGET = re.compile(r"(?:targets?|ziel|soll|direction|richtung)\b.*|(?:ziel|soll)pos.*")
_MOST = 40
"""Fields that a suggestion names."""
_OFTEN = 3  # times that each pose comes again
_FEWEST_ACROSS = 12  # a row of a measuring report has nominal, tolerances, measured, deviation
_TURN = (
    "the axes stand in rows: turn the table, so that each has a column "
    "(in a spreadsheet: copy, then paste special, transpose)"
)


def suggest_columns(tables: Sequence[Sequence[Row]]) -> str:
    """Return what to do with rows that no header names, split in each way that there is.

    Most rows of the same number of fields, most of them numbers, are taken for the table.
    """
    if any(map(runs_across, tables)):
        return ONE_A_ROW
    every = [row for rows in tables for row in rows]
    short = (clean(c).lower() for row in every for c in row.cells if len(c) <= LONGEST_NAME)
    if any(map(_TARGET.fullmatch, short)):
        return f"the targets of ISO 230-2: {ONE_A_ROW}"
    if any(len(r.cells) > _FEWEST_ACROSS and _is_in_rows(r.cells) for r in every):
        return _TURN
    alike = [rows for table in tables if (rows := _alike(table))]
    rows = max(alike, key=lambda rows: (len(rows), len(rows[0].cells)), default=[])
    if len(rows) < 2 or len(rows[0].cells) > _MOST:
        return ""
    cells, counts = rows[-1].cells, _counters(rows)
    numbers = [
        k
        for k, cell in enumerate(cells)
        if k not in counts and _is_number(cell) and not _is_clock(rows, k)
    ]
    if not numbers:
        return ""
    named_as = {**counts, **dict(zip(numbers[:3], ("X", "Y", "Z"), strict=False))}
    named = ",".join(named_as.get(k, _SKIPPED) for k in range(len(cells)))
    return (
        f"no header says what {quoted(', '.join(map(clean, cells)))} is: name them in order "
        f"({_SKIPPED} skips one), for example `columns={named}`"
    )


def _is_in_rows(cells: Sequence[str]) -> bool:
    """Say whether a row begins with an axis and goes on with its readings."""
    return all(map(_is_number, cells[1:])) and is_axis(cells[0])


def _counters(rows: Sequence[Row]) -> dict[int, str]:
    """Return the fields that count or repeat, as cycle and pose, beside one that does neither."""
    columns = [list(map(str.strip, cells)) for cells in zip(*(r.cells for r in rows), strict=True)]
    whole = {k: list(map(int, c)) for k, c in enumerate(columns) if all(map(str.isdecimal, c))}
    cycle = (k for k, c in whole.items() if all(b == a + 1 for a, b in pairwise(c)))
    pose = (k for k, c in whole.items() if 1 < len(set(c)) <= len(c) // _OFTEN)
    found = {next(cycle, -1): "cycle", next(pose, -1): "pose"} if len(whole) < len(columns) else {}
    return {k: name for k, name in found.items() if k >= 0}


def _is_clock(rows: Sequence[Row], k: int) -> bool:
    """Say whether a field rises from row to row, as a clock and a count do, or never changes."""
    values = [number.value for row in rows if (number := parse_cell(row.cells[k]))]
    rises = all(after > before for before, after in pairwise(values))
    return len(values) > 2 and (rises or len(set(values)) == 1)


def _alike(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of the usual number of fields among those of mostly numbers."""
    numbers = [row for row in rows if _mostly_numbers(row.cells)]
    widths = [len(row.cells) for row in numbers]
    usual = max(widths, key=widths.count, default=0)
    return [row for row in numbers if len(row.cells) == usual]


def _is_number(cell: str) -> bool:
    number = parse_cell(cell)
    return number is not None and (not number.unit or read_unit(number.unit) is not None)


def _mostly_numbers(cells: Sequence[str]) -> bool:
    numbers = sum(map(_is_number, cells))
    if not 0 < numbers or 3 * numbers < len(cells):
        return False
    words = (cell for cell in cells if len(cell) <= LONGEST_NAME)
    return not any(is_axis(word) for word in words)  # a row for each axis
