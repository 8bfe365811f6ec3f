"""A report as a PDF, for those who file paper: the same blocks, the pictures as bitmaps."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from scara_iso.errors import UsageError
from scara_iso.render.pictures import font_file, picture_png, picture_size
from scara_iso.reporting import Block, Document, Figure, Notice, Strip, Table, Text, printable

if TYPE_CHECKING:
    from fpdf import FPDF

_BODY, _SMALL, _TINY = 9, 7.5, 6.5
_WIDTH = 90  # of a picture [mm]: two stand beside each other
_LINE = 4.6  # [mm]
_ROW, _SHORT = 4.6, 12  # height of a row [mm]; rows of a table that no page divides
_LONGEST = 1500  # characters of a cell
_NARROW = 8  # columns of a table, from which on its letters are smaller
_BROAD = 16  # columns that a page holds


def render(document: Document) -> bytes:
    """Return a report as the bytes of a PDF; `UsageError` without the library for it."""
    pdf = _open(document.title)
    pdf.set_font(style="B", size=15)
    pdf.multi_cell(0, 8, printable(document.title), new_x="LMARGIN", new_y="NEXT")
    for section in document.sections:
        if section.heading:
            _heading(pdf, printable(section.heading), _room(section.blocks[:1]))
        pending: list[Figure] = []
        for block in section.blocks:
            if isinstance(block, Figure):
                pending.append(block)
            else:
                _figures(pdf, pending)
                _block(pdf, block)
        _figures(pdf, pending)
    _sign(pdf)
    from fpdf.fonts import TTFFont  # noqa: PLC0415 - an extra

    content = bytes(pdf.output())
    for font in pdf.fonts.values():
        if isinstance(font, TTFFont):
            font.ttfont.close()
    return content


def _open(title: str) -> FPDF:
    try:
        from fpdf import FPDF  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise UsageError(
            "a PDF needs the package fpdf2",
            remedy="pip install 'scara-iso[pdf]', or print the .html from a browser",
        ) from error

    class Paper(FPDF):
        def footer(self) -> None:
            self.set_y(-12)
            self.set_font(size=_TINY)
            self.cell(0, 5, f"{self.page_no()} / {{nb}}", align="R")

    pdf = Paper(format="A4")
    pdf.set_creation_date(datetime(1980, 1, 1, tzinfo=UTC))
    pdf.set_title(printable(title))
    pdf.set_margins(15, 15)
    pdf.set_auto_page_break(True, 18)
    pdf.add_font("DejaVu", "", font_file("DejaVuSans.ttf"))
    pdf.add_font("DejaVu", "B", font_file("DejaVuSans-Bold.ttf"))
    pdf.set_font("DejaVu", size=_BODY)
    pdf.add_page()
    return pdf


def _sign(pdf: FPDF) -> None:
    if pdf.will_page_break(25):
        pdf.add_page()
    top = pdf.get_y() + 18
    pdf.set_font(style="", size=_SMALL)
    pdf.set_draw_color(0)
    for left, said in ((pdf.l_margin, "place, date"), (pdf.l_margin + _WIDTH, "name, signature")):
        pdf.line(left, top, left + _WIDTH - 10, top)
        pdf.set_xy(left, top + 1)
        pdf.cell(_WIDTH - 10, 4, said)


def _room(first: tuple[Block, ...]) -> float:
    """Return the height that a heading and what follows it need to stay together [mm]."""
    match first:
        case (Figure(),):
            return 80
        case (Table() as table,):
            return 18 + _ROW * min(len(table.rows), _SHORT)
    return 25


def _heading(pdf: FPDF, heading: str, room: float) -> None:
    if pdf.will_page_break(room):
        pdf.add_page()
    pdf.ln(4)
    pdf.set_font(style="B", size=11)
    pdf.set_text_color(11, 90, 143)
    pdf.multi_cell(0, 6, heading, new_x="LMARGIN", new_y="NEXT")
    pdf.set_text_color(0)


def _block(pdf: FPDF, block: Block) -> None:
    match block:
        case Text():
            _say(pdf, block.text, style="B" if block.tone in ("strong", "bad", "warn") else "")
        case Table():
            for part in _parts(block):
                _table(pdf, part)
            if block.note:
                _say(pdf, block.note, size=_TINY)
        case Notice():
            subject = f"{block.subject}: " if block.subject else ""
            _say(pdf, f"{block.severity}: {subject}{block.text} [{block.code}]")
        case Strip():
            _say(pdf, f"{block.label}: {block.caption}")


def _say(pdf: FPDF, text: str, *, size: float = _BODY, style: str = "") -> None:
    pdf.set_font(style=style, size=size)
    pdf.multi_cell(
        0, _LINE * size / _BODY, printable(text), new_x="LMARGIN", new_y="NEXT", align="L"
    )


def _parts(table: Table) -> Iterator[Table]:
    """Yield a table in pieces that a page is broad enough for, each with the first column."""
    for k in range(1, max(len(table.header), 2), _BROAD - 1):
        cut = slice(k, k + _BROAD - 1)
        rows = tuple((row[0], *row[cut]) for row in table.rows)
        yield replace(table, header=(table.header[0], *table.header[cut]), rows=rows)


def _table(pdf: FPDF, table: Table) -> None:
    if len(table.rows) <= _SHORT and pdf.will_page_break(_ROW * (len(table.rows) + 1)):
        pdf.add_page()
    pdf.set_draw_color(207, 214, 221)
    pdf.set_font(style="", size=_TINY if len(table.header) >= _NARROW else _SMALL)
    aligned = ("LEFT", *["LEFT" if table.verbatim else "RIGHT"] * (len(table.header) - 1))
    widths = (1, 3) if table.verbatim and len(table.header) == 2 else None
    with pdf.table(
        text_align=aligned, col_widths=widths, line_height=4, borders_layout="HORIZONTAL_LINES",
        padding=(0.3, 0.8), first_row_as_headings=True,
    ) as grid:  # fmt: skip
        for row in (table.header, *table.rows):
            line = grid.row()
            for cell in row:
                line.cell(_bounded(printable(str(cell))))


def _bounded(text: str) -> str:
    """Return text that a page can hold: a row of a table is never divided."""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ... (shortened)"


def _figures(pdf: FPDF, figures: list[Figure]) -> None:
    """Draw figures in twos and forget them."""
    for pair in (figures[k : k + 2] for k in range(0, len(figures), 2)):
        heights = [_WIDTH * picture_size(f)[1] / picture_size(f)[0] for f in pair]
        if pdf.will_page_break(max(heights) + 14):
            pdf.add_page()
        top, left = pdf.get_y(), pdf.l_margin
        lowest = top
        for k, (figure, height) in enumerate(zip(pair, heights, strict=True)):
            x = left + k * _WIDTH
            image = io.BytesIO(picture_png(figure))
            said = printable(f"{figure.title}: {figure.caption}")
            pdf.image(image, x=x, y=top, w=_WIDTH - 3, alt_text=said)
            pdf.set_xy(x, top + height)
            pdf.set_font(style="", size=_TINY)
            pdf.multi_cell(_WIDTH - 5, 3.4, said, align="L")
            lowest = max(lowest, pdf.get_y())
        pdf.set_xy(left, lowest + 2)
    figures.clear()
