"""An .xlsx workbook to rows of cells, within bounds and with its error cells."""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
import zlib
from array import array
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any
from xml.etree import ElementTree as ET
from xml.parsers import expat

from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import refuse

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
