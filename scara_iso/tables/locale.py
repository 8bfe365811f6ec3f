"""How a table is spelt for the spreadsheet that will open it."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from scara_iso.tables.numbers import Mark, parse_cell

FORMULA = "=+-@\uff1d\uff0b\uff0d\uff20"
"""What a formula begins with, the second four in the width of East Asian letters."""
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]+")


class Digits(str):
    """A number spelt with a decimal point, its digits chosen."""

    __slots__ = ()


OutputCell: TypeAlias = str | Digits | int | float | None
"""Text, a number, or nothing; only text is ever guarded against being taken for a formula."""


@dataclass(frozen=True, slots=True)
class SheetLocale:
    """What stands between cells, the decimal mark, and what the file begins with."""

    delimiter: str = ","
    decimal: str = "."
    bom: str = ""


PLAIN = SheetLocale()
"""The canonical table."""
# A German Excel splits at semicolons, an English one at commas; both take a file without a byte
# order mark for one of the old code pages.
EXCEL = {"de": SheetLocale(";", ",", "\ufeff"), "en": SheetLocale(",", ".", "\ufeff")}


def find_locale(name: object) -> SheetLocale:
    """Return the locale of an Excel by its language; `PLAIN` for anything else."""
    return EXCEL.get(name, PLAIN) if isinstance(name, str) else PLAIN


def write_rows(rows: Iterable[Sequence[OutputCell]], locale: SheetLocale = PLAIN) -> str:
    """Return rows as CSV with LF line ends, without the byte order mark.

    Numbers stay numbers, whatever their sign; what is not finite is an empty cell. Text is kept on
    one line and cannot become a formula.
    """
    spelt = [[_spell(cell, locale) for cell in row] for row in rows]
    if locale.decimal == ",":
        _settle_commas(spelt)
    file = io.StringIO()
    csv.writer(file, delimiter=locale.delimiter, lineterminator="\n").writerows(spelt)
    return file.getvalue()


def text_cell(text: str) -> str:
    """Return text that no spreadsheet takes for a formula; what spells a number is left alone.

    -2 mm spells none: a spreadsheet would work it out, and show an error.
    """
    text = one_line(text)
    start = text.lstrip()[:1]
    if start == "'" or (start and start in FORMULA and not _is_number(text)):
        return "'" + text
    return text


def _is_number(text: str) -> bool:
    number = parse_cell(text)
    return number is not None and not number.unit


def one_line(text: str) -> str:
    """Return text with a blank for control characters."""
    return _CONTROL.sub(" ", text)


def _spell(cell: OutputCell, locale: SheetLocale) -> str:
    match cell:
        case None:
            return ""
        case Digits():
            return Digits(cell.replace(".", locale.decimal))
        case str():
            return text_cell(cell)
        case float() if not math.isfinite(cell):
            return ""
        case _:
            return Digits(str(cell).replace(".", locale.decimal))


def _settle_commas(rows: list[list[str]]) -> None:
    """Let 1,234 end in a zero where no other number says that the comma is a decimal one."""
    numbers = [parse_cell(cell) for row in rows for cell in row if isinstance(cell, Digits)]
    if any(number and number.mark is Mark.COMMA for number in numbers):
        return
    for row in rows:
        for k, cell in enumerate(row):
            number = parse_cell(cell) if isinstance(cell, Digits) else None
            if number and number.mark is Mark.EITHER:
                mantissa, e, exponent = cell.partition("e")
                row[k] = f"{mantissa}0{e}{exponent}"
