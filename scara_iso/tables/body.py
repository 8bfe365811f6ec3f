"""The rows under the header: which are readings, which are footers, and which are neither.

Whether points and commas can be decimal marks or group thousands: refused where both can be.

What the delimiter and the end of a text may have done to its numbers, and is refused.
"""

from __future__ import annotations

import csv
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.run import FloatArray, Run
from scara_iso.tables.columns import Cell, Columns, is_words
from scara_iso.tables.faults import KEPT, Faults, names_a_footer, quoted, refuse
from scara_iso.tables.layout import Layout, header_cells, is_comment, is_rule, names_an_axis
from scara_iso.tables.names import Column, Kind
from scara_iso.tables.numbers import BLANKS, Mark, count_decimals, parse_cell
from scara_iso.tables.preamble import RESOLUTION, read_preamble, read_statement, read_statements
from scara_iso.tables.statements import is_of_axes, refuse_unused
from scara_iso.tables.text import Delimiter, Row, split_lines

WHICH_MARK = "say which mark is the decimal one: `decimal=,` or `decimal=.`"


def refuse_other_marks(decimal: str | None) -> None:
    """Raise `UsageError` for what is given as the decimal mark and is none."""
    if decimal not in (None, ",", "."):
        raise UsageError(f"decimal mark {decimal!r}", remedy="use ',' or '.'")


def check_marks(
    columns: Columns, decimal: str | None, faults: Faults, sizes: Iterable[str]
) -> None:
    """Refuse commas that may group thousands, and commas beside points.

    A decimal comma in one of the ``sizes`` that the file states, as 0,001, says what commas are.
    """
    marks = columns.marks
    if decimal is not None:
        return
    if are_mixed(marks):
        for mark, (line, column, text) in marks.items():
            faults.add(
                f"{quoted(text)} with {mark.value}: commas and points "
                "both occur, `decimal=` says which is decimal",
                line,
                column,
                remedy=WHICH_MARK,
            )
    elif are_undecided(marks) and not any(map(_has_decimal_comma, sizes)):
        line, column, text = marks[Mark.EITHER]
        faults.add(
            f"{quoted(text)} could have a decimal comma or group "
            "thousands: `decimal=,` or `decimal=.` says which",
            line,
            column,
            remedy=WHICH_MARK,
        )


def _has_decimal_comma(size: str) -> bool:
    number = parse_cell(size)
    return number is not None and number.mark is Mark.COMMA


def are_mixed(marks: Container[Mark]) -> bool:
    """Say whether commas and points both occur."""
    comma = Mark.COMMA in marks or Mark.EITHER in marks
    return Mark.BOTH in marks or (comma and Mark.POINT in marks)


def are_undecided(marks: Container[Mark]) -> bool:
    """Say whether every comma may group thousands."""
    return Mark.EITHER in marks and Mark.COMMA not in marks


def check_groups(columns: Columns, run: Run, faults: Faults) -> None:
    """Refuse 1.512 um between semicolons, which may be 1512: few dials show such a small step."""
    for column in columns.layout.of(Kind.AXIS) if Mark.POINT in columns.marks else ():
        values, unit = np.abs(columns.numbers(column)), run.origin.units[column.name]
        if unit == "um" and not _on_divisions(run, column.name) and may_be_grouped(values):
            faults.add(
                f"{values[values != np.round(values)][0]:.3f} um could have a decimal point or "
                "group thousands: `decimal=.` or `decimal=,` says which",
                int(columns.all_lines()[0]),
                column.position + 1,
                remedy=f"{WHICH_MARK}; or state the dial's resolution",
            )
    faults.check()


def _on_divisions(run: Run, name: str) -> bool:
    """Say whether the readings are multiples of a resolution that is stated."""
    axis = run.axes[name]
    if axis.resolution is None:
        return False
    divisions = axis.shown / axis.resolution
    return bool(np.allclose(divisions, np.round(divisions), rtol=0, atol=1e-3))


def may_be_grouped(values: FloatArray) -> bool:
    """Say whether all that are no whole numbers are spelt as 1.512 or 23.040 is."""
    parted = values[values != np.round(values)]
    thousandths = np.isclose(parted * 1000, np.round(parted * 1000), rtol=0, atol=1e-6)
    fine = np.round(parted, 2) != parted
    return bool(fine.any() and thousandths.all() and parted.min() >= 1 and parted.max() < 1000)


_NOTES = 50
_STRANGE, _STRANGE_ROWS = 30_000, 20
"""Cells in rows that are not readings, beyond which a file is not read on: a few seconds' work.

As many rows of the header's width may be there, such as footers of a very wide table.
"""
_ONE_HEADER = "name each column in one header row, right above the first row of readings"
_WRITE_ABOVE = "write this line above the header"
_ONE_TABLE = "leave one table in the file, and only readings under its header"


class Body:
    """Sort the rows under a header; keeps what it met besides readings in ``notes``."""

    def __init__(self, layout: Layout, faults: Faults) -> None:
        self.layout = layout
        self.faults = faults
        self.notes: list[str] = []
        self.repeats: list[int] = []
        self.footer: int | None = None
        if layout.words_below:
            faults.first_remedy = _ONE_HEADER
        self._cycle = next((c.position for c in layout.of(Kind.CYCLE)), None)
        self._blocks = [0]
        self._labels: set[str] = set()
        self._strange = 0

    @property
    def plain(self) -> bool:
        """Whether a row of numbers can only be a reading, so far."""
        labels = self.layout.of(Kind.POSE, Kind.COMMENT)
        return self.footer is None and not (self._cycle is None and labels)

    def count(self, rows: int) -> None:
        """Take note of ``rows`` readings that were taken without `sort`."""
        self._blocks[-1] += rows

    def note(self, text: str) -> None:
        """Add to the notes, of which the first fifty are kept."""
        if len(self.notes) < _NOTES:
            self.notes.append(text)
        elif len(self.notes) == _NOTES:
            self.notes.append("and more of the kind")

    def sort(self, rows: Iterable[tuple[int, Sequence[Cell]]]) -> Iterator[tuple[int, list[Cell]]]:
        """Yield line and cells of the rows of readings, each as wide as the header."""
        for line, cells in rows:
            self._count_strange(line, cells)
            texts = [cell if isinstance(cell, str) else repr(cell) for cell in cells]
            comment = bool(texts) and is_comment(_stripped(texts[0]))
            if self._is_numbered(cells) and not comment:
                yield from self._reading(line, cells)
                continue
            text = ", ".join(t for t in map(_stripped, texts) if t)
            if not text:
                self._blocks.append(0)
            elif not self._is_besides(line, texts, text):
                yield from self._reading(line, cells)

    def _count_strange(self, line: int, cells: Sequence[Cell]) -> None:
        """Bound the work that a file without readings makes."""
        width = self.layout.width
        beside = any(map(_is_filled, cells[width:]))  # another pose's empty cells are none
        if len(cells) >= width and not beside and self._is_numbered(cells):
            return
        self._strange += len(cells)
        most = max(_STRANGE, _STRANGE_ROWS * width)
        if self._strange > most:
            message = f"more than {most} cells in rows that are no readings"
            self.faults.add(message, line, remedy=_ONE_TABLE)
            self.faults.check()

    def _is_besides(self, line: int, texts: list[str], text: str) -> bool:
        """Return whether a row is not a reading, and say what it is."""
        if tuple(header_cells(texts)) == self.layout.header:
            self._repeated(line)
        elif is_comment(text):
            row = Row(line, texts, text, line)
            statement = read_statement(row)
            if statement and is_of_axes(statement.key):
                self.faults.add(f"{quoted(text)} under the header", line, remedy=_ONE_TABLE)
            refuse_unused([row], self.faults)
            self.note(f"{self.faults.row} {line}: comment {quoted(text)} not used")
        elif self._is_footer(line, texts):
            self.footer = self.footer or line
            refuse_unused([Row(line, texts, text, line)], self.faults)
            self.note(f"{self.faults.row} {line}: footer {quoted(text)} not averaged")
        elif names_an_axis(texts):
            self.faults.add("a second table begins", line, remedy=_ONE_TABLE)
        elif self._is_remark(line, texts):
            self.note(f"{self.faults.row} {line}: {quoted(text)} not used")
        elif is_rule(text) and (self._cycle is not None or not any(self._blocks)):
            self.note(f"{self.faults.row} {line}: ruled line")
        else:
            return False
        return True

    def _repeated(self, line: int) -> None:
        if self._cycle is None:
            self.faults.add(
                "a second table begins: the header again, and no cycle numbers",
                line,
                remedy=_ONE_TABLE,
            )
        self.repeats = [*self.repeats[: KEPT - 1], line]
        self.note(f"{self.faults.row} {line}: header repeated")

    def _is_numbered(self, cells: Sequence[Cell]) -> bool:
        cell = cells[self._cycle] if self._cycle is not None and self._cycle < len(cells) else ""
        return isinstance(cell, float) or parse_cell(cell) is not None

    def _is_footer(self, line: int, texts: list[str]) -> bool:
        """Return whether the first text of a row is the label of a footer, such as ``Mean``."""
        if self._cycle is None and self._is_sentence([t for t in texts if t.strip(BLANKS)]):
            return True  # where no cycle is numbered it may stand for a reading, if more follow
        label = next((t for t in map(_stripped, texts) if t and parse_cell(t) is None), "")
        below = self.footer is not None and self._cycle is not None and not names_an_axis(texts)
        if not names_a_footer(label, short=self._cycle is not None) and not (below and label):
            return False
        if self._cycle is None and label in self._labels:
            self.faults.add(
                f"{quoted(label)} again: a pose or a footer?", line, remedy="number the cycles"
            )
        self._labels.add(label)
        return True

    def _is_remark(self, line: int, texts: list[str]) -> bool:
        """Return whether a row is a line of text such as ``Inspector: A. Smith``."""
        found = [text for text in texts if text.strip(BLANKS)]
        text = ", ".join(found)
        row = Row(line, texts, text, line)
        sentence = self._is_sentence(found)
        stated = read_statements(row) if sentence or ":" in found[0] else []
        if any(is_of_axes(one.key) for one in stated):
            self.faults.add(f"{quoted(text)} under the header", line, remedy=_WRITE_ABOVE)
            return True
        before = self.faults.total
        refuse_unused([row], self.faults)
        if sentence or self.faults.total > before:
            return True
        numbers = any(parse_cell(text) for text in found)
        return bool(stated) and not numbers and (len(found) <= 2 or len(stated) > 1)

    def _is_sentence(self, found: list[str]) -> bool:
        """Return whether a row of several columns holds nothing but words, and no digit."""
        alone = len(found) == 1 < self.layout.width
        return alone and len(found[0].split()) > 1 and not any(c.isdigit() for c in found[0])

    def _reading(self, line: int, cells: Sequence[Cell]) -> Iterator[tuple[int, list[Cell]]]:
        width = self.layout.width
        if self.footer is not None:
            self.faults.add(
                f"readings below the footer of {self.faults.row} {self.footer}",
                line,
                remedy=_ONE_TABLE,
            )
            return
        if len(cells) < width:
            self.faults.add(
                f"{len(cells)} fields, the header has {width}",
                line,
                remedy=_ragged(len(cells), width),
            )
            return
        extra = [k for k, cell in enumerate(cells[width:], width) if _is_filled(cell)]
        if extra and all(is_words(cells[k]) for k in extra):
            said = quoted(str(cells[extra[0]]))
            self.note(f"{self.faults.row} {line}: {said} beside the table not used")
            extra = []
        if extra:
            self.faults.add(
                f"{max(extra) + 1} fields, the header has {width}",
                line,
                extra[0] + 1,
                remedy=_ragged(max(extra) + 1, width),
            )
            return
        self._blocks[-1] += 1
        yield line, list(cells[:width])

    def check_blocks(self) -> None:
        """Refuse blocks of unequal size between blank lines where no cycle is numbered.

        The last row of such a table may be a mean without a name.
        """
        blocks = [size for size in self._blocks if size]
        if self._cycle is None and len(set(blocks)) > 1:
            self.faults.add(
                "blank lines part the rows unequally and no cycle is numbered: "
                "readings or a summary?",
                remedy="number the cycles in a column 'cycle', or remove the blank lines",
            )


def _stripped(text: str) -> str:
    return text.strip(BLANKS)


def _is_filled(cell: Cell) -> bool:
    return not isinstance(cell, str) or bool(cell.strip(BLANKS))


def _ragged(found: int, width: int) -> str:
    if found > width:
        return (
            "if these are decimal commas in a comma-separated table, export it with semicolons; "
            "else make the fields as many as the header's"
        )
    return "make the fields of each row as many as the header's; remove a line that is no reading"


_LINES_ABOVE = 200
_TENTHS = 10
"""Two digits behind a comma."""


@dataclass(frozen=True, slots=True)
class Delimited:
    """How the rows of a text are parted, how many lines it has, the last ones, and the end."""

    lines: int
    size: int
    """Characters."""
    last: Sequence[str]
    """At most the two hundred last."""
    delimiter: Delimiter
    ended: bool
    """Whether the last line is ended."""

    def most_rows(self, width: int) -> int:
        """Return how many rows of ``width`` fields there can be: a field takes a character."""
        return min(self.lines, self.size // max(width, 1) + 1)

    def check_end(
        self, head: Sequence[Row], columns: Columns, body: Body, resolution: float | None
    ) -> None:
        """Find a file that was cut inside its last number: no line end, and too few decimals.

        A reading is refused that lacks decimals which a stated resolution and every one above have.
        Of other readings with fewer than most above, and numbers with fewer than each, a note is
        made.
        """
        line, last = self.lines, columns.layout.columns[-1]
        if self.ended or columns.last_line != line:
            return
        rows = [row for _, row in split_each(1, self.last, self.delimiter, Faults(""))]
        if last.position < len(rows[-1]) - 1:  # another pose's cells follow
            return
        *above, decimals = [_decimals(row, last.position) for row in rows]
        known = [count for count in above if count is not None]
        middle = (len(known) - 1) // 2 if last.kind is Kind.AXIS else 0
        usual = sorted(known)[middle] if known else 0
        if decimals is None or decimals >= usual:
            return
        what = f"no line end, and {decimals} decimals where others have {usual}: is the file cut?"
        stated, _ = read_preamble(head, columns.layout.header_line, Faults(""))
        steps = [one.value for key, one in stated.items() if key.startswith(RESOLUTION)]
        steps += [] if resolution is None else [str(resolution)]
        if last.kind is Kind.AXIS and set(known) <= set(map(count_decimals, steps)):
            remedy = "get the whole file; if it is whole, end its last line"
            columns.faults.add(what, line, last.position + 1, remedy=remedy)
        else:
            body.note(f"line {line}: {what}")

    def check_numbers(self, run: Run, columns: Columns) -> None:
        """Refuse numbers that are others where the delimiter, or a point, is the other locale's."""
        if self.delimiter is Delimiter.COMMA and not columns.marks:
            _check_split(run, columns)
        if self.delimiter in (Delimiter.SEMICOLON, Delimiter.TAB):
            check_groups(columns, run, columns.faults)

    def said(self, columns: Columns, decimal: str | None) -> str:
        """Return which mark of the numbers was taken for the decimal one."""
        if decimal is not None:
            return "decimal comma as asked" if decimal == "," else "decimal point as asked"
        commas = columns.marks.keys() & {Mark.COMMA, Mark.EITHER}
        return "decimal comma" if commas else "decimal point"


def delimited(pieces: Sequence[str], delimiter: Delimiter, ended: bool) -> Delimited:
    """Return what is to be known of a text once its ``pieces`` are gone."""
    last: list[str] = []
    for piece in reversed(pieces):
        last = [*piece.split("\n"), *last]
        if len(last) >= _LINES_ABOVE:
            break
    count = len(pieces) + sum(piece.count("\n") for piece in pieces)
    size = count + sum(map(len, pieces))
    return Delimited(count, size, last[-_LINES_ABOVE:], delimiter, ended)


def split_each(
    first: int, lines: Sequence[str], delimiter: Delimiter, faults: Faults
) -> Iterator[tuple[int, list[Cell]]]:
    """Yield number and cells of each line, from the ``first`` on; a broken quote is a fault."""
    for line, text in enumerate(lines, first):
        try:
            yield line, list(split_lines([text], delimiter)[0])
        except csv.Error as error:
            faults.add(f"{error}: {quoted(text)}", line, remedy="close or remove the quote")


def _decimals(row: Sequence[Cell], position: int) -> int | None:
    cell = row[position] if len(row) > position else ""
    return count_decimals(cell) if isinstance(cell, str) else None


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
            message = f"{axis.name} never changes and {_called(beside, columns)} is whole: "
            remedy = "say `decimal=.` if the numbers are whole"
            raise refuse(columns.faults.where, f"{message}split decimal commas?", remedy=remedy)


def _called(column: Column, columns: Columns) -> str:
    return column.name if column.kind is Kind.AXIS else columns.layout.header[column.position]


def _whole_numbers(column: Column, columns: Columns) -> FloatArray | None:
    """Return the whole numbers that a column holds, in sizes; None for another or the time."""
    if column.kind is Kind.COMMENT:
        labels = columns.distinct(column)
        whole = all(map(str.isdecimal, labels))
        return np.array(labels, dtype=np.float64)[columns.codes(column)] if whole else None
    if column.kind not in (Kind.AXIS, Kind.COVARIATE) or column.name == "time_s":
        return None
    values = np.abs(columns.numbers(column))
    return values if np.array_equal(values, np.round(values)) else None
