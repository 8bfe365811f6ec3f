"""A form above a header of known names: which row the header is, and what stands above it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence

from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import Faults
from scara_iso.tables.layout import HEAD, is_comment
from scara_iso.tables.numbers import BLANKS, parse_cell
from scara_iso.tables.preamble import read_preamble
from scara_iso.tables.text import Row

Line = tuple[int, Sequence[Cell]]
"""A row's number and its cells."""


def find_header(rows: Sequence[Line], count: Callable[[Sequence[Cell]], int]) -> int:
    """Return the place of the header among rows that are not blank.

    It is the row without a number of which most cells are known, by ``count``, and a row with a
    number follows; of several the last, as ``Operator, Anna`` may stand above. Else the first.
    """
    rows = rows[:HEAD]
    found = [
        (count(cells), k)
        for k, (_, cells) in enumerate(rows)
        if not is_comment_row(cells) and not _has_number(cells) and _numbers_follow(rows[k + 1 :])
    ]
    known, place = max(found, default=(0, 0))
    if not known:
        return next((k for k, (_, cells) in enumerate(rows) if not is_comment_row(cells)), 0)
    return next(k for k, (_, cells) in enumerate(rows) if [*cells] == [*rows[place][1]])


def count_known(rows: Sequence[Line], count: Callable[[Sequence[Cell]], int]) -> int:
    """Return how many cells of the header are known."""
    return count(rows[find_header(rows, count)][1]) if rows else 0


def read_form(rows: Iterable[Line], faults: Faults) -> tuple[dict[str, str], list[str]]:
    """Return what the rows of a form and comments state, by key, and a note for what is not used.

    Keys as `read_preamble` has them; two statements that differ, or rows of numbers, are a fault.
    """
    texts = [
        (line, [c if isinstance(c, str) else f"{c:.15g}" for c in cells]) for line, cells in rows
    ]
    joined = [
        Row(k, cells, ", ".join(c.strip() for c in cells if c.strip()), k) for k, cells in texts
    ]
    statements, notes = read_preamble(joined, sys.maxsize, faults)
    return {key: stated.value for key, stated in statements.items()}, notes


def is_comment_row(cells: Sequence[Cell]) -> bool:
    """Return whether a row begins with ``#``."""
    first = cells[0] if cells else ""
    return isinstance(first, str) and is_comment(first.strip(BLANKS))


def _has_number(cells: Sequence[Cell]) -> bool:
    return any(isinstance(cell, float) or parse_cell(cell) is not None for cell in cells)


def _numbers_follow(rows: Sequence[Line]) -> bool:
    following = (cells for _, cells in rows if not is_comment_row(cells))
    return _has_number(next(following, []))
