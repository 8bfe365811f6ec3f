"""The rows under the header: which are readings, which are footers, and which are neither."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from scara_iso.tables.columns import Cell, is_words
from scara_iso.tables.faults import KEPT, Faults, quoted
from scara_iso.tables.footers import names_a_footer
from scara_iso.tables.layout import Layout, header_cells, is_comment, is_rule, names_an_axis
from scara_iso.tables.names import Kind
from scara_iso.tables.numbers import BLANKS, parse_cell
from scara_iso.tables.preamble import read_statement, read_statements
from scara_iso.tables.statements import is_of_axes
from scara_iso.tables.text import Row

_NOTES = 50
_STRANGE, _STRANGE_ROWS = 30_000, 20
"""Cells in rows that are not readings, beyond which a file is not read on: a few seconds' work.

As many rows of the header's width may be there, such as footers of a very wide table.
"""
_ONE_HEADER = "name each column in one header row, right above the first row of readings"
_ABOVE = "write this line above the header"
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
            statement = read_statement(Row(line, texts, text, line))
            if statement and is_of_axes(statement[0]):
                self.faults.add(f"{quoted(text)} under the header", line, remedy=_ONE_TABLE)
            self.note(f"{self.faults.row} {line}: comment {quoted(text)} not used")
        elif self._is_footer(line, texts):
            self.footer = self.footer or line
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
        if self._is_sentence(found):
            return True
        text = ", ".join(found)
        stated = read_statements(Row(line, texts, text, line)) if ":" in found[0] else []
        if any(is_of_axes(key) for key, _ in stated):
            self.faults.add(f"{quoted(text)} under the header", line, remedy=_ABOVE)
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
