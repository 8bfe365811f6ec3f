"""Other shapes of a table: poses below or beside each other, axes named by rows, logs.

Poses may be named by titles or by headings. The lines of a log name their numbers:
``probe at 97,2 is z=1.320``, ``x: 0.112 y: 0.811``. A machine that tests its own probe names itself
in its log.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from scara_iso.tables.grid import (
    Cell,
    CellGrid,
    Faults,
    Line,
    Row,
    head_of,
    is_filled,
    refuse,
    stripped,
    text_row,
)
from scara_iso.tables.layout import find_layout, find_worded
from scara_iso.tables.statements import read_statements
from scara_iso.tables.vocabulary.names import (
    Column,
    Kind,
    is_axis,
    names_an_axis,
    names_and_units,
    pose_alone,
    pose_and_name,
    read_name,
    read_names,
)
from scara_iso.tables.vocabulary.words import MINUS, clean, parse_cell, quoted

BESIDE = 300
"""Poses that may stand side by side: each is read for itself, with the columns of all."""
Block = tuple[str, CellGrid, str]
"""A pose, its grid, and what says whose pose it is.

The grid has the rows above all, and its own with other poses' cells empty: so lines and columns of
a fault are those of the file.
"""
_Poses = Sequence[tuple[int, str]]
"""The names of a row of poses, each with its column."""


def find_blocks(grid: CellGrid) -> list[Block]:
    """Return the blocks of a grid of several poses; none for another.

    Raises `DataError` for more than `BESIDE` side by side.
    """
    head = [(row.line, row.cells) for row in grid.head]
    if next(_titles(head), None):
        return _under_titles(grid, grid.rows())
    found = find_headings(grid.head)
    return _of_headings(grid, *found) if found else []


def _under_titles(grid: CellGrid, rows: Sequence[Line]) -> list[Block]:
    """Return a block for each pose's name above a header; none for fewer than two."""
    titles = list(_titles(rows))
    if sum(len(poses) for _, poses in titles) < 2:
        return []
    for at, poses in titles:
        _check_beside(len(poses), rows[at][0], grid.where)
    above = list(rows[: titles[0][0]])
    ends = [*(at for at, _ in titles[1:]), len(rows)]
    return [
        _block(pose, grid, [*above, *_columns(rows[at + 1 : end], poses, k)])
        for (at, poses), end in zip(titles, ends, strict=True)
        for k, (_, pose) in enumerate(poses)
    ]


def _block(pose: str, grid: CellGrid, rows: list[Line], place: str = "the name above it") -> Block:
    called = f"{grid.where}, block of {pose}"
    return pose, grid._replace(where=called, lines=rows, head=head_of(rows)), place


def _check_beside(poses: int, line: int, where: str) -> None:
    if poses > BESIDE:
        what = f"row {line} heads {poses} poses side by side, more than {BESIDE}"
        remedy = "put the rows of the poses below each other, with a column 'pose'"
        raise refuse(where, what, remedy=remedy)


def _titles(rows: Sequence[Line]) -> Iterator[tuple[int, _Poses]]:
    """Yield place and names of each row of names that a header follows, if the first has one."""
    waiting: tuple[int, _Poses] | None = None
    found = False
    for k, (_, cells) in enumerate(rows):
        texts = [cell if isinstance(cell, str) else repr(cell) for cell in cells]
        if poses := _poses(texts):
            waiting = k, poses
        elif names_an_axis(texts):
            if waiting is None and not found:
                return
            if waiting is not None:
                yield waiting
                found = True
            waiting = None
        elif sum(parse_cell(text) is not None for text in texts) > 1:
            waiting = None


def _poses(texts: Sequence[str]) -> _Poses:
    filled = [(k, text) for k, text in enumerate(texts) if is_filled(text)]
    stated = read_statements(Row(0, list(texts), "", 0)) if len(filled) == 2 else []
    if stated and stated[0].key == "pose":
        return [(filled[0][0], stated[0].value)]
    named = [(k, pose_alone(text)) for k, text in filled]
    return [(k, pose) for k, pose in named if pose] if all(p for _, p in named) else []


def _columns(rows: Sequence[Line], poses: _Poses, k: int) -> Iterator[Line]:
    """Yield the rows with the columns of the k-th pose, and those before the first one's."""
    if len(poses) == 1:
        yield from rows
        return
    shared, start = poses[0][0], poses[k][0]
    end = poses[k + 1][0] if k + 1 < len(poses) else None
    for line, cells in rows:
        kept = range(start, len(cells) if end is None else end)
        yield line, [cell if j < shared or j in kept else "" for j, cell in enumerate(cells)]


def find_headings(head: Sequence[Row]) -> tuple[int, Mapping[int, tuple[str, str]]] | None:
    """Return the first row that heads the axes of two poses or more, as ``P1 X [mm]``, ``X P2``.

    That is its line, and pose and name of each such cell by its column. There is none where a row
    names an axis of no pose: that is the header.
    """
    for row in head:
        named = {j: found for j, cell in enumerate(row.cells) if (found := pose_and_name(cell))}
        if len({p for p, name in named.values() if is_axis(name)}) > 1:
            return None if any(names_an_axis(one.cells) for one in head) else (row.line, named)
    return None


def _of_headings(grid: CellGrid, line: int, named: Mapping[int, tuple[str, str]]) -> list[Block]:
    rows, at = grid.rows(), line - 1
    poses = dict.fromkeys(pose for pose, _ in named.values())
    _check_beside(len(poses), line, grid.where)
    place = "the heading of its columns"
    return [_block(p, grid, [*rows[:at], *_of(p, rows[at:], named)], place) for p in poses]


def _of(pose: str, rows: Sequence[Line], named: Mapping[int, tuple[str, str]]) -> Iterator[Line]:
    """Yield the header and the rows below it with the columns of one pose."""
    others = {j for j, (of, _) in named.items() if of != pose}
    for k, (line, cells) in enumerate(rows):
        kept = ["" if j in others else cell for j, cell in enumerate(cells)]
        if k == 0:
            kept = [named[j][1] if j in named and cell else cell for j, cell in enumerate(kept)]
        yield line, kept


def find_axes(grid: CellGrid) -> list[CellGrid]:
    """Return a grid for each axis where a column names that of each row: it heads the readings."""
    named = (k for k, row in enumerate(grid.head) if any(map(is_axis, row.cells)))
    first = next((k for k in named if _hold_a_number(grid.head[k].cells)), 0)
    head = next((row for row in reversed(grid.head[:first]) if row.text), None)
    if head is None:
        return []
    at = [*map(is_axis, grid.head[first].cells)].index(True)
    below = [row for row in grid.rows() if row[0] > head.line]
    readings = _column_of_readings(head, at, [cells for _, cells in below if _hold_a_number(cells)])
    if readings is None:
        return []
    grids = list(_by_axis(grid, head, at, readings, below))
    return grids if find_layout(grids[0].head) or find_worded(grids[0].head) else []


def _column_of_readings(head: Row, at: int, rows: Sequence[Sequence[Cell]]) -> Column | None:
    """Return the one column of numbers besides cycle and conditions, where each row has an axis."""
    columns = read_names(head.cells)
    free = [c for c in columns if c.kind is Kind.COVARIATE and not c.condition and c.position != at]
    found = [
        c for c in free if 2 * sum(_hold_a_number(r[c.position :][:1]) for r in rows) > len(rows)
    ]
    counted = any(column.kind is Kind.CYCLE for column in columns)
    of_axes = all(len(cells) > at and is_axis(str(cells[at])) for cells in rows)
    return found[0] if len(found) == 1 and counted and of_axes else None


def _by_axis(
    grid: CellGrid, head: Row, at: int, readings: Column, below: Sequence[Line]
) -> Iterator[CellGrid]:
    """Yield the rows of each axis, whose name goes from its column into the heading."""
    *_, (name, unit) = names_and_units(clean(readings.heading))
    above: list[Line] = [(row.line, row.cells) for row in grid.head if row.line < head.line]
    rows = {line: cells for line, cells in below if _hold_a_number(cells)}
    others = [row for row in below if row[0] not in rows]
    for cell in dict.fromkeys(str(cells[at]) for cells in rows.values()):
        axis, names = read_name(cell), [*head.cells]
        called = "".join(f" [{one}]" for one in (axis.unit, unit) if one)
        names[at], names[readings.position] = "", f"{name} {axis.name}{called}"
        own = [(n, [*r[:at], "", *r[at + 1 :]]) for n, r in rows.items() if r[at] == cell]
        lines = [*above, (head.line, names), *own, *others]
        yield grid._replace(lines=lines, head=head_of(lines))


def _hold_a_number(cells: Sequence[Cell]) -> bool:
    return any(isinstance(cell, float) or parse_cell(cell) for cell in cells)


_WHEN = (
    r"[0-9]{1,4}[-./][0-9]{1,2}[-./][0-9]{1,4}|[0-9]{1,2}:[0-9]{2}(?::[0-9]{2}(?:[.,][0-9]{1,9})?)?"
)
_NUMBER = r"[+-]?[0-9]{1,20}(?:[.,][0-9]{1,20})?"
_PAIR = (
    r"(?<!\w)([^\W\d_]{1,12}) ?[:=] {0,4}"
    r"([^\s;)\]:=]{1,40}(?: (?:mm|[uµμ]m|inch|deg)(?!\w))?)(?=[\s;)\],]|$)"
)
_COUNTED = r"(?<!\w)([^\W\d_]{1,12}) {1,4}([0-9]{1,9})(?![\w.,])"
_BEGINS = rf"\d|[-+.,{MINUS}]"
_WORD = r"[^\W\d_]+"
_LOOSE = " \t,;:=()[]/@#+-"
_COUNTS = (Kind.CYCLE, Kind.POSE)
_LONGEST = 1000
_EPOCH = 1e8
"""Seconds since 1970, and finer counts of them, are above this."""
_SHOWN = 20
_MM = "mm"
"""Unit of every length in the log of a machine."""
_REMEDY = "leave the lines of one test in the file, one line for each reading"
Log = tuple[list[Row], list[Line], str | None, list[str]]
"""The lines above the readings and a header of their names; the readings; unit; and notes.

The header stands at the line of the first reading, and ends in front of it; the notes say what is
below it and not used.
"""


class _Reading(NamedTuple):
    """A line: its text with # for numbers, the names and numbers of it, the numbers without one."""

    line: int
    shape: str
    names: tuple[str, ...]
    numbers: tuple[str, ...]
    others: tuple[str, ...]


def find_log(lines: Sequence[str], where: str) -> Log | None:
    """Return the readings of a log, None where fewer than two lines alike name an axis.

    Raises `DataError` for a log of two kinds of readings, of several places, or of two tests.
    """
    found = [one for k, text in enumerate(lines, 1) if (one := _read(k, text)) is not None]
    shapes: dict[str, list[_Reading]] = {}
    for one in found:
        shapes.setdefault(one.shape, []).append(one)
    several = [group for group in shapes.values() if len(group) > 1]
    if not several:
        return None
    rows, *more = several
    faults = Faults(where)
    for other in more:
        text = quoted(lines[other[0].line - 1])
        faults.add(f"{text} names an axis too", other[0].line, remedy=_REMEDY)
    words = {*re.findall(_WORD, rows[0].shape)}
    for one in found:
        if one.shape != rows[0].shape and words.issuperset(re.findall(_WORD, one.shape)):
            faults.add("names an axis, and is not as the other lines", one.line, remedy=_REMEDY)
    _check_between(rows, lines, faults)
    _check_others(rows, faults)
    faults.check()
    return _log(rows, lines)


def _log(rows: Sequence[_Reading], lines: Sequence[str]) -> Log:
    first, notes, own = rows[0].line, list[str](), 0
    head = [text_row(k, [text]) for k, text in enumerate(lines[: first - 1], 1)]
    named = [k for k, (itself, _) in _MACHINES.items() if any(re.search(itself, x) for x in lines)]
    machine = named[0] if len(named) == 1 else None
    if machine:
        itself, deviation = _MACHINES[machine]
        head = [one for one in head if not re.search(itself, lines[one.line - 1])]
        notes.append(f"a log of {machine}: lengths in {_MM}")
        found = ((re.search(deviation, line), k) for k, line in enumerate(lines, 1))
        stated, own = next((one for one in found if one[0]), (None, 0))
        if stated:
            notes.append(
                f"line {own}: its standard deviation {stated[1]} {_MM} divides by n, not by "
                "n - 1, and is not taken"
            )
    used = {own, *(one.line for one in rows)}
    left = (k for k in range(first, len(lines) + 1) if k not in used and lines[k - 1].strip())
    notes += [f"line {k}: {quoted(lines[k - 1])} not used" for k in left][:_SHOWN]
    head.append(text_row(first, rows[0].names)._replace(end=first - 1))
    readings: list[Line] = [(one.line, list(one.numbers)) for one in rows]
    return head, readings, _MM if machine else None, notes


def _read(line: int, text: str) -> _Reading | None:
    if len(text) > _LONGEST or not ("=" in text or ":" in text):
        return None
    text = re.sub(_WHEN, "@", stripped(text))
    if not any(_kind(pair[1]) is Kind.AXIS for pair in re.finditer(_PAIR, text)):
        return None
    pairs: list[tuple[str, str]] = []

    def take(match: re.Match[str]) -> str:
        kind = _kind(match[1])
        counted = match.re.pattern == _COUNTED
        if (
            kind not in _COUNTS
            if counted
            else kind is not Kind.AXIS and not re.match(_BEGINS, match[2])
        ):
            return match[0]
        pairs.append((match[1], match[2].rstrip(",")))
        return f"{match[1]}= "

    rest = re.sub(_COUNTED, take, re.sub(_PAIR, take, text))
    names, numbers = zip(*pairs, strict=True)
    others = tuple(
        rest[max(0, m.start() - 1) : m.start()].strip(_LOOSE) + m[0]
        for m in re.finditer(_NUMBER, rest)
    )
    shape = "".join(re.sub(_NUMBER, "0", rest).split())
    return _Reading(line, shape, names, numbers, others)


@lru_cache(maxsize=1024)
def _kind(name: str) -> Kind:
    return read_name(name).kind


def _check_between(rows: Sequence[_Reading], lines: Sequence[str], faults: Faults) -> None:
    """Refuse numbers between the readings: another test may begin there."""
    for one, following in pairwise(rows):
        between = range(one.line, following.line - 1)
        for k in [k for k in between if re.search(_NUMBER, re.sub(_WHEN, "@", lines[k]))][:1]:
            what = f"{quoted(lines[k])} between readings: does another test begin?"
            faults.add(what, k + 1, remedy=_REMEDY)


def _check_others(rows: Sequence[_Reading], faults: Faults) -> None:
    """Refuse numbers without a name that change as no count and no clock does: places, poses."""
    for texts in zip(*(one.others for one in rows), strict=True):
        whole = all(text.isdecimal() for text in texts)
        counts = whole and all(int(b) == int(a) + 1 for a, b in pairwise(texts))
        clock = all(x[0].isdecimal() and float(x.replace(",", ".")) > _EPOCH for x in texts)
        if len(set(texts)) == 1 or counts or clock:
            continue
        k = next(k for k, text in enumerate(texts) if text != texts[0])
        what = f"{texts[k]} where line {rows[0].line} has {texts[0]}: another place or pose?"
        faults.add(what, rows[k].line, remedy="leave the lines of one place in the file")


# Klipper's docs/G-Codes.md, [probe]; Marlin's gcode/calibrate/M48. Both divide by n.
_MACHINES = {
    "Klipper PROBE_ACCURACY": (
        r"PROBE_ACCURACY at X:[-0-9.]+ Y:[-0-9.]+ Z:[-0-9.]+",
        r"probe accuracy results:.*standard deviation ([0-9.]{1,20})\s*$",
    ),
    "Marlin M48": (
        r"M48 Z-Probe Repeatability Test",
        r"Standard Deviation: ([0-9.]{1,20})\s*$",
    ),
}
"""How a machine names itself, and how it states its standard deviation."""
