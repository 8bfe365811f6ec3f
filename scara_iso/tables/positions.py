"""Columns that are named by nothing but their position: `columns=` for a header."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from scara_iso.errors import UsageError
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.layout import COLUMNS, Layout, header_cells, names_an_axis, runs_across
from scara_iso.tables.names import (
    LONGEST_NAME,
    Column,
    Kind,
    clean,
    read_name,
    read_names,
    read_unit,
    settle,
)
from scara_iso.tables.numbers import parse_cell
from scara_iso.tables.text import Row

SKIPPED = "-"
ONE_A_ROW = (
    "write a row for each reading: pose,approach,cycle,X with the target as its pose; where the "
    "columns are of several poses, head them P1_X, P1_Y, P2_X"
)
_TARGET = re.compile(r"(?:targets?|ziel|soll|direction|richtung)\b.*|(?:ziel|soll)pos.*")
_BRACKETS = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]")
_MOST = 40
"""Fields that a suggestion names."""


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
    columns = read_names(["note" if name == SKIPPED else name for name in names], [""] * len(names))
    fitting = [row for row in rows if _fits(row, columns)]
    for row in fitting:
        if not _is_like(row, fitting[-1]):
            continue  # LabVIEW's "Samples 5 5" above its columns
        above = [one for one in rows if one.line < row.line]
        found = (settle(c, names[c.position], row.cells[c.position]) for c in columns)
        settled = (_with_unit(column, above) for column in found)
        return Layout(tuple(settled), _header(names), row.line, row.line, sure=True)
    return None


def _is_like(row: Row, other: Row) -> bool:
    """Say whether no field holds a number in one row and words in the other."""
    kinds = (
        (parse_cell(a), parse_cell(b), a, b) for a, b in zip(row.cells, other.cells, strict=False)
    )
    return all((x is None) == (y is None) or not a.strip() or not b.strip() for x, y, a, b in kinds)


def _header(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"field {k}" if name == SKIPPED else name for k, name in enumerate(names, start=1))


def _fits(row: Row, columns: Sequence[Column]) -> bool:
    if len(row.cells) < len(columns) or any(cell.strip() for cell in row.cells[len(columns) :]):
        return False
    sized = (c for c in columns if c.kind in (Kind.AXIS, Kind.CYCLE))
    return all(parse_cell(row.cells[c.position]) is not None for c in sized)


def count_fitting(rows: Sequence[Row], names: Sequence[str]) -> int:
    """Return how many rows have the named fields, with numbers for the axes."""
    columns = read_names(list(names), [""] * len(names))
    return sum(_fits(row, columns) for row in rows)


def check_header(rows: Sequence[Row], layout: Layout, faults: Faults) -> None:
    """Refuse names that the file's own header gives to other fields, and rows that lack some."""
    for row in rows:
        filled = [cell for cell in row.cells if cell.strip()]
        if row.line < layout.header_line and filled and all(map(parse_cell, filled)):
            what = f"{len(filled)} numbers above the first row of {layout.width} fields"
            faults.add(what, row.line, remedy="complete the line, or remove it")
        if row.line >= layout.header_line:
            continue
        _check_units(row, layout, faults)
        if not names_an_axis(row.cells):
            continue
        own = read_names(header_cells(row.cells), [""] * len(header_cells(row.cells)))
        stated = {c.name: c.position for c in layout.of(Kind.AXIS)}
        for column in own:
            k = stated.get(column.name, column.position)
            if column.kind is Kind.AXIS and k != column.position:
                what = f"{column.name} by the header, and `columns=` says it is field {k + 1}"
                remedy = "leave `columns=` out, or remove the header"
                faults.add(what, row.line, column.position + 1, remedy=remedy)


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


def _check_units(row: Row, layout: Layout, faults: Faults) -> None:
    """Refuse a unit in the file's own heading of an axis other than `columns=` states."""
    for column in layout.of(Kind.AXIS):
        unit = _unit_above(row, column)
        if unit and read_unit(unit) != read_unit(column.unit):
            what = f"{quoted(unit)} heads {column.name}, and `columns=` states {column.unit}"
            faults.add(what, row.line, column.position + 1, remedy="name the unit that is true")


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
    if any(map(_targets_across, tables)):
        return f"the targets of ISO 230-2: {ONE_A_ROW}"
    if any(map(_axes_in_rows, tables)):
        return _TURN
    rows = max((_alike(rows) for rows in tables), key=lambda r: (len(r), _width(r)), default=[])
    if len(rows) < 2 or _width(rows) > _MOST:
        return ""
    row = rows[-1]
    said = ", ".join(clean(cell) for cell in row.cells)
    numbers = [k for k, cell in enumerate(row.cells) if _is_number(cell) and not _is_clock(rows, k)]
    if not numbers:
        return ""
    axes = dict(zip(numbers[:3], ("X", "Y", "Z"), strict=False))
    named = ",".join(axes.get(k, SKIPPED) for k in range(_width(rows)))
    return (
        f"no header says what {quoted(said)} is: name the fields in turn, {SKIPPED} for what is no "
        f"reading, for example `columns={named}`"
    )


def _axes_in_rows(rows: Sequence[Row]) -> bool:
    """Say whether a row begins with an axis and goes on with its readings."""
    return any(
        len(row.cells) > _FEWEST_ACROSS
        and read_name(row.cells[0]).kind is Kind.AXIS
        and all(map(_is_number, row.cells[1:]))
        for row in rows
    )


def _targets_across(rows: Sequence[Row]) -> bool:
    """Say whether a cell is a heading of ISO 230-2, where targets stand in place of axes."""
    short = (clean(cell).lower() for row in rows for cell in row.cells if len(cell) <= LONGEST_NAME)
    return any(map(_TARGET.fullmatch, short))


def _is_clock(rows: Sequence[Row], k: int) -> bool:
    """Say whether a field rises from row to row, as a clock and a count do, or never changes."""
    values = [number.value for row in rows if (number := parse_cell(row.cells[k]))]
    rises = all(after > before for before, after in pairwise(values))
    return len(values) > 2 and (rises or len(set(values)) == 1)


def _alike(rows: Sequence[Row]) -> list[Row]:
    found: dict[int, list[Row]] = {}
    for row in rows:
        if _mostly_numbers(row.cells):
            found.setdefault(len(row.cells), []).append(row)
    return max(found.values(), key=len, default=[])


def _width(rows: Sequence[Row]) -> int:
    return len(rows[0].cells) if rows else 0


def _is_number(cell: str) -> bool:
    number = parse_cell(cell)
    return number is not None and (not number.unit or read_unit(number.unit) is not None)


def _mostly_numbers(cells: Sequence[str]) -> bool:
    numbers = sum(map(_is_number, cells))
    if not 0 < numbers or 3 * numbers < len(cells):
        return False
    words = (cell for cell in cells if len(cell) <= LONGEST_NAME)
    return not any(read_name(word).kind is Kind.AXIS for word in words)  # a row for each axis
