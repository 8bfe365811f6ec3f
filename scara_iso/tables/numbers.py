"""The grammar of a number in a table: stricter than ``float``, wider than one locale.

``float`` takes ``nan``, ``inf``, ``1_0`` and Arabic digits and knows no decimal comma. Here a
number is an optional sign (``+``, ``-``, U+2212 or U+2013), ASCII digits with at most one decimal
mark, an optional exponent, and an optional unit behind it.

How a table is spelt for the spreadsheet that will open it.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

import numpy as np

from scara_iso.run import FloatArray

BLANKS = " \t\u00a0\u2007\u2009\u202f"
"""Blanks that surround a number: space, tab, the non-breaking ones, figure and thin space."""
MINUS = "\u2212"


class Mark(Enum):
    """The decimal mark that a number, or a column of them, was written with."""

    NONE = "none"
    POINT = "a decimal point"
    COMMA = "a decimal comma"
    EITHER = "a comma that is a decimal or a thousands mark"
    BOTH = "a comma and a point in one number"


@dataclass(frozen=True, slots=True)
class CellNumber:
    """A cell's value, how its decimal mark was written, and the text of the unit behind it."""

    value: float
    mark: Mark
    unit: str


_CELL = re.compile(
    r"([+-]?)([0-9.,]*[0-9][.,]?)([eE][+-]?[0-9]+)?"
    rf"[{BLANKS}]*([^0-9{BLANKS}\s.,+=()-][^0-9=]{{0,19}})?"
)
_MINUSES = str.maketrans({MINUS: "-", "\u2013": "-"})
"""The signs of a negative number besides ``-``: the minus of Unicode, and the dash of a text."""
_IN_GROUPS = re.compile(
    r"[+-]?[1-9][0-9]{0,2}(?:([\u00a0\u202f\u2009])[0-9]{3})(?:\1[0-9]{3})*(?![0-9])"
)
_ONE_MARK = re.compile(r"[0-9]*\.?[0-9]*")
_GROUP_COMMA = re.compile(r"[1-9][0-9]{0,2},[0-9]{3}")
_GROUPED = {
    ".": r"[1-9][0-9]{0,2}(?:,[0-9]{3})+(?:\.[0-9]*)?",
    ",": r"[1-9][0-9]{0,2}(?:\.[0-9]{3})+(?:,[0-9]*)?",
}
_PLAIN_BYTES = b"0123456789+-.eE \n"


def parse_cell(text: str, decimal: str | None = None) -> CellNumber | None:
    """Return the number that ``text`` spells, or None where it spells none.

    With ``decimal`` None a lone mark is taken as the decimal mark and its ambiguity reported in
    `CellNumber.mark`; thousands groups are read only when ``decimal`` says which mark is which. The
    value may be infinite (``1e400``): the caller checks. A number with both marks has value 0.
    """
    match = _CELL.fullmatch(_plain(text))
    if match is None:
        return None
    sign, digits, exponent, unit = match.groups("")
    mark = _mark_of(digits)
    if decimal is None:
        plain = "0" if mark is Mark.BOTH else digits.replace(",", ".")
    else:
        plain = _with_stated_mark(digits, decimal)
    if not _ONE_MARK.fullmatch(plain):
        return None
    return CellNumber(float(sign + plain + exponent), mark, unit.strip(BLANKS))


def _plain(text: str) -> str:
    """Return a cell with plain signs, its thousands without the blanks that split no table."""
    text = text.strip(BLANKS).translate(_MINUSES)
    grouped = _IN_GROUPS.match(text)
    return text if grouped is None else text.replace(grouped[1], "", grouped[0].count(grouped[1]))


def _mark_of(digits: str) -> Mark:
    point = "." in digits
    if "," not in digits:
        return Mark.POINT if point else Mark.NONE
    grouped = _GROUP_COMMA.fullmatch(digits) is not None
    return Mark.BOTH if point else Mark.EITHER if grouped else Mark.COMMA


def count_decimals(text: str) -> int | None:
    """Return the digits behind a number's decimal mark; None with an exponent, or for no number."""
    match = _CELL.fullmatch(_plain(text))
    if match is None or match[3]:
        return None
    return len(match[2].replace(",", ".").partition(".")[2])


def _with_stated_mark(digits: str, decimal: str) -> str:
    other = "," if decimal == "." else "."
    if other in digits:
        if not re.fullmatch(_GROUPED[decimal], digits):
            return "?"
        digits = digits.replace(other, "")
    return digits.replace(decimal, ".")


def cut_unit(cells: Sequence[str]) -> tuple[Sequence[str], str]:
    """Return cells without the unit that stands behind each of them, and that unit.

    The cells as they are and "" where they do not all end in the unit of the first.
    """
    first = parse_cell(cells[0]) if cells else None
    unit = first.unit if first else ""
    if not unit or set(unit) & set(".,") or not all(cell.endswith(unit) for cell in cells):
        return cells, ""
    return [cell.removesuffix(unit).rstrip(BLANKS) for cell in cells], unit


def parse_clean(cells: Sequence[str], decimal: str | None) -> tuple[FloatArray, Mark] | None:
    """Return the values, shape (cells,), of a column of plain finite numbers, or None.

    The quick way for what most files hold: over the characters ``0-9 + - . e E`` the grammar of
    ``float`` and that of `parse_cell` are the same. None means: go cell by cell.
    """
    joined = "\n".join(cells)
    comma, point = "," in joined, "." in joined
    if (comma and (point or decimal == ".")) or (point and decimal == ","):
        return None
    if comma:
        joined = joined.replace(",", ".")
    if not joined.isascii() or joined.encode().translate(None, _PLAIN_BYTES):
        return None
    try:
        plain = joined.split("\n") if comma else cells
        values = np.fromiter(map(float, plain), np.float64, len(plain))
    except ValueError:
        return None
    if not np.isfinite(values).all():
        return None
    if comma:
        sure = any("," in c and not _GROUP_COMMA.fullmatch(c.strip(" +-")) for c in cells)
        return values, Mark.COMMA if sure else Mark.EITHER
    return values, Mark.POINT if point else Mark.NONE


FORMULA = "=+-@\uff1d\uff0b\uff0d\uff20"
"""What a formula begins with, the second four in the width of East Asian letters."""
_CONTROL = r"[\x00-\x1f\x7f-\x9f]+"


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
    return re.sub(_CONTROL, " ", text)


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
