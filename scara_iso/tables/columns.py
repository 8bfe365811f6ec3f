"""Cells to arrays: the quick way for clean pieces, cell by cell where a fault must be named."""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scara_iso.run import FloatArray, IntArray, read_direction
from scara_iso.tables.faults import NUMBER_CYCLES, OF_COLUMNS, STRUCK, Faults, quoted
from scara_iso.tables.grid import Cell, Line, Row, is_dash, is_filled, stripped, text_row
from scara_iso.tables.layout import Layout
from scara_iso.tables.names import Column, Kind, read_timestamp, read_unit
from scara_iso.tables.numbers import FORMULA, Mark, cut_unit, parse_cell, parse_clean
from scara_iso.tables.words import clean, names_a_footer, numbers_a_thing, subject_of_heading

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
_REMARK = 60  # where a remark says that its row does not count, and of which pose it is
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
        return _frozen(np.array(self.distinct(column), dtype=np.str_)[self.values(column)])

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
    return text[:_REMARK], "", ""


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
