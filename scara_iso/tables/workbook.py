"""An .xlsx workbook to rows of cells, within bounds and with its error cells."""

from __future__ import annotations

import io
import math
import posixpath
import re
import zipfile
import zlib
from collections.abc import Iterator
from datetime import datetime
from xml.etree import ElementTree as ET
from xml.parsers import expat

from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import refuse

_UNPACKED_MB = 48
_CELLS = 1_000_000
"""Both bound the memory that reading takes: benchmarks/fuzz_tables.py measures it."""
_PARTS = 1_000_000
_ERROR = "#VALUE!"
_REMEDY = "save the sheet with the readings as CSV (UTF-8)"
_MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_LINK = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"


def read_sheets(data: bytes, where: str) -> Iterator[tuple[str, list[list[Cell]]]]:
    """Yield name and rows, from row 1 and column A on, of each sheet that holds cells.

    Raises `DataError` for what is no workbook or is too large.
    """
    from python_calamine import CalamineError, CalamineWorkbook  # noqa: PLC0415

    errors = _check(data, where)
    try:
        book = CalamineWorkbook.from_filelike(io.BytesIO(data))
        for name in book.sheet_names:
            if name in errors:
                rows = book.get_sheet_by_name(name).to_python(skip_empty_area=False)
                yield name, _with_errors([[_cell(v) for v in row] for row in rows], errors[name])
    except (CalamineError, OSError) as error:
        raise refuse(where, f"a workbook that cannot be read: {error}", remedy=_REMEDY) from error


def _check(data: bytes, where: str) -> dict[str, list[tuple[int, int]]]:
    """Return row and column, from 0, of each worksheet's error cells; refuse what is too large.

    Calamine holds a sheet as a full rectangle, so one cell far away would fill the memory; and it
    gives error cells as empty ones.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(info.file_size for info in archive.infolist()) > _UNPACKED_MB * 2**20:
                message = f"a workbook of more than {_UNPACKED_MB} MB when unpacked"
                raise refuse(where, message, remedy=_REMEDY)
            sheets = {name: _scan(archive, part) for name, part in _worksheets(archive).items()}
            cells = sum(rows * columns for _, rows, columns in sheets.values())
            if cells > _CELLS:
                rows, columns = max((s[1:] for s in sheets.values()), key=math.prod)
                message = f"more than {_CELLS} cells: a sheet of {rows} rows and {columns} columns"
                raise refuse(where, message, remedy=_REMEDY)
            return {name: errors for name, (errors, _, _) in sheets.items()}
    except (zipfile.BadZipFile, KeyError, ET.ParseError,
        expat.ExpatError,
        zlib.error, NotImplementedError,
            RuntimeError, EOFError, ValueError, OSError) as error:  # fmt: skip
        raise refuse(
            where, "a zip archive that is no sound .xlsx workbook", remedy=_REMEDY
        ) from error


def _worksheets(archive: zipfile.ZipFile) -> dict[str, str]:
    links = _xml(archive, "xl/_rels/workbook.xml.rels")
    targets = {link.get("Id"): link.get("Target", "") for link in links}
    sheets = _xml(archive, "xl/workbook.xml").iter(f"{_MAIN}sheet")
    found = {s.get("name", ""): targets.get(s.get(_LINK), "") for s in sheets}
    parts = {n: posixpath.normpath(posixpath.join("/xl", t)).lstrip("/") for n, t in found.items()}
    return {name: part for name, part in parts.items() if "worksheets/" in part}


def _xml(archive: zipfile.ZipFile, part: str) -> ET.Element:
    with archive.open(part) as file:
        text = file.read(_PARTS)
    if b"<!" in text:
        raise ValueError("a document type in a workbook")
    return ET.fromstring(text)  # noqa: S314 - no document type, so no entities


def _scan(archive: zipfile.ZipFile, part: str) -> tuple[list[tuple[int, int]], int, int]:
    """Return the error cells of one sheet, and the rows and columns of its rectangle."""
    errors: list[tuple[int, int]] = []
    farthest = [0, 0]

    def start(tag: str, attributes: dict[str, str]) -> None:
        match tag.rpartition(":")[2]:
            case "row" if "r" in attributes:
                farthest[0] = max(farthest[0], _whole(attributes["r"]))
            case "c":
                row, column = _place(attributes.get("r", ""))
                farthest[:] = max(farthest[0], row), max(farthest[1], column)
                if attributes.get("t") == "e" and len(errors) < _CELLS:
                    errors.append((row - 1, column - 1))

    def refuse_type(*_: object) -> None:
        raise ValueError("a document type in a workbook")

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    parser.StartDoctypeDeclHandler = refuse_type
    with archive.open(part) as file:
        parser.ParseFile(file)
    return errors, farthest[0], farthest[1]


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
    for row, column in errors:
        rows += [[] for _ in range(row + 1 - len(rows))]
        rows[row] += [""] * (column + 1 - len(rows[row]))
        rows[row][column] = _ERROR
    width = max(map(len, rows), default=0)
    return [row + [""] * (width - len(row)) for row in rows]


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
