"""What remarks and lines of words say of readings, and which of them may change a figure."""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Sequence

import numpy as np
import numpy.typing as npt

from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import LEAVE_OUT, LEAVE_ROWS_OUT, REMARK, quoted
from scara_iso.tables.grid import Row, is_comment
from scara_iso.tables.layout import ONE_COLUMN
from scara_iso.tables.names import Column, Kind, is_axis
from scara_iso.tables.numbers import count_decimals, parse_cell
from scara_iso.tables.statements import (
    OTHER_SIZE,
    RECORDER,
    REMARKED,
    KeyValue,
    is_of_axes,
    read_statements,
)
from scara_iso.tables.words import (
    WORDS,
    clean,
    holds_an_open_number,
    holds_an_open_ratio,
    is_of_another,
    names_a_limit,
    numbers_a_thing,
    speaks_of_cycles,
    speaks_of_size,
    strikes_its_row,
    topic_of,
    unknown_words,
)

_SENTENCE = 3
"""Words of a value that may say something of the readings."""
_IN_CAPITALS = re.compile(r"(?=.*[A-ZÀ-Ý]{3})[^a-zß-ÿ]*$")
"""Where Y may be the Spanish for and."""
_FACTORS = (0.5, 2.0)
"""Numbers that readings may be multiplied by."""
TWO, RARE = 2, 0.2
"""A column that marks some rows has two values, and one of them is rare."""


def check_remarks(columns: Columns, others: Iterable[Row], *, discarded: int = 1) -> None:
    """Add each remark that says of its row that it does not count; the ``discarded`` first do not.

    ``others`` are what stands behind the columns of the rows.
    """
    leave_out = LEAVE_OUT if discarded else f"{LEAVE_ROWS_OUT}, and the"
    lines = columns.all_lines()
    remarks = [(r.text, r.line, 1 + [*map(bool, r.cells)].index(True)) for r in others]
    for column in columns.layout.of(Kind.COMMENT):
        texts = columns.labels(column)
        last = dict(zip(texts.tolist(), lines.tolist(), strict=True))
        if len(last) == 1 and not discarded:  # what every row says strikes none
            continue
        remarks += [(remark, line, column.position + 1) for remark, line in last.items()]
        if len(last) > 1 and all(map(is_axis, last)):
            what = f"{column.called} names the axis of each row"
            columns.fault(column, what, remedy=ONE_COLUMN)
        if mark := _rare_mark(texts[discarded:]):
            what = f"{quoted(mark)} in few rows, another word in all others: do all of them count?"
            first = int(lines[discarded:][texts[discarded:] == mark][0])
            columns.fault(column, what, first, remedy=f"{leave_out} column")
    for remark, line, place in remarks:
        if line not in lines[:discarded] and strikes_its_row(remark):
            what = f"{quoted(remark)}, and readings of this {columns.faults.row} are counted"
            columns.faults.add(what, line, place, remedy=f"{leave_out} remark")


def rare_remarks(columns: Columns, column: Column) -> list[tuple[int, str]]:
    """Return line and text of what a column says at a fifth of its rows or fewer, quoted."""
    texts, lines = columns.labels(column), columns.all_lines()
    known, counts = np.unique(texts, return_counts=True)
    rows = np.flatnonzero(texts != ("" if "" in known else known[counts.argmax()]))
    few = rows if len(rows) <= RARE * len(texts) else rows[:0]
    return [(int(lines[k]), quoted(str(texts[k]))) for k in few]


def rows_in_words(columns: Columns, lines: Iterable[Row]) -> list[str]:
    """Return what lines of words, wherever they stand, say of some of the rows or of all readings.

    Those of the recorder say more.
    """
    rows, found = len(columns.all_lines()), []
    axes = {column.name for column in columns.layout.of(Kind.AXIS)}
    for row in lines:
        stated = read_statements(row)
        keys = [one.key for one in stated]
        own = REMARKED in keys or any(key.startswith(RECORDER) for key in keys)
        matters = speaks_of_cycles(row.text, rows) or speaks_of_size(row.text)
        matters = matters or holds_an_open_ratio(row.text) or _is_of_an_axis(row, stated, axes)
        numbers = filter(None, map(parse_cell, row.cells))
        if not is_comment(row.text) and not any(one.unit.isascii() for one in numbers):
            matters = matters or (not keys and holds_an_open_number(row.text, rows))
            matters = matters or any(_is_open(one, rows) for one in stated)
        if matters and not own and not any(map(is_of_axes, keys)):
            place = columns.faults.place(row.line)
            found.append(f"{place} {quoted(row.text.strip('# '), REMARK)}")
    return found


_AN_AXIS = re.compile(
    r"(?<![0-9A-Za-zÀ-ɏ_.-])([XYZ]|theta)(?![0-9A-Za-zÀ-ɏ_.]| ?[=:]| ?[-+]?[0-9])"
)
"""An axis as a word of its own, with no coordinate behind it."""


def _is_of_an_axis(row: Row, stated: Sequence[KeyValue], axes: Container[str]) -> bool:
    """Say whether a sentence names one of the axes, in words of which something is not known."""
    cells = [row.text] if " ".join(map(clean, row.cells)) == clean(row.text) else row.cells
    texts = [one.value for one in stated if not _AN_AXIS.search(one.written)] if stated else cells
    return any(_names_one_of(axes, text.strip("# ")) for text in texts)


def _names_one_of(axes: Container[str], text: str) -> bool:
    words = len(text.split()) if text.isascii() or " " in text else len(text) // 2
    if words < _SENTENCE or is_of_another(text) or _IN_CAPITALS.match(text):
        return False
    named = any(one[1] in axes for one in _AN_AXIS.finditer(text))
    return named and bool(unknown_words(text))


def _is_open(stated: KeyValue, rows: int) -> bool:
    """Say whether a statement of no known key may be of cycles, a factor, or a part of a unit."""
    key, value = stated.written, stated.value
    named = (*WORDS["remark"]["free"], *WORDS["remark"]["numbered"], *WORDS["head"])
    if stated.key in named:
        return False
    if topic_of(key) or is_of_another(key) or names_a_limit(stated.key) or numbers_a_thing(key):
        return False
    number = parse_cell(value)
    if number is None:
        in_words = len(value.split()) >= _SENTENCE or not value.isascii()
        return in_words and holds_an_open_number(value, rows)
    if number.unit:
        return holds_an_open_number(value, rows) and not OTHER_SIZE.search(key)
    return _FACTORS[0] <= number.value <= _FACTORS[1] and (count_decimals(value) or 0) > 1


def _rare_mark(remarks: npt.NDArray[np.str_]) -> str:
    """Return the word by which a few rows differ from all others; empty where there is none."""
    marks, counts = np.unique(remarks, return_counts=True)
    if len(marks) != TWO or counts.min() > RARE * counts.sum():
        return ""
    words = all(map(str.isalnum, marks)) and not any(map(strikes_its_row, marks))
    return str(marks[counts.argmin()]) if words else ""
