"""One grid for every table: rows of cells with their lines, of a text or of a sheet; its faults.

Faults of one file are counted up to a bound at which reading ends, the first thousand kept.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from scara_iso.base.errors import DataError, Fault, NoInputError, ScaraIsoError
from scara_iso.tables.vocabulary.words import BLANKS, Subject, quoted

Cell = str | float
"""A cell of a text is text; a numeric cell of a workbook is its number."""
Line = tuple[int, Sequence[Cell]]
"""A row's number and its cells."""
HEAD = 200
"""Lines in which the header must come."""
_LINE_LIMIT = 1_000_000
"""Characters in one line: bounds the length of a cell and the number of columns."""
_JOINED = 5
_LAST = 200
_CHUNK = 500_000
_ERROR_CODE = re.compile(r"#(?:#|N/A|NV|[A-ZÄÖÜ/0]+[!?])")
_BETWEEN = str.maketrans(",|", "  ")
_STROKES = "-=_+*|:"


class Row(NamedTuple):
    """A row as text: its cells, the whole, the lines it begins and ends on (it may hold two)."""

    line: int
    cells: list[str]
    text: str
    end: int


def text_row(line: int, cells: Sequence[Cell]) -> Row:
    """Return a row as text, its filled cells joined by commas."""
    texts = [cell if isinstance(cell, str) else f"{cell:.15g}" for cell in cells]
    return Row(line, texts, ", ".join(t for t in map(stripped, texts) if t), line)


def stripped(text: str) -> str:
    """Return a text without the blanks around it."""
    return text.strip(BLANKS)


def is_dash(cell: Cell) -> bool:
    """Say whether a cell holds a dash alone: there is nothing to remark."""
    return isinstance(cell, str) and cell.strip(BLANKS) in ("-", "–", "—")


def is_filled(cell: Cell) -> bool:
    """Say whether a cell holds more than blanks."""
    return not isinstance(cell, str) or bool(cell.strip(BLANKS))


def is_comment(text: str) -> bool:
    """Say whether a row begins with ``#``, and not with a spreadsheet's ``#DIV/0!``."""
    return text.startswith("#") and not _ERROR_CODE.match(text)


def is_rule(text: str) -> bool:
    """Say whether a row is a ruled line, of three strokes or more in every cell."""
    cells = text.translate(_BETWEEN).split()
    return bool(cells) and all(len(cell) > 2 and not cell.strip(_STROKES) for cell in cells)


class Delimiter(Enum):
    """What stands between two cells; the value is how it is said."""

    TAB = "tab-separated"
    SEMICOLON = "semicolon-separated"
    COMMA = "comma-separated"
    BAR = "in columns ruled with |"
    WIDE_BLANKS = "separated by two or more blanks"
    BLANKS = "separated by blanks"


_CHARACTER = {
    Delimiter.TAB: "\t",
    Delimiter.SEMICOLON: ";",
    Delimiter.COMMA: ",",
    Delimiter.BAR: "|",
    Delimiter.BLANKS: " ",
}
_SEP = re.compile(r'"?sep=([,;\t])"?[,;\t]*', re.IGNORECASE)
_WIDE = re.compile(rf"[{BLANKS}]{{2,}}|\t")
_QUOTED = re.compile(r'\A"(.*)"\Z', re.DOTALL)
_ANY_BLANK = str.maketrans(dict.fromkeys(BLANKS, " "))
# In a table of single blanks a unit behind a value or a name belongs to it.
_GLUE = re.compile(r"(?<=\S) +(?=[\[(])|(?<=[0-9.,]) +(?=(?:mm|[uµμ]m|inch|in|deg|°)(?: |$))")


def _split(lines: list[str], delimiter: Delimiter) -> list[list[str]]:
    """Return the cells of each line; raises ``csv.Error`` where quoting breaks a line."""
    if delimiter is Delimiter.WIDE_BLANKS:
        return [[_QUOTED.sub(r"\1", c) for c in _WIDE.split(stripped(line))] for line in lines]
    if delimiter is Delimiter.BLANKS:
        lines = [_GLUE.sub("", line.translate(_ANY_BLANK).strip(" ")) for line in lines]
    if delimiter is Delimiter.BAR:
        bare = [stripped(line).removeprefix("|").removesuffix("|") for line in lines]
        return [list(map(stripped, line.split("|"))) for line in bare]
    character = _CHARACTER[delimiter]
    if '"' not in "".join(lines):
        sep = None if delimiter is Delimiter.BLANKS else character
        return [line.split(sep) for line in lines]
    cells = list(csv.reader(lines, delimiter=character, skipinitialspace=True, strict=True))
    if len(cells) != len(lines):
        raise csv.Error("a quoted cell holds a line end")
    return cells


def split_columns(
    lines: list[str], delimiter: Delimiter, width: int
) -> Sequence[Sequence[str]] | None:
    """Return the columns of lines that have ``width`` cells each, or None where they have not."""
    character = _CHARACTER.get(delimiter, "")
    alone = delimiter in (Delimiter.TAB, Delimiter.SEMICOLON, Delimiter.COMMA)
    if not alone or '"' in "".join(lines):
        try:
            rows = _split(lines, delimiter)
        except csv.Error:
            return None
        return list(zip(*rows, strict=True)) if set(map(len, rows)) == {width} else None
    if {line.count(character) for line in lines} != {width - 1}:
        return None
    cells = character.join(lines).split(character)
    return [cells[k::width] for k in range(width)]


def split_each(
    first: int, lines: Sequence[str], delimiter: Delimiter, faults: Faults
) -> Iterator[Line]:
    """Yield number and cells of each line, from the ``first`` on.

    A broken quote is a fault; a comment with one is one cell.
    """
    for line, text in enumerate(lines, first):
        try:
            yield line, _split([text], delimiter)[0]
        except csv.Error as error:
            if is_comment(text):
                yield line, [text]
            else:
                faults.add(f"{error}: {quoted(text)}", line, remedy="close or remove the quote")


def split_rows(lines: list[str], delimiter: Delimiter) -> list[Row]:
    """Return lines as rows of text; a quoted cell may hold up to four line ends.

    A line whose quoting cannot be mended is one row of one cell.
    """
    rows: list[Row] = []
    ends = BLANKS + _CHARACTER.get(delimiter, "")
    position = 0
    while position < len(lines):
        limit = 1 if lines[position].startswith("#") else _JOINED
        for count in range(1, limit + 1):
            with suppress(csv.Error):
                piece = "\n".join(lines[position : position + count])
                cells = _split([piece], delimiter)[0]
                break
        else:
            count, cells = 1, [lines[position]]
        text = cells[0] if len(cells) == 1 else lines[position].strip(ends)
        rows.append(Row(position + 1, cells, text.strip(), position + count))
        position += count
    return rows


class FileText(NamedTuple):
    """The text of a file, whose lines are taken in pieces: no list of all of them is made."""

    text: str
    encoding: str
    ended: bool
    """Whether the last line is ended."""

    @property
    def lines(self) -> int:
        """How many there are."""
        return self.text.count("\n") + 1

    @property
    def last(self) -> Sequence[str]:
        """At most the two hundred last."""
        return self.text.rsplit("\n", _LAST)[-_LAST:]

    def head(self, where: str) -> list[str]:
        """Return the first lines; `DataError` for one that is too long."""
        lines = self.text.split("\n", HEAD)[:HEAD]
        faults = Faults(where)
        check_length(1, lines, faults)
        faults.check()
        return lines

    def pieces(self) -> Iterator[tuple[int, list[str]]]:
        """Yield whole lines, half a million characters at once, with the number of their first."""
        start, line = 0, 1
        while start <= len(self.text):
            end = self.text.find("\n", start + _CHUNK)
            end = len(self.text) if end < 0 else end
            lines = self.text[start:end].split("\n")
            yield line, lines
            start, line = end + 1, line + len(lines)


def check_length(first: int, lines: Sequence[str], faults: Faults) -> None:
    """Add each line of too many characters, from the ``first`` on."""
    if max(map(len, lines), default=0) <= _LINE_LIMIT:
        return
    for line, text in enumerate(lines, first):
        if len(text) > _LINE_LIMIT:
            what = f"a line of {len(text)} characters, more than {_LINE_LIMIT}"
            faults.add(what, line, remedy="end each row with a line end, and leave texts out")


class CellGrid(NamedTuple):
    """The rows of a table as a file parts them, and what is known of them beside their cells."""

    where: str
    """What messages call it."""
    how: str
    """How the file was split into cells."""
    head: list[Row]
    """The first rows as text: the header comes in them."""
    lines: Sequence[Line] | None = None
    """All rows; None for a text that is taken piece by piece."""
    text: FileText | None = None
    """The one that was split."""
    delimiter: Delimiter | None = None
    title: str = ""
    """Of a sheet."""
    hidden: bool = False
    """Whether the sheet is."""
    hidden_rows: frozenset[int] = frozenset()
    hidden_columns: frozenset[int] = frozenset()
    """Rows and columns that the sheet does not show, from 1."""
    merged: frozenset[tuple[int, int]] = frozenset()
    """Line and column, from 1, of cells that are one with the cell above them."""
    colours: Mapping[int, frozenset[str]] = MappingProxyType({})
    """Of the cells of each row that are not as usual."""
    cover: Sequence[Row] = ()
    """What other sheets state, and holds for all, and comments of cells of its own."""

    def rows(self) -> Sequence[Line]:
        """Return all rows; raises `DataError` for lines of a text that cannot be split."""
        if self.lines is not None or self.text is None or self.delimiter is None:
            return self.lines or ()
        faults = Faults(self.where)
        lines = self.text.text.split("\n")
        check_length(1, lines, faults)
        faults.check()
        rows = list(split_each(1, lines, self.delimiter, faults))
        faults.check()
        return rows


def grids_of(text: FileText, where: str) -> list[CellGrid]:
    """Return a text's head by each delimiter that there can be: the stated one, or all."""
    head = text.head(where)
    match = _SEP.fullmatch(head[0].strip(" "))
    stated = next(d for d, c in _CHARACTER.items() if c == match[1]) if match else None
    lines = ["", *head[1:]] if stated else head
    return [
        CellGrid(where, f"{d.value}, {text.encoding}", split_rows(lines, d), text=text, delimiter=d)
        for d in ([stated] if stated else Delimiter)
    ]


def head_of(rows: Iterable[Line]) -> list[Row]:
    """Return the first rows as text."""
    return [text_row(line, cells) for line, cells in list(rows)[:HEAD]]


KEPT = 1000
"""Faults that a `DataError` lists; more are counted."""
_MOST = 10_000
"""Faults after which a file is not read on."""
_REMEDIES = 3
"""Kinds of faults whose remedies are said: those of the first may mend the rest."""


class Faults:
    """Collect what is wrong with the file ``where``, wanted as ``what``, in the order found.

    ``sheet`` is the one of a workbook; empty for text.
    """

    def __init__(self, where: str, what: str = "a table of readings", *, sheet: str = "") -> None:
        self.where = where
        self.sheet = sheet
        self.row = "row" if sheet else "line"
        """What a line of the file is called."""
        self.what = what
        self.total = 0
        self._kept: list[Fault] = []
        self._remedies: dict[str, None] = {}
        self.first_remedy = ""
        """Stands in place of those of the faults."""

    def add(
        self, message: str, line: int | None = None, column: int | None = None, *, remedy: str
    ) -> None:
        """Note one fault and what to do about it; the error says what to do about each kind.

        Raises `DataError` where there are so many that reading on would be of no use.
        """
        self.total += 1
        self._remedies.setdefault(remedy)
        if len(self._kept) < KEPT:
            self._kept.append(
                Fault(message, line or None, column, self.sheet)
            )  # a log has no header
        if self.total == _MOST:
            self.check()

    def place(self, line: int) -> str:
        """Return what a message calls a line; 0 is one outside of the sheet."""
        return f"{self.row} {line}" if line else "another sheet or a page header"

    def check(self) -> None:
        """Raise `DataError` if a fault was noted."""
        if not self.total:
            return
        faults = sorted(self._kept, key=lambda fault: (fault.line or 0, fault.column or 0))
        count = "1 fault" if self.total == 1 else f"{self.total} faults"
        more = f", the first {KEPT} listed" if self.total > KEPT else ""
        more += "; the rest was not read" if self.total == _MOST else ""
        raise DataError(
            f"cannot be read as {self.what}: {count}{more}",
            where=self.where,
            remedy=self.first_remedy or "; ".join([*self._remedies][:_REMEDIES]),
            faults=faults,
        )


def refuse(where: str, message: str, *, remedy: str) -> DataError:
    """Return the `DataError` of a file that is refused as a whole."""
    return DataError(message, where=where, remedy=remedy, faults=(Fault(message),))


def together(errors: Sequence[ScaraIsoError], where: str, what: str = "") -> ScaraIsoError:
    """Return one error with the faults of several files, each named; the only one as it is."""
    if len(errors) == 1:
        return errors[0]
    what = what or f"{len(errors)} tables cannot be read"
    remedies = list(dict.fromkeys(error.remedy for error in errors if error.remedy))
    each = len(remedies) > _REMEDIES
    remedy = "follow the advice below each table" if each else "; ".join(remedies)
    if all(isinstance(error, NoInputError) for error in errors):
        said = "; ".join(error.headline for error in errors)
        return NoInputError(f"{what}: {said}", where=where, remedy=remedy)
    faults = [fault for error in errors for fault in _named(error, remedy=each)]
    return DataError(what, where=where, remedy=remedy, faults=faults)


def _named(error: ScaraIsoError, *, remedy: bool) -> list[Fault]:
    lines = list(error.fault_lines()) if isinstance(error, DataError) else []
    lines += [error.remedy] if remedy and error.remedy else []
    below = (Fault(f"{error.where}: {line.strip()}") for line in lines)
    return [Fault(error.headline), *below]


NAME_CONDITION = "; a condition of the test is named in '# covariates: {}' above the header"
LEAVE_ROWS_OUT = "remove the rows that do not count"
LEAVE_OUT = f"{LEAVE_ROWS_OUT} (`allow_gaps=`), and the"
OF_COLUMNS = {
    Subject.ZERO: "subtract the zero from the readings, and remove the column",
    Subject.SIDE: "call it approach where it is the side that the pose is approached from (+1, -1)"
    + NAME_CONDITION,
    Subject.EXCLUDED: f"{LEAVE_OUT} column" + NAME_CONDITION,
    Subject.UNCERTAINTY: "write the standard uncertainty above the header, as "
    "'# indicator_uncertainty: 0.002 mm', and remove the column",
    Subject.SCALE: "multiply the readings by it, and remove the column" + NAME_CONDITION,
    Subject.UNIT: "write the unit above the header, as '# unit: mm', and remove the column; "
    "readings in several units want a table each" + NAME_CONDITION,
}
"""What to do about a column whose heading speaks of it, called {}."""
NUMBER_CYCLES = (
    "write the cycle's number, 1 and up, in each row of a visit; remove a mean, a limit or a total"
)
STRUCK = " (struck through)"
"""Behind a workbook's cell that is struck through."""
ONE_COLUMN = "give each axis a column headed X or Y, each cycle one row (as by a pivot table)"
