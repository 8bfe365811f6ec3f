"""An .xlsx workbook to rows of cells, within bounds and with its error cells."""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
from collections.abc import Iterator
from datetime import datetime
from xml.etree import ElementTree as ET

from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import refuse

MAGIC = b"PK\x03\x04"
OLD_MAGIC = b"\xd0\xcf\x11\xe0"
_UNPACKED = 512 * 2**20
_CELLS = 10_000_000
_PARTS = 1_000_000
_CELL = re.compile(rb'<c [^<>]*?\br="([A-Z]{1,3})([0-9]{1,7})"[^<>]*>')
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
            if sum(info.file_size for info in archive.infolist()) > _UNPACKED:
                raise refuse(where, "a workbook of more than 512 MB", remedy=_REMEDY)
            return {
                name: _scan(archive, part, where) for name, part in _worksheets(archive).items()
            }
    except (zipfile.BadZipFile, KeyError, ET.ParseError, NotImplementedError,
            RuntimeError, EOFError, ValueError, OSError) as error:  # fmt: skip
        raise refuse(where, "a zip archive that is no .xlsx workbook", remedy=_REMEDY) from error


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


def _scan(archive: zipfile.ZipFile, part: str, where: str) -> list[tuple[int, int]]:
    errors: list[tuple[int, int]] = []
    height = width = 0
    rest = b""
    with archive.open(part) as file:
        while piece := file.read(2**20):
            piece, cut = rest + piece, (rest + piece).rfind(b"<")
            rest = piece[cut:][-2000:]
            for match in _CELL.finditer(piece, 0, max(cut, 0)):
                row, column = int(match[2]), _column(match[1])
                height, width = max(height, row), max(width, column)
                if b't="e"' in match[0] and len(errors) < _PARTS:
                    errors.append((row - 1, column - 1))
    if height * width > _CELLS:
        raise refuse(where, f"a sheet of {height} rows and {width} columns", remedy=_REMEDY)
    return errors


def _column(letters: bytes) -> int:
    number = 0
    for letter in letters:
        number = number * 26 + letter - 64
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
