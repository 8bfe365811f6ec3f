"""Bytes of a path, of standard input or of an open file, and their text: in pieces of whole lines.

Files that are no tables at all are said to be so at once, before anything is looked for in them.
"""

from __future__ import annotations

import codecs
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from scara_iso.base.errors import DataError
from scara_iso.base.files import not_read, open_file
from scara_iso.tables.faults import Faults, refuse

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
    """Return the text in the first page where it is not garbled, else in the first that fits."""
    found: list[tuple[str, str]] = []
    for codec, garbled in _CODE_PAGES.items():
        with suppress(UnicodeDecodeError):
            found.append((_decoded(data, codec), codec))
            if not re.search(garbled, found[-1][0]):
                return found[-1]
    if not found:
        what = f"not text in UTF-8, UTF-16 or {', '.join(_CODE_PAGES)}"
        raise refuse(where, what, remedy="save it as UTF-8 text (CSV)")
    return found[0]


_LETTER = r"[^\W\d_]"
_GARBLED_WORD = (
    rf"{_LETTER}[¡-©«-´¶¸¹»¼¾¿׃‚„…†‡ˆ‰‹›]{_LETTER}"
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
