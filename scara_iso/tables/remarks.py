"""What remarks and lines of words say of readings, and which of them may change a figure."""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from scara_iso.run import FloatArray, Run, common_step
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import LEAVE_OUT, LEAVE_ROWS_OUT, REMARK, Faults, quoted
from scara_iso.tables.grid import Row, is_comment
from scara_iso.tables.layout import ONE_COLUMN, names_an_axis
from scara_iso.tables.names import Column, Kind, is_axis, names_some
from scara_iso.tables.numbers import count_decimals, parse_cell
from scara_iso.tables.scales import length_in_mm
from scara_iso.tables.sentences import OF_CYCLES, speaks_of_cycles, speaks_of_size, strikes_its_row
from scara_iso.tables.statements import (
    OTHER_SIZE,
    RECORDER,
    KeyValue,
    is_of_axes,
    is_plain,
    read_statements,
)
from scara_iso.tables.words import (
    LONGEST_LINE,
    WORDS,
    affirms,
    any_of,
    clean,
    is_free_key,
    is_of_another,
    plain_heading,
    subject_of_heading,
    unknown_words,
)

_SENTENCE = 3
"""Words of a value that may say something of the readings."""
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
        of_what_counts = affirms(plain_heading(clean(column.heading)))  # an x under OK
        if of_what_counts or (len(last) == 1 and not discarded):  # of every row it strikes none
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


Readings = Mapping[str, FloatArray]


def rows_in_words(
    readings: Readings, faults: Faults, lines: Iterable[Row], run: Run | None = None
) -> list[str]:
    """Return what lines of words, wherever they stand, say of some of the rows or of all."""
    poses = [str(label) for label, _ in run.rows_by_pose()] if run else []
    between = range(*run.lines[[0, -1]].tolist()) if run and run.lines is not None else range(0)
    rows, found = max(map(len, readings.values()), default=0), []
    for row in lines:
        stated = read_statements(row)
        keys = [one.key for one in stated]
        own = any(k in WORDS["remark"]["own"] or k.startswith(RECORDER) for k in keys)
        if own or any(map(is_of_axes, keys)) or any(map(is_plain, stated)):
            continue
        matters = speaks_of_cycles(row.text, rows) or speaks_of_size(row.text)
        matters = matters or holds_an_open_ratio(row.text) or _is_of_an_axis(row, stated, readings)
        matters = matters or _is_of_some(row, stated, poses, between)
        numbers = filter(None, map(parse_cell, row.cells))
        if not is_comment(row.text) and not any(one.unit.isascii() for one in numbers):
            matters = matters or (not keys and _holds_an_open_number(row.text, readings))
            matters = matters or any(_is_open(one, readings) for one in stated)
        if matters:
            found.append(f"{faults.place(row.line)} {quoted(row.text.strip('# '), REMARK)}")
    return found


_AN_AXIS = re.compile(r"(?<![.-])([XYZ]|theta)(?!\.| ?[=:]| ?[-+]?\d)")


def _axes_in_words(text: str) -> set[str]:
    """Return each axis that is a word of its own, with no coordinate behind it."""
    found = ((one[1], one.span()) for one in _AN_AXIS.finditer(text))
    return {
        axis
        for axis, (start, end) in found
        if not any(map(_parts_words, (text[start - 1 : start], text[end : end + 1])))
    }


def _parts_words(letter: str) -> bool:
    """Say whether a letter is of a script that parts words by blanks."""
    return re.match(r"\w", letter) is not None and not "\u2e80" <= letter <= "\uffff"


def _is_of_an_axis(row: Row, stated: Sequence[KeyValue], axes: Container[str]) -> bool:
    """Say whether a sentence names one of the axes, in words of which something is not known."""
    cells = [row.text] if " ".join(map(clean, row.cells)) == clean(row.text) else row.cells
    if not stated:
        return any(_names_one_of(axes, text) for text in cells)
    named = (one for one in stated if _names_one_of(axes, one.value))
    return any(is_free_key(k.written, k.key) and not _axes_in_words(k.written) for k in named)


def _names_one_of(axes: Container[str], text: str) -> bool:
    words = len(text.strip("# ").split()) if " " in text else len(text) // 2
    named = words >= _SENTENCE and any(axis in axes for axis in _axes_in_words(text))
    return named and bool(unknown_words(text)) and not is_of_another(text)


def _is_of_some(
    row: Row, stated: Sequence[KeyValue], poses: Sequence[str], between: Container[int]
) -> bool:
    """Say whether two words or more stand between readings, or a line names some of the poses."""
    text = clean(row.text[:LONGEST_LINE])
    if row.line in between and len(re.findall(r"[^\W\d_]{2,}", _unexplained(text))) > 1:
        return not names_an_axis(row.cells)
    free = (one for one in stated if is_free_key(one.written, one.key.partition("[")[0]))
    texts = [f"{one.key} {one.value}" for one in free] if stated else [text]
    return any(names_some(text[:LONGEST_LINE], poses) for text in texts)


def _is_open(stated: KeyValue, readings: Readings) -> bool:
    """Say whether a statement of no known key may be of cycles, a factor, a part of a unit."""
    key, value = stated.written, stated.value
    number = parse_cell(value)
    in_words = len(value.split()) >= _SENTENCE or not value.isascii()
    if number is None and not (in_words and re.search("[0-9]", value)):
        return False
    if not is_free_key(key, stated.key) or re.search(OTHER_SIZE, key):
        return False
    corrects = subject_of_heading(key) is not None or not _is_step_of(readings, value)
    if number and corrects and _may_correct(value, readings):
        return True
    if number is None or number.unit:
        return _holds_an_open_number(value, readings)
    return _FACTORS[0] <= number.value <= _FACTORS[1] and (count_decimals(value) or 0) > 1


def _may_correct(value: str, readings: Readings) -> bool:
    """Say whether a number is smaller than the spread of readings, or has a sign and is below 1."""
    size = length_in_mm(value) or length_in_mm(f"{value} mm" if count_decimals(value) else "")
    most = 1.0 if value[:1] in ("+", "-", "−") else max(map(np.ptp, readings.values()), default=0)
    return size is not None and 0 < abs(size) < most


def _is_step_of(readings: Readings, text: str) -> bool:
    """Say whether a text is a length, and the step on which the readings of an axis lie."""
    size = length_in_mm(text) or 0.0
    return any(math.isclose(size, common_step(one), rel_tol=0.02) for one in readings.values())


def _rare_mark(remarks: npt.NDArray[np.str_]) -> str:
    """Return the word by which a few rows differ from all others; empty where there is none."""
    marks, counts = np.unique(remarks, return_counts=True)
    if len(marks) != TWO or counts.min() > RARE * counts.sum():
        return ""
    words = all(map(str.isalnum, marks)) and not any(map(strikes_its_row, marks))
    return str(marks[counts.argmin()]) if words else ""


_MONTH = rf"(?:{'|'.join(map(re.escape, WORDS['remark']['month']))})[a-zäéû]*"
_NUMBERED_THING = any_of(WORDS["remark"]["numbered"])
_EXPLAINED = (
    r"\b(?:iso|din|en|vdi|jis|gb|nist)\b[ :/-]*[a-z/]*[ -]*[0-9][a-z0-9:./-]*"
    r"(?:,? [^\W\d]+\.? ?[1-9][0-9]?(?:\.[1-9][0-9]?)+(?![.,]?[0-9]))?"
    r"|[0-9]+(?:[-/:][0-9]{1,9}){1,4}|[0-9]+(?:\.[0-9]{1,9}){2,4}"
    r"|[0-9]+(?: / | [a-z]{1,3} )[0-9]+"
    r"|第 ?[0-9]+ ?[号號]|[0-9]{1,4}[年月] ?[0-9]{1,2}(?:月 ?[0-9]{1,2})?日?|\b(?:19|20)[0-9]{2}\b"
    rf"|\b{_MONTH}[. ]+[0-9]{{1,2}}\b|[0-9]{{1,2}}[. ]+{_MONTH}"
    r"|[a-z#][a-z_/.#-]*[0-9][a-z0-9./-]*|[0-9][0-9./]*-[a-z0-9./-]+"
    rf"|{_NUMBERED_THING}[ .:_-]*(?:[a-z]{{1,3}} )?[0-9][a-z0-9.,/-]*(?: [a-z]{{1,3}} [0-9]+)?"
    r"|(?<![a-z0-9.,])[-+]?[0-9]+(?:[.,][0-9]+)? ?"
    rf"(?:[%°℃'\"]|{any_of(WORDS['remark']['unit'])}(?![^\W_]))"
    rf"|[0-9]+ {any_of(WORDS['remark']['places'])}"
)
"""A standard and its clause, date, time, page, name or size, the number of a sheet or machine."""
_LABEL = r"(?:[^\W\d_]+\W+){0,2}[0-9]+\W*"
"""A name with its number, and nothing behind: ``After service 2``."""
_OPEN = r"(?<![\d.,])([0-9]+(?:[.,][0-9]+)?)(?![\d])"
_PART_OF_A_LENGTH = r"(?i)(?<![\d.,/])(?:1/10+|0[.,]0*1) ?(?:mm|millim|inch|zoll)"
_LENGTH = r"(?<![\w.,/])[0-9]+[.,][0-9]+ ?[^\W\d_]+(?!\w)"
_RATIO = (
    r"(?<![\w.,:/=-])(?![0-9]{1,2}:[0-5][0-9](?!\d)|1 ?: ?1(?![\d.,]))"
    r"[0-9]{1,2}(?:[.,][0-9]+)? ?: ?[0-9]{1,2}(?:[.,][0-9]+)?(?![\w:]|[.,]\d)"
)


def _unexplained(text: str) -> str:
    return re.sub(_EXPLAINED, " ", text, flags=re.IGNORECASE)


def holds_an_open_ratio(text: str) -> bool:
    """Say whether words hold a ratio such as 2:1 that is no time, drawing's or gear's."""
    return re.search(_RATIO, clean(text[:LONGEST_LINE])) is not None and not is_of_another(text)


def _holds_an_open_number(text: str, readings: Readings) -> bool:
    """Say whether words hold a number that nothing explains: a cycle, or a factor; no step."""
    low = clean(text[:LONGEST_LINE]).strip("# ")
    low = re.sub(_LENGTH, lambda one: " " if _is_step_of(readings, one[0]) else one[0], low)
    if re.search(_PART_OF_A_LENGTH, low):
        return True
    if re.search(rf"\b{OF_CYCLES}\b", low.lower()):  # `speaks_of_cycles` knows these words
        return False
    parts = re.split(r"[;()]|,(?!\d)", _unexplained(low))
    open_ones = (part for part in parts if not re.fullmatch(_LABEL, part.strip()))
    found = [one.replace(",", ".") for part in open_ones for one in re.findall(_OPEN, part)]
    rows = max(map(len, readings.values()), default=0)
    return any("." in number or 1 < int(number) < rows for number in found)
