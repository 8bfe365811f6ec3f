"""Files that are no tables at all: said at once, before anything is looked for in them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from scara_iso.errors import DataError
from scara_iso.tables.faults import refuse

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
