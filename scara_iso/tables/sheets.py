"""Rows of cells to a run: a workbook, and tables of several poses on one sheet or in one file.

An .xlsx workbook to rows of cells, within bounds and with its error cells.
"""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
import zlib
from array import array
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any
from xml.etree import ElementTree as ET
from xml.parsers import expat

from scara_iso.base.errors import DataError
from scara_iso.run import Run
from scara_iso.tables.assemble import ReadOptions, assemble
from scara_iso.tables.blocks import (
    Block,
    Line,
    check_header,
    find_blocks,
    find_wide,
    place_columns,
    suggest_columns,
)
from scara_iso.tables.body import Body, Delimited
from scara_iso.tables.columns import Cell, Columns
from scara_iso.tables.faults import Faults, listed, quoted, refuse, together
from scara_iso.tables.layout import HEAD, Layout, find_layout
from scara_iso.tables.names import pose_in
from scara_iso.tables.poses import PosePart, merge
from scara_iso.tables.text import Row

_UNPACKED = 48 * 2**20
_CELLS = 1_000_000
_TEXT = 24 * 2**20
"""Bytes of all parts, cells, and characters in cells: together they bound the memory that reading
takes, which benchmarks/fuzz_tables.py measures."""
_PART = 1_000_000
_CHUNK = 2**16
_ERROR = "#VALUE!"
_LONGEST_INDEX = 20
_REMEDY = "save the sheet with the readings as CSV (UTF-8)"
_MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_LINK = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"


def read_sheets(data: bytes, where: str) -> Iterator[tuple[str, list[list[Cell]]]]:
    """Yield name and rows, from row 1 and column A on, of each sheet that holds cells.

    Raises `DataError` for what is not a workbook or is too large.
    """
    from python_calamine import CalamineError, CalamineWorkbook  # noqa: PLC0415

    errors = _check(data, where)
    try:
        book = CalamineWorkbook.from_filelike(io.BytesIO(data))
        for name in book.sheet_names:
            if name in errors:
                rows = book.get_sheet_by_name(name).to_python(skip_empty_area=False)
                yield name, _with_errors(_cells(rows), errors[name])
    except (CalamineError, OSError) as error:
        raise refuse(where, f"a workbook that cannot be read: {error}", remedy=_REMEDY) from error


@dataclass(slots=True)
class _Sheet:
    """What one worksheet holds, from its XML; ``lengths`` are the characters of shared texts."""

    lengths: array[int]
    rows: int = 0
    columns: int = 0
    characters: int = 0
    errors: list[tuple[int, int]] = field(default_factory=list)
    """Row and column, from 0, of each error cell."""
    kind: str = ""
    value: str = ""

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """Take the beginning of an element."""
        if tag == "row" and "r" in attributes:
            self.rows = max(self.rows, _whole(attributes["r"]))
        elif tag == "c":
            row, column = _place(attributes.get("r", ""))
            self.rows, self.columns = max(self.rows, row), max(self.columns, column)
            self.kind, self.value = attributes.get("t", ""), ""
            if self.kind == "e" and len(self.errors) < _CELLS:
                self.errors.append((row - 1, column - 1))

    def text(self, found: str) -> None:
        """Take text between two tags."""
        self.characters += len(found)
        if self.kind == "s" and len(self.value) < _LONGEST_INDEX:
            self.value += found

    def end(self, tag: str) -> None:
        """Take the end of an element: a shared text stands in each cell that names it."""
        if tag == "c" and self.kind == "s" and self.value.strip():
            self.characters += self.lengths[_whole(self.value.strip())]


def _check(data: bytes, where: str) -> dict[str, list[tuple[int, int]]]:
    """Return row and column, from 0, of each worksheet's error cells; refuse what is too large.

    Calamine holds a sheet as a full rectangle and a shared text once for each of its cells, so that
    little may fill the memory; and it gives error cells as empty ones.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            _check_unpacked(archive, where)
            lengths = _shared_lengths(archive)
            sheets = {n: _scan(archive, part, lengths) for n, part in _worksheets(archive).items()}
    except (
        zipfile.BadZipFile,
        KeyError,
        ET.ParseError,
        expat.ExpatError,
        zlib.error,
        NotImplementedError,
        IndexError,
        RuntimeError,
        EOFError,
        ValueError,
        OSError,
    ) as error:
        raise refuse(
            where, "a zip archive that is not a valid .xlsx workbook", remedy=_REMEDY
        ) from error
    if sum(sheet.rows * sheet.columns for sheet in sheets.values()) > _CELLS:
        largest = max(sheets.values(), key=lambda sheet: sheet.rows * sheet.columns)
        size = f"{largest.rows} rows and {largest.columns} columns"
        raise refuse(where, f"more than {_CELLS} cells: a sheet of {size}", remedy=_REMEDY)
    if sum(sheet.characters for sheet in sheets.values()) > _TEXT:
        raise refuse(where, f"more than {_TEXT} characters in its cells", remedy=_REMEDY)
    return {name: sheet.errors for name, sheet in sheets.items()}


def _check_unpacked(archive: zipfile.ZipFile, where: str) -> None:
    """Refuse an archive that says it is too large, and one that is larger than it says."""
    parts = archive.infolist()
    if sum(part.file_size for part in parts) > _UNPACKED:
        message = f"a workbook of more than {_UNPACKED // 2**20} MB when unpacked"
        raise refuse(where, message, remedy=_REMEDY)
    if len({part.filename.lower() for part in parts}) < len(parts):
        raise ValueError("two parts of one name")
    for part in parts:
        stated = copy(part)
        stated.file_size = _UNPACKED + 1  # zipfile would end where the directory says
        with archive.open(stated) as file:
            size = 0
            while size <= part.file_size and (chunk := file.read(_CHUNK)):
                size += len(chunk)
        if size != part.file_size:
            raise ValueError("a part of another size than the directory says")


def _worksheets(archive: zipfile.ZipFile) -> dict[str, str]:
    links = _xml(archive, "xl/_rels/workbook.xml.rels")
    targets = {link.get("Id"): link.get("Target", "") for link in links}
    sheets = _xml(archive, "xl/workbook.xml").iter(f"{_MAIN}sheet")
    found = {s.get("name", ""): targets.get(s.get(_LINK), "") for s in sheets}
    parts = {n: posixpath.normpath(posixpath.join("/xl", t)).lstrip("/") for n, t in found.items()}
    parts = {name: part for name, part in parts.items() if "worksheets/" in part}
    if len(set(parts.values())) < len(parts):
        raise ValueError("two sheets of one part")
    return parts


def _xml(archive: zipfile.ZipFile, part: str) -> ET.Element:
    with archive.open(part) as file:
        text = file.read(_PART)
    if b"<!" in text:
        raise ValueError("a document type in a workbook")
    return ET.fromstring(text)  # noqa: S314 - no document type, so no entities


def _parse(
    archive: zipfile.ZipFile,
    part: str,
    start: Callable[[str, dict[str, str]], None],
    text: Callable[[str], None],
    end: Callable[[str], None],
) -> None:
    """Feed a part's elements, by their local names, and their text to the functions."""

    def refuse_type(*_: object) -> None:
        raise ValueError("a document type in a workbook")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = lambda tag, found: start(tag.rpartition(":")[2], found)
    parser.EndElementHandler = lambda tag: end(tag.rpartition(":")[2])
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = refuse_type
    with archive.open(part) as file:
        parser.ParseFile(file)


def _shared_lengths(archive: zipfile.ZipFile) -> array[int]:
    """Return the characters of each shared text."""
    lengths: array[int] = array("L")

    def start(tag: str, _: object) -> None:
        if tag == "si":
            lengths.append(0)
            if len(lengths) > _CELLS:
                raise ValueError("more shared texts than cells")

    def text(found: str) -> None:
        if lengths:
            lengths[-1] += len(found)

    for part in archive.namelist():
        if part.lower() == "xl/sharedstrings.xml":
            _parse(archive, part, start, text, lambda _: None)
    return lengths


def _scan(archive: zipfile.ZipFile, part: str, lengths: array[int]) -> _Sheet:
    sheet = _Sheet(lengths)
    _parse(archive, part, sheet.start, sheet.text, sheet.end)
    return sheet


def _whole(text: str) -> int:
    if not re.fullmatch("[0-9]{1,7}", text):
        raise ValueError("a row without a number")
    return int(text)


def _place(reference: str) -> tuple[int, int]:
    match = re.fullmatch("([A-Z]{1,3})([0-9]{1,7})", reference)
    if match is None:
        raise ValueError("a cell without a reference")
    return int(match[2]), _column(match[1])


def _column(letters: str) -> int:
    number = 0
    for letter in letters:
        number = number * 26 + ord(letter) - 64
    return number


def _with_errors(rows: list[list[Cell]], errors: list[tuple[int, int]]) -> list[list[Cell]]:
    for line, column in errors:
        rows += [[] for _ in range(line + 1 - len(rows))]
        rows[line] += [""] * (column + 1 - len(rows[line]))
        rows[line][column] = _ERROR
    width = max(map(len, rows), default=0)
    for row in rows:
        row.extend([""] * (width - len(row)))
    return rows


def _cells(rows: list[list[Any]]) -> list[list[Cell]]:
    """Return the rows as cells, in the same lists: a second copy would take as much memory."""
    for row in rows:
        row[:] = map(_cell, row)
    return rows


def _cell(value: object) -> Cell:
    match value:
        case bool():
            return str(value).upper()
        case int() | float():
            return float(value)
        case datetime():
            return value.isoformat()
        case _:
            return str(value)


NO_HEADER = "begin with a header row that names its columns, such as 'cycle,X,Y,Z,theta'"


def read_workbook(data: bytes, name: str, options: ReadOptions) -> Run:
    """Return the run of a workbook: of its only table, or of the sheets that name a pose."""
    found: dict[str, Sequence[Line]] = {}
    names: list[str] = []
    heads: list[list[Row]] = []
    for title, cells in read_sheets(data, name):
        names.append(title)
        rows: Sequence[Line] = list(enumerate(cells, 1))
        if options.sheet in (None, title):
            heads.append(_head(rows))
            if _find_table(rows, options.columns) or _blocks(rows, name, options):
                found[title] = rows
    if len(found) == 1:
        ((title, rows),) = found.items()
        return _read_sheet(rows, name, options, title)
    parts, left = _poses_of(found, name, options)
    if len(parts) < 2:
        raise _which_sheet(name, names, list(found), options, suggest_columns(heads))
    unused = [f"sheet {quoted(title)} names no pose: not used" for title in left]
    return merge(parts, name, notes=unused)


def read_blocks(
    blocks: Sequence[Block],
    name: str,
    options: ReadOptions,
    how: str,
    sheet: str = "",
    *,
    text: Delimited | None = None,
) -> Run:
    """Return the run of blocks that each stand under their pose's name, or every fault of all."""
    parts, errors = [], []
    for block in blocks:
        try:
            called = f"{name}, block of {block.pose}"
            run = read_rows(block.rows, called, options, how, sheet, text=text)
            parts.append(PosePart(run, f"block of {block.pose}", "", block.place, block.pose))
        except DataError as error:
            errors.append(error)
    if errors:
        raise together(errors, name)
    return merge(parts, name)


def _poses_of(
    sheets: dict[str, Sequence[Line]], name: str, options: ReadOptions
) -> tuple[list[PosePart], list[str]]:
    """Return the sheets that name a pose, and those that do not; raises the faults of the first."""
    parts: list[PosePart] = []
    left: list[str] = []
    errors: list[DataError] = []
    for title, rows in sheets.items():
        try:
            run = _read_sheet(rows, f"{name}, sheet {quoted(title)}", options, title)
        except DataError as error:
            if pose_in(title):
                errors.append(error)
            else:
                left.append(title)
            continue
        if pose_in(title) or run.pose is not None or "pose" in run.metadata:
            parts.append(PosePart(run, f"sheet {quoted(title)}", title, "the sheet's name"))
        else:
            left.append(title)
    if errors and len(errors) + len(parts) > 1:
        raise together(errors, name)
    return parts, left


def _read_sheet(rows: Sequence[Line], name: str, options: ReadOptions, sheet: str) -> Run:
    how = f"workbook, sheet {quoted(sheet)}"
    if blocks := _blocks(rows, name, options):
        return read_blocks(blocks, name, options, how, sheet)
    return read_rows(rows, name, options, how, sheet)


def _blocks(rows: Sequence[Line], name: str, options: ReadOptions) -> list[Block]:
    return [] if options.columns is not None else find_blocks(rows, name) or find_wide(rows, name)


def read_rows(
    rows: Sequence[Line],
    name: str,
    options: ReadOptions,
    how: str,
    sheet: str = "",
    *,
    text: Delimited | None = None,
) -> Run:
    """Return the run of one table; ``how`` says how the file was split into rows of cells.

    ``sheet`` is the one of a workbook that holds them, ``text`` the one that they were split from.
    """
    table = _find_table(rows, options.columns)
    if table is None:
        raise refuse(name, "no header that names an axis X, Y, Z or theta", remedy=NO_HEADER)
    head, layout = table
    faults = Faults(name, sheet=sheet)
    if options.columns is not None:
        check_header(head, layout, faults)
    most = sum(len(cells) for _, cells in rows) // max(layout.width, 1) + 1
    columns = Columns(layout, options.decimal, faults, most)
    body = Body(layout, faults)
    below = ((line, cells) for line, cells in rows if line >= layout.data_line)
    columns.add(list(body.sort(below)))
    return finish(head, columns, body, options, how, text)


def finish(
    head: list[Row],
    columns: Columns,
    body: Body,
    options: ReadOptions,
    how: str,
    text: Delimited | None,
) -> Run:
    """Return the run of the columns, after the checks that a ``text`` needs."""
    if text is None:
        return assemble(head, columns, body, options, how)
    text.check_end(head, columns, body, options.resolution)
    run = assemble(head, columns, body, options, f"{how}, {text.said(columns, options.decimal)}")
    if options.decimal is None:
        text.check_numbers(run, columns)
    return run


def _find_table(
    rows: Sequence[Line], names: Sequence[str] | None
) -> tuple[list[Row], Layout] | None:
    head = _head(rows)
    layout = place_columns(head, names) if names else find_layout(head)
    return (head, layout) if layout else None


def _head(rows: Sequence[Line]) -> list[Row]:
    texts = [(line, [_as_text(cell) for cell in cells]) for line, cells in rows[:HEAD]]
    return [Row(line, cells, _joined(cells), line) for line, cells in texts]


def _as_text(cell: Cell) -> str:
    return cell if isinstance(cell, str) else f"{cell:.15g}"


def _joined(cells: list[str]) -> str:
    return ", ".join(cell.strip() for cell in cells if cell.strip())


def _which_sheet(
    name: str, names: list[str], found: list[str], options: ReadOptions, suggested: str
) -> DataError:
    asked = options.sheet
    if asked is not None and asked not in names:
        return refuse(
            name,
            f"no sheet {quoted(asked)}; there are {listed(map(quoted, names))}",
            remedy="name one of them with `sheet=`",
        )
    if not found:
        return refuse(
            name,
            "no sheet with a header that names an axis X, Y, Z or theta",
            remedy=suggested or NO_HEADER,
        )
    return refuse(
        name,
        f"sheets {listed(map(quoted, found))} hold a table each",
        remedy=f"say which, for example `sheet={quoted(found[0])}`, or name the sheets of one "
        "test by their poses: P1, P2",
    )
