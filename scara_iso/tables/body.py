"""The rows under the header: which are readings, which are footers, and which are neither."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from scara_iso.tables.columns import Columns, is_words
from scara_iso.tables.faults import KEPT, REMARK, quoted
from scara_iso.tables.grid import (
    Cell,
    CellGrid,
    Delimiter,
    Line,
    Row,
    check_length,
    is_comment,
    is_dash,
    is_filled,
    is_rule,
    split_columns,
    split_each,
    stripped,
    text_row,
)
from scara_iso.tables.layout import header_cells, names_an_axis
from scara_iso.tables.names import Kind, count_in_words
from scara_iso.tables.numbers import parse_cell
from scara_iso.tables.sentences import strikes_its_row
from scara_iso.tables.statements import refuse_below, refuse_unused
from scara_iso.tables.words import names_a_footer

_NOTES = 50
_STRANGE, _STRANGE_ROWS = 30_000, 20
"""Cells in rows that are not readings, beyond which a file is not read on: a few seconds' work.

As many rows of the header's width may be there, such as footers of a very wide table.
"""
_ONE_HEADER = "name each column in one header row, right above the first row of readings"
_ONE_TABLE = "leave one table in the file, and only readings under its header"


class Body:
    """Sort the rows under a header; ``notes`` and ``below`` are what it met besides readings."""

    def __init__(self, columns: Columns) -> None:
        self.columns, self.faults = columns, columns.faults
        self.layout = layout = columns.layout
        self.notes: list[str] = []
        self._aside: dict[str, Row] = {}
        self.below: list[Row] = []
        self.doubts: list[str] = []
        self.summaries: list[Row] = []
        self.repeats: list[int] = []
        self.footer: int | None = None
        if layout.words_below:
            self.faults.first_remedy = _ONE_HEADER
        self._header = [column.heading for column in layout.columns]
        self._cycle = next((c.position for c in layout.of(Kind.CYCLE)), None)
        remarks = {c.position for c in layout.of(Kind.COMMENT, Kind.NAMELESS)}
        needed = (k for k in range(layout.width, 0, -1) if k - 1 not in remarks)
        self._least = next(needed, layout.width)
        self._words: tuple[str, str] | None = None
        self._blanks = False
        self._blocks = [0]
        self._labels: set[str] = set()
        self._strange = 0

    @property
    def aside(self) -> list[Row]:
        """What stands in columns without a name and behind the last one, with the line."""
        return [*self.columns.aside.values(), *self._aside.values()]

    def note(self, text: str) -> None:
        """Add to the notes, of which the first fifty are kept."""
        if len(self.notes) < _NOTES:
            self.notes.append(text)
        elif len(self.notes) == _NOTES:
            self.notes.append("and more of the kind")

    def read(self, grid: CellGrid) -> None:
        """Take the rows of a grid below the header, those of a text piece by piece."""
        begin, self._blanks = self.layout.data_line, grid.delimiter is Delimiter.BLANKS
        if grid.lines is not None:
            self.columns.add(list(self._readings(row for row in grid.lines if row[0] >= begin)))
        elif grid.text is not None and grid.delimiter is not None:
            for first, lines in grid.text.pieces():
                skip = max(0, begin - first)
                self._read_lines(first + skip, lines[skip:], grid.delimiter)

    def _read_lines(self, first: int, lines: list[str], delimiter: Delimiter) -> None:
        before = self.faults.total
        check_length(first, lines, self.faults)
        if not lines or self.faults.total > before:
            return
        labels = self.layout.of(Kind.POSE, Kind.COMMENT)
        if self.footer is None and not (self._cycle is None and labels):
            cells = split_columns(lines, delimiter, self.layout.width)
            if cells is not None and self.columns.add_clean(cells, first):
                self._blocks[-1] += len(lines)
                return
        self.columns.add(list(self._readings(split_each(first, lines, delimiter, self.faults))))

    def _readings(self, rows: Iterable[Line]) -> Iterator[Line]:
        """Yield line and cells of the rows of readings, each as wide as the header."""
        for line, cells in map(self._counted, rows):
            numbered = self._is_numbered(cells)
            self._count_strange(line, cells, numbered=numbered)
            first = cells[0] if cells else ""
            if numbered and not (isinstance(first, str) and is_comment(stripped(first))):
                yield from self._reading(line, cells)
                continue
            row = text_row(line, cells)
            if not row.text:
                self._blocks.append(0)
            elif kind := self._is_besides(row):
                self.note(f"{self.faults.row} {line}: {kind}")
                self.below = [*self.below[: _NOTES - 1], row]
            else:
                yield from self._reading(line, cells)

    def _counted(self, row: Line) -> Line:
        """Return a row with the bare number of its cycle, in the words of the first row's."""
        cell = self._number_of(row[1])
        number, words = count_in_words(cell) if isinstance(cell, str) else ("", ("", ""))
        if self._words is None and is_filled(cell):
            self._words = words
        if not number or words != self._words:
            return row
        return row[0], [number if k == self._cycle else one for k, one in enumerate(row[1])]

    def _count_strange(self, line: int, cells: Sequence[Cell], *, numbered: bool) -> None:
        """Bound the work that a file without readings makes; other poses' empty cells are none."""
        width = self.layout.width
        if numbered and len(cells) >= width and not any(map(is_filled, cells[width:])):
            return
        self._strange += len(cells)
        most = max(_STRANGE, _STRANGE_ROWS * width)
        if self._strange > most:
            message = f"more than {most} cells in rows that are not readings"
            self.faults.add(message, line, remedy=_ONE_TABLE)
            self.faults.check()

    def _is_besides(self, row: Row) -> str:
        if header_cells(row.cells) == self._header:
            return self._repeated(row.line)
        if is_comment(row.text):
            refuse_below(row, self.faults)
            return f"comment {quoted(row.text, REMARK)} not used"
        if footer := self._is_footer(row):
            self.footer = self.footer or row.line
        elif names_an_axis(row.cells):
            self.faults.add("a second table begins", row.line, remedy=_ONE_TABLE)
        elif not self._is_remark(row):
            label = str(self._number_of(row.cells))  # with a unit, as 3 s, it is no cycle's
            footer = bool(is_words(label) or parse_cell(label)) and any(map(parse_cell, row.cells))
            if not footer:
                ruled = is_rule(row.text) and (self._cycle is not None or not any(self._blocks))
                return "ruled line" if ruled else ""
            self.summaries.append(row)
        if footer:
            refuse_unused(row, self.faults)
            return f"footer {quoted(row.text)} not averaged"
        return f"{quoted(row.text, REMARK)} not used"

    def _repeated(self, line: int) -> str:
        if self._cycle is None:
            what = "a second table begins: the header again, and no cycle numbers"
            self.faults.add(what, line, remedy=_ONE_TABLE)
        self.repeats = [*self.repeats[: KEPT - 1], line]
        return "header repeated"

    def _number_of(self, cells: Sequence[Cell]) -> Cell:
        return cells[self._cycle] if self._cycle is not None and self._cycle < len(cells) else ""

    def _is_numbered(self, cells: Sequence[Cell]) -> bool:
        cell = self._number_of(cells)
        number = None if isinstance(cell, float) else parse_cell(cell)
        return isinstance(cell, float) or (
            number is not None and number.unit.isascii() and number.unit != "s"
        )

    def _is_footer(self, row: Row) -> bool:
        """Return whether the first text of a row is the label of a footer, such as ``Mean``."""
        if self._cycle is None and self._is_sentence(row):
            return True  # where no cycle is numbered it may stand for a reading, if more follow
        label = next((t for t in map(stripped, row.cells) if t and parse_cell(t) is None), "")
        below = self.footer is not None and self._cycle is not None
        if not names_a_footer(label, short=self._cycle is not None) and not (
            below and label and not names_an_axis(row.cells)
        ):
            return False
        if self._cycle is None and label in self._labels:
            what = f"{quoted(label)} again: a pose or a footer?"
            self.faults.add(what, row.line, remedy="number the cycles")
        self._labels.add(label)
        return True

    def _is_remark(self, row: Row) -> bool:
        """Return whether a row is a line of text such as ``Inspector: A. Smith``."""
        found, before = list(filter(stripped, row.cells)), self.faults.total
        stated = refuse_below(row, self.faults)
        if self._is_sentence(row) or self.faults.total > before:
            return True
        numbers = any(map(parse_cell, found)) or ":" not in found[0]
        return bool(stated) and not numbers and (len(found) <= 2 or len(stated) > 1)

    def _is_sentence(self, row: Row) -> bool:
        """Return whether a row of several columns holds nothing but words, and no digit.

        A single word may stand for a reading, as ``error``, unless the cycles are numbered; then
        a sentence may hold numbers too, and the blanks of a table that they part.
        """
        found = list(filter(stripped, row.cells))
        numbered = self._cycle is not None
        axes = [row.cells[c.position : c.position + 1] for c in self.layout.of(Kind.AXIS)]
        if self._blanks and numbered and not all(cells and parse_cell(cells[0]) for cells in axes):
            found = [" ".join(found)]
        alone = len(found) == 1 < self.layout.width and (
            not any(map(str.isdigit, found[0]))
            or (numbered and (found[0].strip()[0].isalpha() or not found[0].isascii()))
        )
        is_event = numbered and found[0].isalpha() and not strikes_its_row(found[0])
        in_words = len(found[0].split()) > 1 or (numbered and not found[0].isascii())
        return alone and (in_words or is_event)

    def _reading(self, line: int, cells: Sequence[Cell]) -> Iterator[Line]:
        width = self.layout.width
        behind = enumerate(cells[width:], width)
        extra = [k for k, cell in behind if is_filled(cell) and not is_dash(cell)]
        if self.footer is not None:
            what = f"readings below the footer of {self.faults.row} {self.footer}"
            self.faults.add(what, line, remedy=_ONE_TABLE)
        elif len(cells) < self._least:
            what = f"{len(cells)} fields, the header has {width}"
            self.faults.add(what, line, remedy=_TOO_FEW)
        elif extra and not all(is_words(cells[k]) for k in extra):
            what = f"{max(extra) + 1} fields, the header has {width}"
            remedy = _UNHEADED if self.faults.sheet else _TOO_MANY
            self.faults.add(what, line, extra[0] + 1, remedy=remedy)
        else:
            if extra:
                row = text_row(line, [c if k in extra else "" for k, c in enumerate(cells)])
                self._aside[row.text] = row
            self._blocks[-1] += 1
            yield line, [*cells[:width], *[""] * (width - len(cells))]

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


_TOO_MANY = (
    "if these are decimal commas in a comma-separated table, export it with semicolons; "
    "else make the fields as many as the header's"
)
_UNHEADED = "remove what stands beside the table, or head each of its columns"
_TOO_FEW = "make the fields of each row as many as the header's; remove lines that are not readings"
