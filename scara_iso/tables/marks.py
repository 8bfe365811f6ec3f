"""Whether numbers may be others than they seem: by their decimal marks, a delimiter, a cut end."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.run import FloatArray, Run
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults, quoted, refuse
from scara_iso.tables.grid import CellGrid, Delimiter, split_each
from scara_iso.tables.names import Column, Kind
from scara_iso.tables.numbers import Mark, count_decimals, parse_cell

_WHICH = "say which mark is the decimal one: `decimal=,` or `decimal=.`"
_ALIKE = f"write them alike; where one mark groups thousands, {_WHICH}"
_TENTHS = 10
"""Two digits behind a comma."""


def refuse_other_marks(decimal: str | None) -> None:
    """Raise `UsageError` for what is given as the decimal mark and is none."""
    if decimal not in (None, ",", "."):
        raise UsageError(f"decimal mark {decimal!r}", remedy="use ',' or '.'")


def check_marks(columns: Columns, sizes: Iterable[str]) -> None:
    """Refuse commas that may group thousands, and commas beside points, where no mark is asked for.

    A decimal comma in one of the ``sizes`` that the file states, as 0,001, says what commas are.
    """
    marks, faults = columns.marks, columns.faults
    comma = Mark.COMMA in marks or Mark.EITHER in marks
    if columns.decimal is not None:
        return
    if Mark.BOTH in marks or (comma and Mark.POINT in marks):
        for mark, (line, column, text) in marks.items():
            what = f"{quoted(text)} with {mark.value}: commas and points both occur"
            faults.add(what, line, column, remedy=_ALIKE)
    elif Mark.EITHER in marks and Mark.COMMA not in {*marks, *_marks_in(sizes)}:
        line, column, text = marks[Mark.EITHER]
        what = f"{quoted(text)} could have a decimal comma or group thousands"
        faults.add(what, line, column, remedy=_WHICH)


def decimal_of(columns: Columns, sizes: Iterable[str]) -> str | None:
    """Return the decimal mark that is asked for or that a number shows, None for neither."""
    return columns.decimal or ("," if Mark.COMMA in {*columns.marks, *_marks_in(sizes)} else None)


def _marks_in(sizes: Iterable[str]) -> Iterator[Mark]:
    return (number.mark for size in sizes if (number := parse_cell(size)))


def mark_in_words(columns: Columns) -> str:
    """Return which mark of the numbers was taken for the decimal one."""
    if columns.decimal is not None:
        return "decimal comma as asked" if columns.decimal == "," else "decimal point as asked"
    commas = columns.marks.keys() & {Mark.COMMA, Mark.EITHER}
    return "decimal comma" if commas else "decimal point"


def check_numbers(run: Run, columns: Columns, delimiter: Delimiter | None) -> None:
    """Refuse numbers that are others where the delimiter, or a point, is the other locale's."""
    if columns.decimal is not None:
        return
    if delimiter is Delimiter.COMMA and not columns.marks:
        _check_split(run, columns)
    apart = delimiter in (Delimiter.SEMICOLON, Delimiter.TAB) or columns.faults.sheet
    if apart and Mark.POINT in columns.marks:
        _check_groups(run, columns)


def _check_groups(run: Run, columns: Columns) -> None:
    """Refuse 1.512 um between semicolons or as text, which may be 1512: few dials are so fine."""
    for column in columns.layout.of(Kind.AXIS):
        values, axis = np.abs(columns.values(column)), run.axes[column.name]
        step = axis.resolution and axis.shown / axis.resolution
        known = step is not None and np.allclose(step, np.round(step), rtol=0, atol=1e-3)
        if run.origin.units[column.name] == "um" and not known and _may_be_grouped(values):
            columns.fault(
                column,
                f"{values[values != np.round(values)][0]:.3f} um could have a decimal point or "
                "group thousands: `decimal=.` or `decimal=,` says which",
                int(columns.all_lines()[0]),
                remedy=f"{_WHICH}; or state the dial's resolution",
            )
    columns.faults.check()


def _may_be_grouped(values: FloatArray) -> bool:
    parted = values[values != np.round(values)]
    thousandths = np.isclose(parted * 1000, np.round(parted * 1000), rtol=0, atol=1e-6)
    fine = np.round(parted, 2) != parted
    return bool(fine.any() and thousandths.all() and parted.min() >= 1 and parted.max() < 1000)


def _check_split(run: Run, columns: Columns) -> None:
    """Refuse a whole number that never changes beside digits that do: 0,112 may have been one.

    A header with as many names as commas left fields lets split decimals pass for two columns.
    """
    by_position = {column.position: column for column in columns.layout.columns}
    for axis in columns.layout.of(Kind.AXIS):
        first, beside = run.axes[axis.name].readings, by_position.get(axis.position + 1)
        if beside is None or np.ptp(first) > 0 or not np.array_equal(first, np.round(first)):
            continue
        second = _whole_numbers(beside, columns)
        if second is not None and second.max() >= _TENTHS:
            called = beside.name if beside.kind is Kind.AXIS else beside.heading
            message = f"{axis.name} never changes and {called} is whole: split decimal commas?"
            remedy = "say `decimal=.` if the numbers are whole"
            raise refuse(columns.faults.where, message, remedy=remedy)


def _whole_numbers(column: Column, columns: Columns) -> FloatArray | None:
    """Return the whole numbers that a column holds, in sizes; None for another or the time."""
    if column.kind is Kind.COMMENT:
        labels = columns.distinct(column)
        whole = all(map(str.isdecimal, labels))
        return np.array(labels, dtype=np.float64)[columns.values(column)] if whole else None
    if column.kind not in (Kind.AXIS, Kind.COVARIATE) or column.name == "time_s":
        return None
    values = np.abs(columns.values(column))
    return values if np.array_equal(values, np.round(values)) else None


def check_end(grid: CellGrid, columns: Columns, resolutions: Iterable[str]) -> str:
    """Find a text that was cut inside its last number: no line end, and too few decimals.

    A reading is refused that lacks decimals which one of the stated ``resolutions`` and every one
    above have. Of other readings with fewer than most above, and numbers with fewer than each, a
    note is returned; else nothing.
    """
    text, last = grid.text, columns.layout.columns[-1]
    if text is None or grid.delimiter is None or text.ended or columns.last_line != text.lines:
        return ""
    rows = [row for _, row in split_each(1, text.last, grid.delimiter, Faults(""))]
    if last.position < len(rows[-1]) - 1:  # another pose's cells follow
        return ""
    cells = (row[last.position] if len(row) > last.position else "" for row in rows)
    *above, decimals = [count_decimals(str(cell)) for cell in cells]
    known = sorted(count for count in above if count is not None)
    middle = (len(known) - 1) // 2 if last.kind is Kind.AXIS else 0
    usual = known[middle] if known else 0
    if decimals is None or decimals >= usual:
        return ""
    few = f"{decimals} decimal{'s' * (decimals != 1)}"
    what = f"no line end, and {few} where others have {usual}: is the file cut?"
    if last.kind is Kind.AXIS and {*known} <= {*map(count_decimals, resolutions)}:
        remedy = "get the whole file; if it is whole, end its last line"
        columns.fault(last, what, text.lines, remedy=remedy)
        return ""
    return f"line {text.lines}: {what}"
