"""Bytes to text, text to lines, lines to cells. No line or table is understood here.

Files that are no tables at all: said at once, before anything is looked for in them.

Bytes of a path, of standard input, or of an open file.
"""

from __future__ import annotations

import codecs
import csv
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import BinaryIO

from scara_iso.base.errors import DataError
from scara_iso.base.files import not_read, open_file
from scara_iso.tables.faults import Faults, refuse
from scara_iso.tables.numbers import BLANKS

_PICTURE, _PAGE, _PACKED = "a picture", "a PDF", "a packed file"
_SIGNATURES = {
    b"\x89PNG": _PICTURE,
    b"\xff\xd8\xff": _PICTURE,
    b"GIF8": _PICTURE,
    b"II*\0": _PICTURE,
    b"MM\0*": _PICTURE,
    b"%PDF": _PAGE,
    b"\x1f\x8b": _PACKED,
    b"7z\xbc\xaf": _PACKED,
    b"Rar!": _PACKED,
    b"\x7fELF": "a program",
    b"MZ\x90": "a program",
}
_REMEDIES = {
    _PICTURE: "type its readings into a table (CSV or .xlsx)",
    _PAGE: "copy its table into a spreadsheet, and save that",
}
_REMEDY = "name the table of readings (CSV or .xlsx)"
_WORD = re.compile(r"[^\W\d_]{2,}")
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
_READING = re.compile(r"[\s\"']*[-+.,]?\d")
_WORDS = 5
"""A line of as many words, and three for each number, none of which begins it, is a sentence."""
_WEB = (b"<!doctype html", b"<html")
_SHARE, _FEWEST = 0.5, 5
"""Share and number of sentences from which a file that is refused is called a text."""
TEXT_HEAD = 100_000
"""Bytes in which a text is known by its sentences."""


def refuse_other_kind(data: bytes, where: str) -> None:
    """Raise `DataError` for a picture, a PDF and the like, by its first bytes."""
    kind = next((kind for start, kind in _SIGNATURES.items() if data.startswith(start)), None)
    if kind is not None:
        raise refuse(where, f"this is {kind}, no table", remedy=_REMEDIES.get(kind, _REMEDY))


@contextmanager
def called_text(head: bytes, where: str) -> Iterator[None]:
    """Give one fault for all those of a text of sentences, by its ``head``."""
    try:
        yield
    except DataError as error:
        if head.lstrip().lower().startswith(_WEB):
            raise refuse(where, "this is a web page, no table", remedy=_REMEDIES[_PAGE]) from error
        if _is_text(head.decode("utf-8", "replace")):
            raise refuse(where, "this is a text, no table", remedy=_REMEDY) from error
        raise


def _is_text(text: str) -> bool:
    lines = [line for line in text.splitlines() if line.strip()]
    sentences = sum(map(_is_sentence, lines))
    return sentences >= max(_FEWEST, _SHARE * len(lines))


def _is_sentence(line: str) -> bool:
    words = len(_WORD.findall(line))
    reading = _READING.match(line) is not None
    return not reading and words >= _WORDS and words > 3 * len(_NUMBER.findall(line))


LIMIT = 256 * 2**20
"""Largest file that is read, in bytes; a million rows take about 50 MB."""

WORKBOOK = b"PK\x03\x04"
OLD_WORKBOOK = b"\xd0\xcf\x11\xe0"
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
    refuse_other_kind(data, name)
    return data, name


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


LINE_LIMIT = 1_000_000
"""Characters in one line: bounds the length of a cell and the number of columns."""
_CHUNK = 500_000
_JOINED = 5
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
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
    _refuse_control(text, where)
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
                raise refuse(
                    where, f"begins as {name} and is not: {error.reason}", remedy=remedy
                ) from error
    guesses = [("utf-8", "UTF-8"), ("cp1252", "cp1252")]
    wide = _utf16_without_bom(data)
    if wide:
        guesses.insert(0, (wide, "UTF-16 without BOM"))
    for codec, name in guesses:
        with suppress(UnicodeDecodeError):
            return _decoded(data, codec), name
    raise refuse(where, "not text in UTF-8, UTF-16 or cp1252", remedy=remedy)


def _decoded(data: bytes, codec: str, begin: int = 0) -> str:
    """Return bytes as text without its last line ends, and the mark of old DOS programs, 0x1A."""
    ends = {end.encode(codec) for end in "\r\n\x1a"}
    width, last = len(min(ends)), len(data)
    while data[max(last - width, begin) : last] in ends:
        last -= width
    return str(memoryview(data)[begin:last], codec)


def _utf16_without_bom(data: bytes) -> str | None:
    """Return the byte order if every second byte of the head is NUL and no other is."""
    head = data[:400]
    if len(head) < 4 or len(data) % 2:
        return None
    even, odd = head[::2], head[1::2]
    if not any(odd) and all(even):
        return "utf-16-le"
    return "utf-16-be" if not any(even) and all(odd) else None


def _refuse_control(text: str, where: str) -> None:
    pieces = (text[k : k + _CHUNK] for k in range(0, len(text), _CHUNK))
    if text.isascii() and not any(p.encode().translate(None, _HARMLESS) for p in pieces):
        return  # four times as fast
    faults = Faults(where)
    for match in _CONTROL.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        what = f"control character {match[0]!r}"
        faults.add(what, line, remedy="export the table again as text (CSV UTF-8)")
        faults.check()


def in_pieces(text: str) -> list[str]:
    """Return whole lines of ``text`` in pieces of about half a million characters."""
    pieces, start = [], 0
    while start <= len(text):
        end = text.find("\n", start + _CHUNK)
        end = len(text) if end < 0 else end
        pieces.append(text[start:end])
        start = end + 1
    return pieces


def taken_from(pieces: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the lines of each piece with the number, from 1, of its first; no piece is left.

    What is made of the lines then takes the place of the text.
    """
    line = 1
    for k in range(len(pieces)):
        lines, pieces[k] = pieces[k].split("\n"), ""
        yield line, lines
        line += len(lines)


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
_ENDS = {d: BLANKS + _CHARACTER.get(d, "") for d in Delimiter}
_SEP = re.compile(r'"?sep=([,;\t])"?[,;\t]*', re.IGNORECASE)
_WIDE = re.compile(rf"[{BLANKS}]{{2,}}|\t")
_ANY_BLANK = str.maketrans(dict.fromkeys(BLANKS, " "))
# In a table of single blanks a unit behind a value or a name belongs to it.
_GLUE = re.compile(r"(?<=\S) +(?=[\[(])|(?<=[0-9.,]) +(?=(?:mm|[uµμ]m|inch|in|deg|°)(?: |$))")


def separator_of(delimiter: Delimiter) -> str | None:
    """Return the one character between two cells; None where it is not always one."""
    alone = (Delimiter.TAB, Delimiter.SEMICOLON, Delimiter.COMMA)
    return _CHARACTER[delimiter] if delimiter in alone else None


@dataclass(frozen=True, slots=True)
class Row:
    """Cells of one row, its text, and the lines it begins and ends on (a header may hold two)."""

    line: int
    cells: list[str]
    text: str
    end: int


def stated_delimiter(line: str) -> Delimiter | None:
    """Return the delimiter that a spreadsheet's ``sep=;`` line states."""
    match = _SEP.fullmatch(line.strip(" "))
    return next(d for d, c in _CHARACTER.items() if c == match[1]) if match else None


def split_lines(lines: list[str], delimiter: Delimiter) -> list[list[str]]:
    """Return the cells of each line; raises ``csv.Error`` where quoting breaks a line."""
    if delimiter is Delimiter.WIDE_BLANKS:
        return [[_unquoted(cell) for cell in _WIDE.split(line.strip(BLANKS))] for line in lines]
    if delimiter is Delimiter.BLANKS:
        lines = [_GLUE.sub("", line.translate(_ANY_BLANK).strip(" ")) for line in lines]
    if delimiter is Delimiter.BAR:
        return [_between_bars(line) for line in lines]
    character = _CHARACTER[delimiter]
    if '"' not in "".join(lines):
        sep = None if delimiter is Delimiter.BLANKS else character
        return [line.split(sep) for line in lines]
    cells = list(csv.reader(lines, delimiter=character, skipinitialspace=True, strict=True))
    if len(cells) != len(lines):
        raise csv.Error("a quoted cell holds a line end")
    return cells


def _between_bars(line: str) -> list[str]:
    """Return the cells of a row of Markdown or of a console's table, its outer bars taken off."""
    line = line.strip(BLANKS)
    return [cell.strip(BLANKS) for cell in line.removeprefix("|").removesuffix("|").split("|")]


def split_columns(
    lines: list[str], delimiter: Delimiter, width: int
) -> Sequence[Sequence[str]] | None:
    """Return the columns of lines that have ``width`` cells each, or None where they have not."""
    character = _CHARACTER.get(delimiter)
    if character is None or delimiter in (Delimiter.BLANKS, Delimiter.BAR) or '"' in "".join(lines):
        try:
            rows = split_lines(lines, delimiter)
        except csv.Error:
            return None
        return list(zip(*rows, strict=True)) if set(map(len, rows)) == {width} else None
    if {line.count(character) for line in lines} != {width - 1}:
        return None
    cells = character.join(lines).split(character)
    return [cells[k::width] for k in range(width)]


def _unquoted(cell: str) -> str:
    return cell[1:-1] if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell


def split_head(lines: list[str], delimiter: Delimiter) -> list[Row]:
    """Return the rows of a file's head; a quoted cell may hold up to four line ends.

    A line whose quoting cannot be mended is one row of one cell.
    """
    rows: list[Row] = []
    position = 0
    while position < len(lines):
        limit = 1 if lines[position].startswith("#") else _JOINED
        for count in range(1, limit + 1):
            with suppress(csv.Error):
                piece = "\n".join(lines[position : position + count])
                cells = split_lines([piece], delimiter)[0]
                break
        else:
            count, cells = 1, [lines[position]]
        text = cells[0] if len(cells) == 1 else lines[position].strip(_ENDS[delimiter])
        rows.append(Row(position + 1, cells, text.strip(), position + count))
        position += count
    return rows
