"""Cells to arrays: the quick way for clean pieces, cell by cell where a fault must be named.

Whether numbers may be others than they seem: by their decimal marks, a delimiter, a cut end.
"""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scara_iso.run import FloatArray, IntArray, Run, read_direction
from scara_iso.tables.grid import (
    NUMBER_CYCLES,
    OF_COLUMNS,
    STRUCK,
    Cell,
    CellGrid,
    Delimiter,
    Faults,
    Line,
    Row,
    is_dash,
    is_filled,
    refuse,
    split_each,
    stripped,
    text_row,
)
from scara_iso.tables.vocabulary.names import Column, Kind, Layout, read_timestamp, read_unit
from scara_iso.tables.vocabulary.words import (
    FORMULA,
    Mark,
    clean,
    count_decimals,
    cut_unit,
    names_a_footer,
    numbers_a_thing,
    parse_cell,
    parse_clean,
    quoted,
    subject_of_heading,
)

Labels = npt.NDArray[np.str_]
_Part = tuple[npt.NDArray[np.generic], Mark, str]
"""Values, how their decimal mark was written, and the unit behind each of them."""
_SIDES, _LEAVE = (
    "write +1 and -1 for the sides",
    "remove the column, or call it comment; pose if it names the pose, approach (+1, -1) if a side",
)
_LABELS = {Kind.POSE, Kind.DIRECTION, Kind.COMMENT, Kind.LABEL}
_WORDS = {**dict.fromkeys((*_LABELS, Kind.NAMELESS), np.str_), Kind.TIMESTAMP: np.object_}
"""Kinds of columns whose cells are no numbers, and what their values are until they are coded."""
_TYPES: dict[Kind, type[np.generic]] = {
    **dict.fromkeys(_LABELS, np.int32),
    Kind.CYCLE: np.int64,
    Kind.TIMESTAMP: np.object_,
}
_LABEL_POSES = "write the pose's name, such as P1, in each row, also for merged cells"
_WRITE_TIMES = "write date and time as 2026-05-12T08:30:00 in each row, or call the column comment"
_READING = "write the reading as one number; where none was taken, "
_LEAVE_OUT = "remove the row and say `allow_gaps=`"
_NUMBER_FIRST = "number the rows in a column cycle, then "
_FORMULA = "; a formula has its result once a spreadsheet has saved the workbook"
_STRUCK = "if the reading counts, take the strike off; if not, "
_DATE = "the spreadsheet took the reading for a date: set the cell's format to Text and retype it"
_ISO_DATE = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}")
_LABEL = 64
_LARGEST = 2**53


class Columns:
    """Gather the columns of a table, piece by piece, with every fault on the way."""

    def __init__(self, layout: Layout, decimal: str | None, faults: Faults) -> None:
        self.layout = layout
        self.decimal = decimal
        self.faults = faults
        self.marks: dict[Mark, tuple[int, int, str]] = {}
        self.units: dict[Column, dict[str, int]] = {}
        self.aside: dict[Cell, Row] = {}
        self._lines: list[npt.NDArray[Any]] = []
        self._parts: dict[Column, list[npt.NDArray[Any]]] = {}
        self._codes: dict[Column, dict[str, int]] = {}

    def add_clean(self, columns: Sequence[Sequence[str]], first_line: int) -> bool:
        """Take columns of cells that are all as the header says, or take none and return False."""
        if "#" in "".join(columns[0]):  # a row may be commented out
            return False
        parts = []
        for column, cells in zip(self.layout.columns, columns, strict=True):
            part = self._clean_part(column, cells)
            if part is None:
                return False
            parts.append(part)
        lines = range(first_line, first_line + len(columns[0]))
        for column, cells, part in zip(self.layout.columns, columns, parts, strict=True):
            self._keep(column, part, cells, lines)
        self._lines.append(np.array(lines, np.int32))
        return True

    def _keep(
        self, column: Column, part: _Part, cells: Sequence[str], lines: Sequence[int]
    ) -> None:
        values, mark, unit = part
        self._fill(column, values)
        self._note_unit(column, unit, lines[0])
        if mark not in (Mark.NONE, *self.marks):
            character = "." if mark is Mark.POINT else ","
            k = next(k for k, cell in enumerate(cells) if character in cell)
            self._note_mark(column, mark, cells[k], lines[k])

    def _clean_part(self, column: Column, cells: Sequence[str]) -> _Part | None:
        if column.kind in _WORDS:
            known = {cell: _read_word(column.kind, cell) for cell in set(cells)}
            if any(fault for _, fault, _ in known.values()):
                return None
            return np.array([known[cell][0] for cell in cells], _WORDS[column.kind]), Mark.NONE, ""
        if column.kind is Kind.CYCLE:
            part = parse_clean(cells, self.decimal) if stripped(cells[0])[-1:].isdigit() else None
            return (*part, "") if part is not None and _are_counts(part[0]) else None
        numbers, unit = cut_unit(cells)
        if unit and _is_sized(column) and not read_unit(unit):
            return None
        part = parse_clean(numbers, self.decimal)
        return None if part is None else (*part, unit)

    def add(self, rows: Sequence[Line]) -> None:
        """Take rows of the header's width, each with its line, cell by cell."""
        if not rows:
            return
        lines = [line for line, _ in rows]
        for column in self.layout.columns:
            cells = [cells[column.position] for _, cells in rows]
            self._add_part(column, cells, lines)
        self._lines.append(np.array(lines, np.int32))

    def _fill(self, column: Column, part: npt.NDArray[Any]) -> None:
        """Take the values of the rows that come next; labels by their codes."""
        if column.kind is Kind.NAMELESS:
            return
        if column.kind in _LABELS:
            codes = self._codes.setdefault(column, {})
            part = np.array([codes.setdefault(one, len(codes)) for one in part.tolist()])
        kind = _TYPES.get(column.kind, np.float64)
        self._parts.setdefault(column, []).append(part.astype(kind))

    def _add_part(self, column: Column, cells: Sequence[Cell], lines: Sequence[int]) -> None:
        remark = column.kind is Kind.COMMENT
        texts = [str(cell) for cell in cells if remark or isinstance(cell, str)]
        clean = self._clean_part(column, texts) if len(texts) == len(cells) else None
        if clean is not None:
            self._keep(column, clean, texts, lines)
            return
        words = _WORDS.get(column.kind)
        read = self._count if column.kind is Kind.CYCLE else self._number
        pairs = zip(cells, lines, strict=True)
        values = [(self._word if words else read)(column, cell, line) for cell, line in pairs]
        self._fill(column, np.array(values, words))

    def _word(self, column: Column, cell: Cell, line: int) -> object:
        value, fault, remedy = _read_word(column.kind, cell)
        if column.kind is Kind.NAMELESS and is_words(cell):
            self.aside[cell] = text_row(line, [*[""] * column.position, cell])
        elif fault:
            self.fault(column, f"{_shown(cell)} {fault}", line, remedy=remedy)
        return value

    def _number(self, column: Column, cell: Cell, line: int) -> float:
        if isinstance(cell, float):
            self._note_unit(column, "", line)
            return cell
        number = parse_cell(cell, self.decimal)
        strange = _is_sized(column) and number and number.unit and not read_unit(number.unit)
        if number is None or strange or not math.isfinite(number.value):
            self.fault(column, self._not_a_number(cell), line, remedy=self._remedy(column, cell))
            return 0.0
        self._note_mark(column, number.mark, cell, line)
        self._note_unit(column, number.unit, line)
        return number.value

    def _remedy(self, column: Column, cell: str) -> str:
        if column.kind is Kind.COVARIATE and read_direction(cell):
            return "call the column approach"
        if column.kind is Kind.COVARIATE:
            heading = clean(column.heading)
            subject = subject_of_heading(heading)
            if subject is None and numbers_a_thing(heading):
                return "save the readings of each as a table of its own"
            plain = _SIDES if column.name == "approach" else _LEAVE
            return OF_COLUMNS[subject].format(heading) if subject else plain
        if other := self._other_mark(cell):
            return f"write it{other}, as the others"
        return self._write_a_reading(cell)

    def _write_a_reading(self, cell: str) -> str:
        if self.faults.sheet and _ISO_DATE.match(stripped(cell)):
            return _DATE
        numbered = self.layout.of(Kind.CYCLE)  # else nothing would say which cycle is left out
        left_out = _LEAVE_OUT if numbered else _NUMBER_FIRST + _LEAVE_OUT
        if cell.endswith(STRUCK):
            return _STRUCK + left_out
        return _READING + left_out + (_FORMULA if self.faults.sheet and not is_filled(cell) else "")

    def _not_a_number(self, cell: str) -> str:
        if not is_filled(cell):
            return "empty cell"
        if cell.endswith(STRUCK):
            return f"{quoted(cell.removesuffix(STRUCK))} is struck through"
        return f"{quoted(stripped(cell))} is not a number{self._other_mark(cell)}"

    def _other_mark(self, cell: str) -> str:
        """Return the mark that is asked for where a cell is a number but for that."""
        if not self.decimal or not parse_cell(cell) or parse_cell(cell, self.decimal):
            return ""
        return f" with a decimal {'comma' if self.decimal == ',' else 'point'}"

    def _note_mark(self, column: Column, mark: Mark, cell: str, line: int) -> None:
        if mark is not Mark.NONE:
            self.marks.setdefault(mark, (line, column.position + 1, stripped(cell)))

    def _note_unit(self, column: Column, unit: str, line: int) -> None:
        seen = self.units.setdefault(column, {})
        if len(seen) < 5:
            seen.setdefault(unit, line)

    def _count(self, column: Column, cell: Cell, line: int) -> float:
        value = cell if isinstance(cell, float) else 0.5
        if isinstance(cell, str):
            number = parse_cell(cell, self.decimal)
            if number is not None and not number.unit:
                value = number.value
                self._note_mark(column, number.mark, cell, line)
        if not _are_counts(np.array([value])):
            what = f"{_shown(cell)} is not a cycle number"
            self.fault(column, what, line, remedy=NUMBER_CYCLES)
            return 0.0
        return value

    def fault(self, column: Column, message: str, line: int | None = None, *, remedy: str) -> None:
        """Add a fault of a column, in its heading where it is of no other line."""
        place = self.layout.header_line if line is None else line
        self.faults.add(message, place, column.position + 1, remedy=remedy)

    def values(self, column: Column) -> npt.NDArray[Any]:
        """Return what a column holds, shape (rows,).

        That is numbers in the units of the file, counts of cycles, instants, or, of a column of
        labels, the place of each row's among those that are distinct.
        """
        kind = _TYPES.get(column.kind, np.float64)
        return _joined(self._parts.setdefault(column, []), kind)

    def labels(self, column: Column) -> Labels:
        """Return the labels of poses or directions, or the remarks of a column, shape (rows,)."""
        kind = object if column.kind is Kind.COMMENT else np.str_  # a remark may be long
        return _frozen(np.array(self.distinct(column), dtype=kind)[self.values(column)])

    def distinct(self, column: Column) -> list[str]:
        """Return each label or remark of a column once, in order of first appearance."""
        return list(self._codes.get(column, ()))

    def fill_poses(self, merged: Container[tuple[int, int]]) -> Iterator[str]:
        """Give rows of no pose that above: in ``merged`` cells, or where cycles begin at names."""
        for column in self.layout.of(Kind.POSE):
            codes, lines, cycles = self.values(column), self.all_lines(), self.layout.of(Kind.CYCLE)
            blank = codes == self._codes.get(column, {}).get("", -1)
            anew = [np.diff(self.values(c), prepend=np.inf) <= 0 for c in cycles]
            once = len({*codes.tolist()}) == 1 + np.sum(~blank)
            sure = once and np.array_equal(anew, [~blank])
            if blank.any() and sure:
                yield f"{column.called} names the pose in the first row of its block"
            for line in [] if sure else lines[blank].tolist():
                if (line, column.position + 1) not in merged:
                    self.fault(column, "an empty cell is not a pose", line, remedy=_LABEL_POSES)
            above = np.maximum.accumulate(np.where(blank, 0, np.arange(len(codes))))
            self._parts[column] = [_frozen(codes[above])]

    def all_lines(self) -> IntArray:
        """Return the line of each row, shape (rows,)."""
        return _joined(self._lines, np.int32)

    @property
    def last_line(self) -> int | None:
        """The line of the last row."""
        lines = self.all_lines()
        return int(lines[-1]) if len(lines) else None


def _joined(parts: list[npt.NDArray[Any]], kind: type[np.generic]) -> npt.NDArray[Any]:
    """Return parts as one array, which takes their place and which a `Run` keeps as it is."""
    if len(parts) != 1:
        parts[:] = [np.concatenate(parts) if parts else np.empty(0, kind)]
    return _frozen(parts[0])


def _frozen(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    values.flags.writeable = False
    return values


def _read_word(kind: Kind, cell: Cell) -> tuple[object, str, str]:
    """Return what a cell of words says, what is wrong with it, and what to do about that."""
    text = f"{cell:.15g}" if isinstance(cell, float) else stripped(cell)
    if kind is Kind.POSE:
        escaped = text[:1] == "'" and text[1:2] in ("'", *FORMULA)
        return text[escaped:], _label_fault(text), _LABEL_POSES
    if kind is Kind.DIRECTION:
        way, remedy = read_direction(text), "write +x, -y and the like in each row"
        fault = "" if way else "is not a direction of approach (+x to -z) as those above it are"
        return way or "", fault, remedy
    if kind is Kind.TIMESTAMP:
        stamp = read_timestamp(text)
        return stamp, "" if stamp else "is not an ISO 8601 time", _WRITE_TIMES
    if kind is Kind.NAMELESS:
        remedy = "name the column in the header, or remove what is in it"
        empty = not text or is_dash(text)
        return "", "" if empty else "in a column without a name", remedy
    if kind is Kind.LABEL:
        return text, "" if text else "is not a label", "write a name in each row"
    return text, "", ""


def _label_fault(label: str) -> str:
    if names_a_footer(label):
        return "is the label of a footer, not of a pose"
    if len(label) > _LABEL:
        return f"is longer than the {_LABEL} characters of a pose label"
    if label[:1] in ("=", "@") or (label[:1] in ("+", "-") and parse_cell(label) is None):
        return "is a formula, not a pose"
    return ""


def _shown(cell: Cell) -> str:
    if isinstance(cell, float):
        return f"{cell:.15g}"
    return quoted(cell) if is_filled(cell) else "an empty cell"


def _is_sized(column: Column) -> bool:
    return column.kind in (Kind.AXIS, Kind.COMMAND)


def _are_counts(values: FloatArray) -> bool:
    return bool(np.all((values >= 0) & (values < _LARGEST) & (values == np.floor(values))))


def is_words(cell: Cell) -> bool:
    """Say whether a cell is a remark: it begins with a letter and spells no number."""
    text = stripped(cell) if isinstance(cell, str) else ""
    return text[:1].isalpha() and parse_cell(text) is None


TWO, RARE = 2, 0.2
"""A column that marks some rows has two values, and one of them is rare."""
_WHICH = "say which mark is the decimal one: `decimal=,` or `decimal=.`"
_ALIKE = f"write them alike; where one mark groups thousands, {_WHICH}"
_TENTHS = 10
"""Two digits behind a comma."""


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
