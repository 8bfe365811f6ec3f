"""The rows under the header: readings, footers, neither; and what lines and remarks say of them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np
import numpy.typing as npt

from scara_iso.base.quantities import Unit
from scara_iso.run import FloatArray, Run, common_step
from scara_iso.tables.columns import RARE, TWO, Columns, is_words
from scara_iso.tables.grid import (
    KEPT,
    LEAVE_OUT,
    LEAVE_ROWS_OUT,
    ONE_COLUMN,
    Cell,
    CellGrid,
    Delimiter,
    Faults,
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
from scara_iso.tables.statements import (
    OTHER_SIZE,
    RECORDER,
    KeyValue,
    is_plain,
    read_statements,
    refuse_below,
    refuse_unused,
)
from scara_iso.tables.vocabulary.names import (
    Column,
    Kind,
    count_in_words,
    header_cells,
    is_axis,
    length_in_mm,
    names_an_axis,
    names_another_unit,
    names_some,
    read_unit,
)
from scara_iso.tables.vocabulary.sentences import (
    SENTENCE,
    affirms,
    axes_in_words,
    counts_some_cycles,
    equates_axes,
    holds_an_open_number,
    holds_an_open_ratio,
    may_be_of_readings,
    names_one_of,
    speaks_of_cycles,
    speaks_of_size,
    strikes_its_row,
    without_explained,
)
from scara_iso.tables.vocabulary.words import (
    LONGEST_LINE,
    WORDS,
    clean,
    count_decimals,
    is_of_another,
    is_of_axes,
    names_a_footer,
    names_a_limit,
    numbers_a_thing,
    parse_cell,
    plain_heading,
    quoted,
    quoted_whole,
    subject_of_heading,
    topic_of,
)

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
            return f"comment {quoted_whole(row.text)} not used"
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
        return f"{quoted_whole(row.text)} not used"

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
_FACTORS = (0.5, 2.0)
"""Numbers that readings may be multiplied by."""


def check_remarks(columns: Columns, others: Iterable[Row], *, discarded: int = 1) -> None:
    """Add each remark that says of its row that it does not count; the ``discarded`` first do not.

    ``others`` are what stands behind the columns of the rows.
    """
    leave_out = LEAVE_OUT if discarded else f"{LEAVE_ROWS_OUT}, and the"
    lines = columns.all_lines()
    remarks = [(r.text, r.line, 1 + [*map(bool, r.cells)].index(True)) for r in others]
    for column in columns.layout.of(Kind.COMMENT):
        texts, known = columns.labels(column), columns.distinct(column)
        of_what_counts = affirms(plain_heading(clean(column.heading)))  # an x under OK
        if of_what_counts or (len(known) == 1 and not discarded):  # of every row it strikes none
            continue
        struck = set(filter(strikes_its_row, known))
        rows = zip(texts.tolist(), lines.tolist(), strict=True)
        remarks += [(text, line, column.position + 1) for text, line in rows if text in struck]
        if len(known) > 1 and all(map(is_axis, known)):
            what = f"{column.called} names the axis of each row"
            columns.fault(column, what, remedy=ONE_COLUMN)
        if mark := _rare_mark(texts[discarded:]):
            what = f"{quoted(mark)} in few rows, another word in all others: do all of them count?"
            first = int(lines[discarded:][texts[discarded:] == mark][0])
            columns.fault(column, what, first, remedy=f"{leave_out} column")
    for remark, line, place in remarks:
        if line not in lines[:discarded] and strikes_its_row(remark):
            what = f"{quoted_whole(remark)}, and readings of this {columns.faults.row} are counted"
            columns.faults.add(what, line, place, remedy=f"{leave_out} remark")


def rare_remarks(columns: Columns, column: Column) -> list[tuple[int, str]]:
    """Return line and text of what a column says at a fifth of its rows or fewer, quoted."""
    texts, lines = columns.labels(column), columns.all_lines()
    known, counts = np.unique(texts, return_counts=True)
    rows = np.flatnonzero(texts != ("" if "" in known else known[counts.argmax()]))
    few = rows if len(rows) <= RARE * len(texts) else rows[:0]
    return [(int(lines[k]), quoted_whole(texts[k])) for k in few]


Readings = Mapping[str, FloatArray]


def rows_in_words(
    readings: Readings,
    units: Iterable[Unit],
    faults: Faults,
    lines: Sequence[Row],
    run: Run | None = None,
) -> list[str]:
    """Return what lines of words, wherever they stand, say of some of the rows or of all."""
    parts = list(run.rows_by_pose()) if run else []
    poses, sizes = [str(label) for label, _ in parts], {rows.size for _, rows in parts}
    between = range(*run.lines[[0, -1]].tolist()) if run and run.lines is not None else range(0)
    rows, found = max(map(len, readings.values()), default=0), []
    is_step, lengths = partial(_is_step_of, readings), {*units}
    title = min((row.line for row in lines if row.line not in between), default=0)
    title = title if title <= between.start or not between else 0
    for row in lines:
        stated = read_statements(row)
        keys = [one.key for one in stated]
        own = any(k in WORDS["remark"]["own"] or k.startswith(RECORDER) for k in keys)
        if own or any(map(is_of_axes, keys)) or any(map(is_plain, stated)):
            continue
        matters = speaks_of_cycles(row.text, rows) or speaks_of_size(row.text)
        matters = matters or holds_an_open_ratio(row.text) or _is_of_an_axis(row, stated, readings)
        matters = matters or _is_of_some(row, stated, poses, between)
        free = [one.value for one in stated if is_free_key(one.written, one.key)]
        free = free if stated else [" ".join(filter(None, row.cells))]
        matters = matters or any(counts_some_cycles(text, sizes or {rows}) for text in free)
        matters = matters or any(names_another_unit(text, lengths) for text in free)
        found_in = filter(None, map(parse_cell, row.cells))
        numbers = [one for one in found_in if " " not in one.unit]
        names = [key for key in keys if key not in WORDS["column"]["comment"]]
        sentence: float = SENTENCE if names else 1 if row.text[:1] in "*†" else TWO
        sentence = math.inf if row.line == title or numbers else sentence
        matters = matters or any(may_be_of_readings(text, sentence) for text in free)
        if not is_comment(row.text) and not any(one.unit.isascii() for one in numbers):
            matters = matters or (not keys and holds_an_open_number(row.text, rows, is_step))
            matters = matters or any(_is_open(one, readings, rows, is_step) for one in stated)
        if matters:
            found.append(f"{faults.place(row.line)} {quoted_whole(row.text.strip('# '))}")
    return found


def is_free_key(written: str, key: str) -> bool:
    """Say whether a key may be of anything, by all that is known of its words."""
    named = key in (*WORDS["remark"]["free"], *WORDS["remark"]["numbered"], *WORDS["head"])
    known = named or topic_of(written) or names_a_limit(key)
    return not (known or is_of_another(written) or numbers_a_thing(written))


def _is_of_an_axis(row: Row, stated: Sequence[KeyValue], axes: Container[str]) -> bool:
    """Say whether a row, or what it states of no known key, names one of the axes."""
    cells = [row.text] if " ".join(map(clean, row.cells)) == clean(row.text) else row.cells
    if equates_axes(" = ".join(map(clean, filter(None, cells)))):
        return True
    if not stated:
        return any(names_one_of(axes, text) for text in cells)
    if any(_has_an_open_number(axes, one) for one in stated):
        return True
    named = (one for one in stated if names_one_of(axes, one.value))
    return any(is_free_key(k.written, k.key) and not axes_in_words(k.written) for k in named)


def _has_an_open_number(axes: Container[str], stated: KeyValue) -> bool:
    """Say whether an axis has a number that is no model's of a device: ``Y: x10``."""
    of_axis = any(axis in axes for axis in axes_in_words(stated.written))
    if not of_axis or not is_free_key(stated.written, stated.key):
        return False
    known = read_unit(stated.value) or OTHER_SIZE.search(stated.value)
    return not known and re.match(r"[^\W\d_]{2}|\D*$", stated.value) is None


def _is_of_some(
    row: Row, stated: Sequence[KeyValue], poses: Sequence[str], between: Container[int]
) -> bool:
    """Say whether two words or more stand between readings, or a line names some of the poses."""
    text = clean(row.text[:LONGEST_LINE])
    if row.line in between and len(re.findall(r"[^\W\d_]{2,}", without_explained(text))) > 1:
        return not names_an_axis(row.cells)
    free = (one for one in stated if is_free_key(one.written, one.key.partition("[")[0]))
    texts = [f"{one.key} {one.value}" for one in free] if stated else [text]
    return any(names_some(text[:LONGEST_LINE], poses) for text in texts)


def _is_open(
    stated: KeyValue, readings: Readings, rows: int, is_step: Callable[[str], bool]
) -> bool:
    """Say whether a statement of no known key may be of cycles, a factor, a part of a unit."""
    key, value = stated.written, stated.value
    number, size = parse_cell(value), _FIRST_SIZE.match(value)
    in_words = len(value.split()) >= SENTENCE or not value.isascii()
    if number is None and not size and not (in_words and re.search("[0-9]", value)):
        return False
    if not is_free_key(key, stated.key) or OTHER_SIZE.search(key):
        return False
    corrects = subject_of_heading(key) is not None or not is_step(value)
    if (number or size) and corrects and _may_correct(size[0] if size else value, readings):
        return True
    if number is None or number.unit:
        return holds_an_open_number(value, rows, is_step)
    return _FACTORS[0] <= number.value <= _FACTORS[1] and (count_decimals(value) or 0) > 1


_FIRST_SIZE = re.compile(r"[-+−]?[0-9]+(?:[.,][0-9]+)? ?(?:mm|[uµμ]m)(?!\w)")


def _may_correct(value: str, readings: Readings) -> bool:
    """Say whether a number is smaller than the spread of readings, or has a sign and is below 1."""
    size = length_in_mm(value) or length_in_mm(f"{value} mm" if count_decimals(value) else "")
    most = 1.0 if value[:1] in ("+", "-", "−") else max(map(np.ptp, readings.values()), default=0)
    return size is not None and 0 < abs(size) < most


def _is_step_of(readings: Readings, text: str) -> bool:
    """Say whether a text is a length, and the step on which the readings of an axis lie."""
    size = length_in_mm(text) or 0.0
    return any(math.isclose(size, common_step(one), rel_tol=0.02) for one in readings.values())


def _rare_mark(remarks: npt.NDArray[np.str_]) -> str:
    """Return the word by which a few rows differ from all others; empty where there is none."""
    marks, counts = np.unique(remarks, return_counts=True)
    if len(marks) != TWO or counts.min() > RARE * counts.sum():
        return ""
    words = all(map(str.isalnum, marks)) and not any(map(strikes_its_row, marks))
    return str(marks[counts.argmin()]) if words else ""
