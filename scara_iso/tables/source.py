"""Bytes of a path, of standard input or of an open file, to text or to the sheets of a workbook.

Files that are no tables at all are said to be so at once, before anything is looked for in them.

What a sheet shows is what its reader means: 0.012 as 1.2 %, thousands by a comma behind the digits,
a unit in the number's format, a cell that is struck through. A comment of a cell stands beside a
row of numbers, or above the table. What a sheet hides is told beside the rows.
"""

from __future__ import annotations

import codecs
import io
import re
import sys
import warnings
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from copy import copy
from datetime import date, datetime, time
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import not_read, open_file
from scara_iso.tables.grid import (
    STRUCK,
    Cell,
    CellGrid,
    Faults,
    FileText,
    Row,
    head_of,
    refuse,
    text_row,
)
from scara_iso.tables.vocabulary.words import quoted

if TYPE_CHECKING:
    from openpyxl import Workbook
    from openpyxl.workbook.workbook import _WorksheetLike


_READINGS = "name the table of readings (CSV or .xlsx)"
_TYPED = "type its readings into a table (CSV or .xlsx)"
_COPIED = "copy its table into a spreadsheet, and save that"
_KINDS = (
    ("a picture", _TYPED, (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"II*\0", b"MM\0*")),
    ("a PDF", _COPIED, (b"%PDF",)),
    ("a packed file", _READINGS, (b"\x1f\x8b", b"7z\xbc\xaf", b"Rar!")),
    ("a program", _READINGS, (b"\x7fELF", b"MZ\x90")),
)
"""What a file is by its first bytes, and what to do then."""
_WEB = ("<!doctype html", "<html")
_WORD = r"[^\W\d_]{2,}"
_NUMBER = r"\d+(?:[.,]\d+)?"
_READING = r"[\s\"']*[-+.,]?\d"
_WORDS = 5
"""A line of as many words, and three for each number, none of which begins it, is a sentence."""
_SHARE, _FEWEST = 0.5, 5
"""Share and number of sentences from which a file that is refused is called a text."""
LIMIT = 256 * 2**20
"""Largest file that is read, in bytes; a million rows take about 50 MB."""
WORKBOOK, OLD_WORKBOOK = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
"""First bytes of an .xlsx, and of an .xls or a protected workbook."""
Source = str | Path | bytes | BinaryIO


def read_bytes(source: Source) -> tuple[bytes, str]:
    """Return a source's bytes and its name: the path, or what else it is.

    Raises `NoInputError` where there is no such file or it cannot be read, `DataError` where it
    is larger than `LIMIT`, or a picture or the like.
    """
    name = _name(source)
    try:
        data = _read(source)
    except (OSError, ValueError) as error:
        raise not_read(name, error) from error
    if len(data) > LIMIT:
        raise refuse(name, f"larger than {LIMIT // 2**20} MB", remedy="split the file")
    for kind, remedy, starts in _KINDS:
        if data.startswith(starts):
            raise refuse(name, f"this is {kind}, not a table", remedy=remedy)
    return data, name


def refuse_other_marks(decimal: str | None) -> None:
    """Raise `UsageError` for what is given as the decimal mark and is none."""
    if decimal not in (None, ",", "."):
        raise UsageError(f"decimal mark {decimal!r}", remedy="use ',' or '.'")


def open_source(source: Source, remedy: str) -> tuple[str, list[CellGrid] | FileText]:
    """Return a source's name, and its sheets or its text; ``remedy`` is that of an empty one."""
    data, name = read_bytes(source)
    if not data.strip():
        raise refuse(name, "the file is empty", remedy=remedy)
    if data.startswith(WORKBOOK):
        return name, read_sheets(data, name)
    if data.startswith(OLD_WORKBOOK):
        what = "an old .xls or a protected workbook"
        raise refuse(name, what, remedy="save it as .xlsx or CSV")
    ended = bool(set(data[-2:]) & set(b"\r\n\x1a"))  # of two bytes: UTF-16
    text, encoding = decode(data, name)
    del data  # it may be large
    return name, FileText(plain_text(text, name), encoding, ended)


def _name(source: Source) -> str:
    match source:
        case "-":
            return "standard input"
        case str() | Path():
            return str(source)
        case bytes():
            return "bytes"
        case _:
            return str(getattr(source, "name", "file object"))


def _read(source: Source) -> bytes:
    match source:
        case bytes():
            return source
        case "-":
            if sys.stdin is None:
                raise OSError("standard input is closed")
            return sys.stdin.buffer.read(LIMIT + 1)
        case str() | Path():
            with open_file(source) as file:
                return file.read(LIMIT + 1)
        case _:
            return source.read(LIMIT + 1)


@contextmanager
def called_text(lines: Sequence[str], where: str) -> Iterator[None]:
    """Give one fault for all those of a web page or a text of sentences, by some of its lines."""
    lines = [line for line in lines if line.strip()]
    try:
        yield
    except DataError as error:
        if lines and lines[0].lstrip().lower().startswith(_WEB):
            raise refuse(where, "this is a web page, not a table", remedy=_COPIED) from error
        if sum(map(_is_sentence, lines)) >= max(_FEWEST, _SHARE * len(lines)):
            raise refuse(where, "this is a text, not a table", remedy=_READINGS) from error
        raise


def _is_sentence(line: str) -> bool:
    words = len(re.findall(_WORD, line))
    reading = re.match(_READING, line) is not None
    return not reading and words >= _WORDS and words > 3 * len(re.findall(_NUMBER, line))


_CHUNK = 500_000
_CONTROL = r"[\x00-\x08\x0b-\x1f\x7f-\x9f]"
_HARMLESS = b"\t\n" + bytes(range(0x20, 0x7F))
_BOMS = (
    (codecs.BOM_UTF8, "utf-8", "UTF-8 with BOM"),
    (codecs.BOM_UTF32_LE, "utf-32-le", "UTF-32"),
    (codecs.BOM_UTF16_LE, "utf-16-le", "UTF-16"),
    (codecs.BOM_UTF16_BE, "utf-16-be", "UTF-16"),
)


def decode_text(data: bytes, where: str) -> tuple[str, str]:
    """Return the text of a file, line ends as LF, and the name of its encoding.

    Raises `DataError` for text in no known encoding and for control characters.
    """
    text, encoding = decode(data, where)
    return plain_text(text, where), encoding


def plain_text(text: str, where: str) -> str:
    """Return a text with its line ends as LF; `DataError` for control characters."""
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    pieces = (text[k : k + _CHUNK] for k in range(0, len(text), _CHUNK))
    if text.isascii() and not any(p.encode().translate(None, _HARMLESS) for p in pieces):
        return text  # four times as fast
    faults = Faults(where)
    for match in re.finditer(_CONTROL, text):
        line = text.count("\n", 0, match.start()) + 1
        what = f"control character {match[0]!r}"
        faults.add(what, line, remedy="export the table again as text (CSV UTF-8)")
        faults.check()
    return text


def decode(data: bytes, where: str) -> tuple[str, str]:
    """Return the text of a file up to its last line end, and the name of its encoding.

    No more than the bytes and the text is held, so that a large file fits. Raises `DataError` for
    text in no known encoding.
    """
    remedy = "save it as UTF-8 text (CSV)"
    for bom, codec, name in _BOMS:
        if data.startswith(bom):
            try:
                return _decoded(data, codec, len(bom)), name
            except UnicodeDecodeError as error:
                what = f"begins as {name} and is not: {error.reason}"
                raise refuse(where, what, remedy=remedy) from error
    guesses = [("utf-8", "UTF-8")]
    if wide := _utf16_without_bom(data):
        guesses.insert(0, (wide, "UTF-16 without BOM"))
    for codec, name in guesses:
        with suppress(UnicodeDecodeError):
            return _decoded(data, codec), name
    return _in_a_code_page(data, where)


def _in_a_code_page(data: bytes, where: str) -> tuple[str, str]:
    """Return the text in the first page where it is not garbled, else in the first that fits.

    A text of western letters that no western language has together, and one of the east has where
    it is in cp1250, is in that.
    """
    found: list[tuple[str, str]] = []
    for codec, garbled in _CODE_PAGES.items():
        with suppress(UnicodeDecodeError):
            found.append((_decoded(data, codec), codec))
            if not re.search(garbled, found[-1][0]):
                break
    else:
        if found:
            return found[0]
        what = f"not text in UTF-8, UTF-16 or {', '.join(_CODE_PAGES)}"
        raise refuse(where, what, remedy="save it as UTF-8 text (CSV)")
    text, codec = found[-1]
    if codec == "cp1252" and not _is_of_one(text, _WESTERN):
        with suppress(UnicodeDecodeError):
            eastern = _decoded(data, "cp1250")
            if _is_of_one(eastern, _EASTERN):
                return eastern, "cp1250"
            return text, codec if eastern == text else f"{codec} (letters in doubt)"
    return text, codec


def _is_of_one(text: str, alphabets: Iterable[str]) -> bool:
    """Say whether one of the alphabets has all letters of a text."""
    letters = {c for c in {*text.lower()} if c.isalpha() and not c.isascii()} - {*"µªº"}
    return any(letters <= {*alphabet} for alphabet in alphabets) and not re.search(_NO_O, text)


_NO_O = r"[õÕ](?![eosmEOSM])|[ãÃ](?=[^\WaeosAEOS_])"
"""In Portuguese an e or s is behind it; else it is the ő or ă of cp1250."""
_WESTERN = (
    "äöüß",
    "àâæçéèêëîïôœùûüÿ",
    "áéíñóúü",
    "áàâãçéêíóôõú",
    "àèéìîíòóùú",
    "æøåéèóô",
    "åäöéü",
    "áéèêëíïóöúü",
    "áðéíóúýþæö",
    "àçèéíïòóúü",
)
_EASTERN = ("ąćęłńóśźż", "áčďéěíňóřšťúůýž", "áäčďéíľňóôšťúýž", "áéíóöőúüű", "čćđšž", "ăâîşţ")
"""Letters of languages beside the plain ones: German, French, Spanish and so on; Polish, Czech."""
_LETTER = r"[^\W\d_]"
_GARBLED_WORD = (
    rf"[^\W\d_mt]³|{_LETTER}[¡-©«-´¶¸¹»¼¾¿׃‚„…†‡ˆ‰‹›]{_LETTER}"
    rf"|(?<!\w)[£-¦¬¯¶¼¾]{_LETTER}|(?<!{_LETTER})[^\W\d_a-zA-Zµ]{{2,}}(?!{_LETTER})"
)
"""A symbol but ½ within a word, or a word without a plain letter: the page of another alphabet."""
_HALF_WIDTH = "[\uff61-\uff9f\ue000-\uf8ff]"
_CODE_PAGES = {
    "cp1252": _GARBLED_WORD,
    "cp1250": _GARBLED_WORD,
    "cp932": _HALF_WIDTH,
    "gb2312": _HALF_WIDTH,
}
"""What old programs write, and what shows that a text is in another of these pages."""


def _decoded(data: bytes, codec: str, begin: int = 0) -> str:
    """Return bytes as text without its last line ends, and the mark of old DOS programs, 0x1A."""
    ends = {end.encode(codec) for end in "\r\n\x1a"}
    width, last = len(min(ends)), len(data)
    while data[max(last - width, begin) : last] in ends:
        last -= width
    return str(memoryview(data)[begin:last], codec)


def _utf16_without_bom(data: bytes) -> str | None:
    head = data[:400]
    if len(head) < 4 or len(data) % 2:
        return None
    even, odd = head[::2], head[1::2]
    if not any(odd) and all(even):
        return "utf-16-le"
    return "utf-16-be" if not any(even) and all(odd) else None


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
_IN_FRONT = re.compile(r'"([^"]*)"|\\(.)|[_*].|\[[^\]]*\]|([-+()])')


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
    return sum(26**k * (letter - 64) for k, letter in enumerate(reversed(letters)))


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
        comments = [str(_cell(" ".join(c.comment.text.split()))) for c in row if c.comment]
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
        colours=_colours(sheet),
        cover=above,
    )


def _printed(sheet: _WorksheetLike) -> list[str]:
    """Return the texts above and below a printed page, without the codes of dates and pages."""
    pages = filter(None, (sheet.oddHeader, sheet.oddFooter, sheet.firstHeader))
    parts = (part.text or "" for one in pages for part in (one.left, one.center, one.right))
    texts = (re.sub(r"&\[?\w+\]?", "", str(_cell(text))) for text in parts)
    return [" ".join(text.split()) for text in texts if text.split()]


def _colours(sheet: _WorksheetLike) -> dict[int, frozenset[str]]:
    """Return the colours of each row, of paper (0) and letters (1), but for black on white."""
    own, found = dict[int, set[str]](), dict[int, frozenset[str]]()
    styled = (c for row in sheet.iter_rows() for c in row if c.has_style and c.value is not None)
    for cell in styled:
        if (style := cell.style_id) not in own:
            both = cell.fill.fill_type and cell.fill.fgColor, cell.font.color
            own[style] = {f"{n}{one.value}" for n, one in enumerate(both) if one} - _USUAL
        if own[style]:
            found[cell.row] = found.get(cell.row, frozenset()) | own[style]
    return found


_USUAL = {"00", "0FFFFFFFF", "000FFFFFF", "11", "164", "1FF000000", "100000000"}
"""White paper (0) and black letters (1), as the theme, the system or a number has them."""


def _as_shown(number_format: str, *, struck: bool) -> Callable[[object], Cell]:
    """Return what makes of a value the cell that a style shows."""
    section, *others = number_format.split(";")
    percent = "%" in _LITERAL.sub("", section)
    digits = [found.span() for found in _DIGIT.finditer(section) if found[1]]
    front, behind = (section[: digits[0][0]], section[digits[-1][1] :]) if digits else ("", "")
    parts = 1000.0 ** (len(behind) - len(behind.lstrip(",")))
    unit = "%" if percent else "".join(a or b for a, b in _LITERAL.findall(behind)).strip()
    before = "".join(map("".join, _IN_FRONT.findall(front))).lstrip().removesuffix("+")

    def shown(value: object) -> Cell:
        cell = _cell(value)
        if isinstance(cell, float):
            cell = float(f"{cell / parts:.15g}")
        if isinstance(cell, float) and (unit or before):
            sign = before if cell >= 0 or not others else ""
            cell = f"{sign}{cell * 100 if percent else cell:.15g} {unit}".rstrip()
        if struck and cell != "":
            return f"{cell if isinstance(cell, str) else f'{cell:.15g}'}{STRUCK}"
        return cell

    return shown


def _cell(value: object) -> Cell:
    match value:
        case None:
            return ""
        case bool():
            return str(value).upper()
        case int() | float():
            return float(value)
        case datetime() | date() | time():
            return value.isoformat()
        case _:
            text = _CODE.sub(lambda code: chr(int(code[1], 16)), str(value))
            return _HALF.sub("\N{REPLACEMENT CHARACTER}", text)
