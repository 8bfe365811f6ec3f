"""A report as a workbook: numbers are numbers, and no text is a formula."""

from __future__ import annotations

import io
import re
import zipfile
from datetime import datetime
from typing import TYPE_CHECKING

from scara_iso.render.formats._lines import Line, section_lines
from scara_iso.render.pictures import picture_png, picture_size
from scara_iso.reporting import Document, Figure, Number, labels_of, printable
from scara_iso.tables import FORMULA

if TYPE_CHECKING:
    from openpyxl import Workbook
    from openpyxl.cell.cell import Cell, MergedCell
    from openpyxl.worksheet.worksheet import Worksheet

_LONGEST = 32_767  # characters of a cell, Excel's specification
_CODE = re.compile("_(?=x[0-9A-Fa-f]{4}_)")
"""What begins the code of a character in a workbook: ``_x0041_`` is shown as A."""
_EPOCH = datetime(1980, 1, 1)  # noqa: DTZ001 - the earliest time that a ZIP file can hold
_MODIFIED = re.compile(rb"(<dcterms:modified[^>]*>)[^<]*")
_WIDTHS = (24, 16)
_SHEET = "Report"
_READINGS = "Raw data"
_FIGURES = "Figures"
_ROW_HEIGHT = 20  # [pixel], of a row that nobody changed


def render(document: Document) -> bytes:
    """Return a report as the bytes of an .xlsx file, the raw data on sheets of their own."""
    from openpyxl import Workbook  # noqa: PLC0415 - for workbooks only

    book = Workbook()
    book.remove(book.worksheets[0])
    sheets = {name: book.create_sheet(name) for name in (_SHEET, _READINGS)}
    _append(sheets[_SHEET], Line((document.title,), heading=True))
    labels = labels_of(document.language)
    for section in document.sections:
        sheet = sheets[_READINGS if section.raw else _SHEET]
        first, *lines = section_lines(section, labels)
        for line in (first, *lines) if section.heading else lines:
            _append(sheet, line)
    _draw(book, document)
    for sheet in sheets.values():
        for k in range(1, 13):
            sheet.column_dimensions[chr(64 + k)].width = _WIDTHS[min(k - 1, 1)]
    book.properties.created = book.properties.modified = _EPOCH
    book.properties.creator = "scara-iso"
    file = io.BytesIO()
    book.save(file)
    return _without_times(file.getvalue())


def _draw(book: Workbook, document: Document) -> None:
    from openpyxl.drawing.image import Image  # noqa: PLC0415 - for workbooks only

    blocks = [block for section in document.sections for block in section.blocks]
    figures = [block for block in blocks if isinstance(block, Figure)]
    if not figures:
        return
    sheet, row = book.create_sheet(_FIGURES, 1), 1
    for figure in figures:
        _write_text(sheet.cell(row, 1), printable(f"{figure.title}: {figure.caption}"))
        image = Image(io.BytesIO(picture_png(figure)))
        image.width, image.height = (round(96 * size) for size in picture_size(figure))
        sheet.add_image(image, f"A{row + 1}")
        row += 3 + image.height // _ROW_HEIGHT


def _append(sheet: Worksheet, line: Line) -> None:
    from openpyxl.styles import Font  # noqa: PLC0415 - for workbooks only

    row = sheet.max_row + 1 if sheet.max_row > 1 or sheet.cell(1, 1).value is not None else 1
    if not line.cells:
        sheet.cell(row, 1, " ")
    for k, content in enumerate(line.cells, start=1):
        cell = sheet.cell(row, k)
        if isinstance(content, Number):
            cell.value = content.value
            cell.number_format = _number_format(content)
        else:
            _write_text(cell, printable(content))
        if line.heading:
            cell.font = Font(bold=True)


def _write_text(cell: Cell | MergedCell, text: str) -> None:
    cell.value = _CODE.sub("_x005F_", text[:_LONGEST])
    cell.data_type = "s"  # whatever it begins with: not a formula
    cell.quotePrefix = text.startswith(tuple(FORMULA))  # nor when somebody edits the cell


def _number_format(number: Number) -> str:
    mantissa, exponent, _ = number.digits.rstrip("%").partition("e")
    places = len(mantissa.partition(".")[2])
    shape = f"0.{'0' * places}".rstrip(".") + ("E+00" if exponent else "")
    shape += "%" if number.digits.endswith("%") else ""
    if number.mark:
        return f'"{number.mark}"{shape}'
    return f"+{shape};-{shape};+{shape}" if number.spec.startswith("+") else shape


def _without_times(data: bytes) -> bytes:
    """Return a ZIP file with the same members and none of the moments at which they were made."""
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(file, "w") as new:
        for name in old.namelist():
            member = zipfile.ZipInfo(name)  # of 1980
            member.compress_type = zipfile.ZIP_DEFLATED
            content = old.read(name)
            if name == "docProps/core.xml":
                content = _MODIFIED.sub(rb"\g<1>1980-01-01T00:00:00Z", content)
            new.writestr(member, content)
    return file.getvalue()
