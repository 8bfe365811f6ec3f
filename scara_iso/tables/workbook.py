"""An .xlsx workbook to rows of cells as they are shown, within bounds.

What a sheet shows is what its reader means: 0.012 as 1.2 %, thousands by a comma behind the digits,
a unit in the number's format, a cell that is struck through. A comment of a cell stands beside a
row of numbers, or above the table. What a sheet hides is told beside the rows.
"""

from __future__ import annotations

import io
import re
import warnings
import zipfile
from collections.abc import Callable
from copy import copy
from datetime import date, datetime, time
from typing import TYPE_CHECKING

from scara_iso.base.errors import DataError
from scara_iso.tables.faults import STRUCK, quoted, refuse
from scara_iso.tables.grid import Cell, CellGrid, Row, head_of, text_row

if TYPE_CHECKING:
    from openpyxl import Workbook
    from openpyxl.workbook.workbook import _WorksheetLike

_UNPACKED = 48 * 2**20
_CELLS = 1_000_000
_TEXT = 24 * 2**20
"""Bytes of all parts, cells, and characters in cells: together they bound the memory that reading
takes, which benchmarks/fuzz_tables.py measures."""
_REMEDY = "save the sheet with the readings as CSV (UTF-8)"
_ELEMENT = re.compile(rb"<(?:\w+:)?(?:c|row|si|xf|col)[ />\r\n\t]")
_MERGED = re.compile(rb"<(?:\w+:)?mergeCell\s[^>]*?ref=.([A-Z]{1,3})([0-9]+):([A-Z]{1,3})([0-9]+)")
_FORBIDDEN = re.compile(rb"<!(?!--|\[CDATA)|\0")
"""A document type, and text in UTF-16, in which one could be written."""
_DIGIT = re.compile(r'"[^"]*"|\\.|([0#?])', re.DOTALL)
_CODE = re.compile("_x([0-9A-Fa-f]{4})_")
"""A character of a text, as OOXML writes one that XML cannot hold."""
_HALF = re.compile("[\ud800-\udfff]")
"""Half of a pair of UTF-16, which is no text alone."""
_LITERAL = re.compile(r'"([^"]*)"|\\(.)')


def read_sheets(data: bytes, where: str) -> list[CellGrid]:
    """Return the worksheets of a workbook, rows and columns counted from 1 and A.

    Raises `DataError` for what is not a workbook or is too large.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            _check_unpacked(archive, where)
        book = _open(data)
        _check_size(book, where)
        sheets = [_sheet(one, where) for one in book.worksheets]
    except DataError:
        raise
    except Exception as error:  # whatever a broken file makes its reader raise
        what = "a zip archive that is not a valid .xlsx workbook"
        raise refuse(where, what, remedy=_REMEDY) from error
    texts = (cell for one in sheets for _, row in one.rows() for cell in row)
    if sum(len(cell) for cell in texts if isinstance(cell, str)) > _TEXT:
        raise refuse(where, f"more than {_TEXT} characters in its cells", remedy=_REMEDY)
    return sheets


def _open(data: bytes) -> Workbook:
    from openpyxl import load_workbook  # noqa: PLC0415 - for workbooks only

    with warnings.catch_warnings(action="ignore"):  # of pictures and styles that are not read
        return load_workbook(io.BytesIO(data), data_only=True, keep_links=False)


def _check_unpacked(archive: zipfile.ZipFile, where: str) -> None:
    """Refuse an archive that says it is too large, and one that is larger than it says.

    Counted are also the elements that take more memory than room in the file.
    """
    parts = archive.infolist()
    if sum(part.file_size for part in parts) > _UNPACKED:
        message = f"a workbook of more than {_UNPACKED // 2**20} MB when unpacked"
        raise refuse(where, message, remedy=_REMEDY)
    if len({part.filename.lower() for part in parts}) < len(parts):
        raise ValueError("two parts of one name")
    elements = 0
    for part in parts:
        stated = copy(part)
        stated.file_size = _UNPACKED + 1  # zipfile would end where the directory says
        with archive.open(stated) as file:
            text = file.read(part.file_size + 1)
        if len(text) != part.file_size:
            raise ValueError("a part of another size than the directory says")
        if part.filename.lower().endswith((".xml", ".rels")):
            if _FORBIDDEN.search(text):
                raise ValueError("a document type in a workbook")
            elements += len(_ELEMENT.findall(text)) + _merged(text)
    if elements > 2 * _CELLS:
        raise refuse(where, f"more than {_CELLS} cells", remedy=_REMEDY)


def _merged(text: bytes) -> int:
    found = (match.groups() for match in _MERGED.finditer(text))
    return sum(
        (_column(right) - _column(left) + 1) * (int(low) - int(top) + 1)
        for left, top, right, low in found
    )


def _column(letters: bytes) -> int:
    number = 0
    for letter in letters:
        number = number * 26 + letter - 64
    return number


def _check_size(book: Workbook, where: str) -> None:
    sizes = [(sheet.max_row, sheet.max_column) for sheet in book.worksheets]
    if sum(rows * columns for rows, columns in sizes) > _CELLS:
        rows, columns = max(sizes, key=lambda size: size[0] * size[1])
        size = f"{rows} rows and {columns} columns"
        raise refuse(where, f"more than {_CELLS} cells: a sheet of {size}", remedy=_REMEDY)


def _sheet(sheet: _WorksheetLike, where: str) -> CellGrid:
    shows: dict[int, Callable[[object], Cell]] = {}
    rows: list[tuple[int, list[Cell]]] = []
    above: list[Row] = []
    remarks: dict[int, str] = {}
    for line, row in enumerate(sheet.iter_rows(), start=1):
        cells: list[Cell] = []
        for cell in row:
            shown: Callable[[object], Cell] = _cell
            if cell.has_style and cell.value is not None:
                style = cell.style_id
                if style not in shows:
                    shows[style] = _as_shown(cell.number_format, struck=bool(cell.font.strike))
                shown = shows[style]
            cells.append(shown(cell.value))
        texts = (cell.comment.text.split() for cell in row if cell.comment)
        comments = [str(_cell(" ".join(words))) for words in texts]
        if comments and any(isinstance(cell, float) for cell in cells):
            remarks[line] = "; ".join(comments)
        else:
            above += [text_row(line, [f"# {text}"]) for text in comments]
        rows.append((line, cells))
    above += [text_row(0, [f"# {text}"]) for text in _printed(sheet)]
    if remarks:
        rows = [(k, [*cells, "", remarks.get(k, "")]) for k, cells in rows]
    merged = ((m.min_col, range(m.min_row + 1, m.max_row + 1)) for m in sheet.merged_cells.ranges)
    columns = (one for one in sheet.column_dimensions.values() if one.hidden)
    return CellGrid(
        where,
        f"workbook, sheet {quoted(sheet.title)}",
        head_of(rows),
        rows,
        title=sheet.title,
        hidden=sheet.sheet_state != "visible",
        hidden_rows=frozenset(k for k, one in sheet.row_dimensions.items() if one.hidden),
        hidden_columns=frozenset(
            k for one in columns for k in range(one.min or 1, (one.max or 0) + 1)
        ),
        merged=frozenset((k, left) for left, below in merged for k in below),
        cover=above,
    )


def _printed(sheet: _WorksheetLike) -> list[str]:
    """Return the texts above and below a printed page, without the codes of dates and pages."""
    pages = filter(None, (sheet.oddHeader, sheet.oddFooter, sheet.firstHeader))
    parts = (part.text or "" for one in pages for part in (one.left, one.center, one.right))
    texts = (re.sub(r"&\[?\w+\]?", "", str(_cell(text))) for text in parts)
    return [" ".join(text.split()) for text in texts if text.split()]


def _as_shown(number_format: str, *, struck: bool) -> Callable[[object], Cell]:
    """Return what makes of a value the cell that a style shows."""
    section = number_format.partition(";")[0]
    percent = "%" in _LITERAL.sub("", section)
    digits = [found.end() for found in _DIGIT.finditer(section) if found[1]]
    behind = section[digits[-1] :] if digits else ""
    parts = 1000.0 ** (len(behind) - len(behind.lstrip(",")))
    literal = "".join(a or b for a, b in _LITERAL.findall(behind))
    unit = "%" if percent else literal.strip()

    def shown(value: object) -> Cell:
        cell = _cell(value)
        if isinstance(cell, float):
            cell = float(f"{cell / parts:.15g}")
        if isinstance(cell, float) and unit:
            cell = f"{cell * 100 if percent else cell:.15g} {unit}"
        if struck and cell != "":
            return f"{cell if isinstance(cell, str) else f'{cell:.15g}'}{STRUCK}"
        return cell

    return shown


def _cell(value: object) -> Cell:
    match value:
        case float():
            return value
        case None:
            return ""
        case bool():
            return str(value).upper()
        case int():
            return float(value)
        case datetime() | date() | time():
            return value.isoformat()
        case _:
            text = _CODE.sub(lambda code: chr(int(code[1], 16)), str(value))
            return _HALF.sub("\N{REPLACEMENT CHARACTER}", text)
