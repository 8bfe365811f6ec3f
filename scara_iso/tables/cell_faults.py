"""What is wrong with a cell, and what to do about it."""

from __future__ import annotations

import re

from scara_iso.tables.faults import quoted
from scara_iso.tables.footers import names_a_footer
from scara_iso.tables.numbers import BLANKS, parse_cell

_LABEL = 64
_ISO_DATE = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}")
LABEL_POSES = "write the pose's name, such as P1, in each row, also for merged cells"
NUMBER_CYCLES = "write the cycle's number, 1 and up, in each row"
WRITE_TIMES = "write date and time as 2026-05-12T08:30:00 in each row, or call the column comment"
_READING = "write the reading as one number; where none was taken, "
_LEAVE_OUT = "remove the row and say `allow_gaps=`"
_NUMBER_FIRST = "number the rows in a column cycle, then "
_FORMULA = "; a formula has its result once a spreadsheet has saved the workbook"
_DATE = "the spreadsheet took the reading for a date: set the cell's format to Text and retype it"


def label_fault(label: str) -> str:
    """Return what is wrong with a pose label, or nothing."""
    if not label:
        return "is no pose"
    if names_a_footer(label):
        return "is the label of a footer, not of a pose"
    if len(label) > _LABEL:
        return f"is longer than the {_LABEL} characters of a pose label"
    if label[0] in "=@" or (label[0] in "+-" and parse_cell(label) is None):
        return "is a formula, not a pose"
    return ""


def write_a_reading(cell: str, *, in_sheet: bool, numbered: bool) -> str:
    """Return what to do where a cell holds no reading, ``in_sheet`` of a workbook.

    Where the cycles are not ``numbered``, nothing would say which of them is left out.
    """
    if in_sheet and _ISO_DATE.match(cell.strip(BLANKS)):
        return _DATE
    left_out = _LEAVE_OUT if numbered else _NUMBER_FIRST + _LEAVE_OUT
    return _READING + left_out + (_FORMULA if in_sheet and not cell.strip(BLANKS) else "")


def shown(cell: str | float) -> str:
    """Return a cell as a message shows it."""
    if isinstance(cell, float):
        return f"{cell:.15g}"
    return quoted(cell) if cell.strip(BLANKS) else "an empty cell"


def not_a_number(cell: str) -> str:
    """Return what is wrong with a cell that should hold a number."""
    if not cell.strip(BLANKS):
        return "empty cell"
    return f"{quoted(cell.strip(BLANKS))} is not a number"
