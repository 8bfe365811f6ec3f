"""Tables of several poses on one sheet: below or beside each other, each under its pose's name.

Tables whose headings name a pose and an axis in one cell: ``P1 X [mm]``, ``X P2``.

Logs whose lines name their numbers: ``probe at 97,2 is z=1.320``, ``x: 0.112 y: 0.811``.

Columns that are named by nothing but their position: `columns=` for a header.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

from scara_iso.base.errors import UsageError
from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import Faults, quoted, refuse
from scara_iso.tables.layout import COLUMNS, HEAD, Layout, header_cells, names_an_axis, runs_across
from scara_iso.tables.names import (
    LONGEST_NAME,
    Column,
    Kind,
    clean,
    pose_alone,
    pose_and_name,
    read_name,
    read_names,
    read_unit,
    settle,
)
from scara_iso.tables.numbers import BLANKS, MINUS, parse_cell
from scara_iso.tables.preamble import read_statement
from scara_iso.tables.text import Row

Line = tuple[int, Sequence[Cell]]
"""A row's number and its cells."""
BESIDE = 300
"""Poses that may stand side by side: each is read for itself, with the columns of all."""


@dataclass(frozen=True, slots=True)
class Block:
    """The rows of one pose: those above all blocks, and its own with other blocks' cells empty.

    So lines and columns of a fault are those of the file.
    """

    pose: str
    rows: list[Line]
    place: str = "the name above it"
    """What says whose pose it is."""


@dataclass(frozen=True, slots=True)
class _Titles:
    """A row of poses' names: its place among the rows, and each name with its column."""

    at: int
    poses: tuple[tuple[int, str], ...]


def has_blocks(rows: Sequence[Row]) -> bool:
    """Say whether a pose's name stands above the first header among the rows of a file's head."""
    return next(_titles([(row.line, row.cells) for row in rows]), None) is not None


def find_blocks(rows: Sequence[Line], where: str) -> list[Block]:
    """Return the blocks of a sheet; none where fewer than two poses stand above a header.

    Raises `DataError` for more than `BESIDE` side by side.
    """
    titles = list(_titles(rows))
    if sum(len(one.poses) for one in titles) < 2:
        return []
    for one in titles:
        check_beside(len(one.poses), rows[one.at][0], where)
    above = list(rows[: titles[0].at])
    ends = [*(one.at for one in titles[1:]), len(rows)]
    return [
        Block(pose, [*above, *_columns(rows[one.at + 1 : end], one.poses, k)])
        for one, end in zip(titles, ends, strict=True)
        for k, (_, pose) in enumerate(one.poses)
    ]


def check_beside(poses: int, line: int, where: str) -> None:
    """Raise `DataError` where a row heads more poses than may stand side by side."""
    if poses > BESIDE:
        what = f"row {line} heads {poses} poses side by side, more than {BESIDE}"
        remedy = "put the rows of the poses below each other, with a column 'pose'"
        raise refuse(where, what, remedy=remedy)


def _titles(rows: Sequence[Line]) -> Iterator[_Titles]:
    """Yield the rows of names that a header follows, if the first header has one."""
    waiting: _Titles | None = None
    found = False
    for k, (_, cells) in enumerate(rows):
        texts = [cell if isinstance(cell, str) else repr(cell) for cell in cells]
        if poses := _poses(texts):
            waiting = _Titles(k, poses)
        elif names_an_axis(texts):
            if waiting is None and not found:
                return
            if waiting is not None:
                yield waiting
                found = True
            waiting = None
        elif sum(parse_cell(text) is not None for text in texts) > 1:
            waiting = None


def _poses(texts: Sequence[str]) -> tuple[tuple[int, str], ...]:
    filled = [(k, text) for k, text in enumerate(texts) if text.strip(BLANKS)]
    stated = read_statement(Row(0, list(texts), "", 0)) if len(filled) == 2 else None
    if stated and stated.key == "pose":
        return ((filled[0][0], stated.value),)
    named = [(k, pose_alone(text)) for k, text in filled]
    return tuple((k, pose) for k, pose in named if pose) if all(p for _, p in named) else ()


def _columns(rows: Sequence[Line], poses: Sequence[tuple[int, str]], k: int) -> Iterator[Line]:
    """Yield the rows with the columns of the k-th pose, and those before the first one's."""
    if len(poses) == 1:
        yield from rows
        return
    shared, start = poses[0][0], poses[k][0]
    end = poses[k + 1][0] if k + 1 < len(poses) else None
    for line, cells in rows:
        mine = slice(start, len(cells) if end is None else end)
        kept = range(len(cells))[mine]
        yield line, [cell if j < shared or j in kept else "" for j, cell in enumerate(cells)]


def find_wide(rows: Sequence[Line], where: str) -> list[Block]:
    """Return a block for each pose of the first row that heads the axes of two poses or more.

    Other poses' cells are empty there, so lines and columns of a fault are those of the file. There
    is none where a row names an axis of no pose: that is the header. Raises `DataError` for more
    than `BESIDE`.
    """
    head = [
        [cell if isinstance(cell, str) else repr(cell) for cell in cells]
        for _, cells in rows[:HEAD]
    ]
    if any(map(names_an_axis, head)):
        return []
    for k, texts in enumerate(head):
        named = {j: found for j, text in enumerate(texts) if (found := pose_and_name(text))}
        axes = {pose for pose, name in named.values() if read_name(name).kind is Kind.AXIS}
        if len(axes) > 1:
            poses = dict.fromkeys(pose for pose, _ in named.values())
            check_beside(len(poses), rows[k][0], where)
            return [
                Block(pose, [*rows[:k], *_of(pose, rows[k:], named)], "the heading of its columns")
                for pose in poses
            ]
    return []


def _of(pose: str, rows: Sequence[Line], named: Mapping[int, tuple[str, str]]) -> Iterator[Line]:
    """Yield the header and the rows below it with the columns of one pose."""
    others = {j for j, (of, _) in named.items() if of != pose}
    for k, (line, cells) in enumerate(rows):
        kept = ["" if j in others else cell for j, cell in enumerate(cells)]
        if k == 0:
            kept = [named[j][1] if j in named and cell else cell for j, cell in enumerate(kept)]
        yield line, kept


_WHEN = re.compile(
    r"[0-9]{1,4}[-./][0-9]{1,2}[-./][0-9]{1,4}|[0-9]{1,2}:[0-9]{2}(?::[0-9]{2}(?:[.,][0-9]{1,9})?)?"
)
_NUMBER = re.compile(r"[+-]?[0-9]{1,20}(?:[.,][0-9]{1,20})?")
_PAIR = re.compile(r"(?<!\w)([^\W\d_]{1,12}) ?[:=] {0,4}([^\s;)\]:=]{1,40})(?=[\s;)\],]|$)")
_COUNTED = re.compile(r"(?<!\w)([^\W\d_]{1,12}) {1,4}([0-9]{1,9})(?![\w.,])")
_WORD = re.compile(r"[^\W\d_]+")
_LOOSE = " \t,;:=()[]/@#+-"
_COUNTS = (Kind.CYCLE, Kind.POSE)
_LONGEST = 1000
_EPOCH = 1e8
"""Seconds since 1970, and finer counts of them, are above this."""
_REMEDY = "leave the lines of one test in the file, one line for each reading"


@dataclass(frozen=True, slots=True)
class _Reading:
    """A line: its text with # for numbers, the names and numbers of it, the numbers without one."""

    line: int
    shape: str
    names: tuple[str, ...]
    numbers: tuple[str, ...]
    others: tuple[str, ...]


def find_labelled(lines: Sequence[str], where: str) -> list[Line]:
    """Return a header and the rows of a log, none where fewer than two lines alike name an axis.

    Raises `DataError` for a log of two kinds of readings, of several places, or of two tests.
    """
    found = [one for k, text in enumerate(lines, 1) if (one := _read(k, text)) is not None]
    shapes: dict[str, list[_Reading]] = {}
    for one in found:
        shapes.setdefault(one.shape, []).append(one)
    several = [group for group in shapes.values() if len(group) > 1]
    if not several:
        return []
    rows, *more = several
    faults = Faults(where)
    for other in more:
        text = quoted(lines[other[0].line - 1])
        faults.add(f"{text} names an axis too", other[0].line, remedy=_REMEDY)
    _check_alike(rows, found, faults)
    _check_between(rows, lines, faults)
    _check_others(rows, faults)
    faults.check()
    above = [(k, [text]) for k, text in enumerate(lines[: rows[0].line - 1], 1)]
    table = [(one.line, list(one.numbers)) for one in rows]
    return [*above, (rows[0].line - 1, list(rows[0].names)), *table]


def _read(line: int, text: str) -> _Reading | None:
    if len(text) > _LONGEST or not ("=" in text or ":" in text):
        return None
    text = _WHEN.sub("@", text.strip(BLANKS))
    if not any(_kind(pair[1]) is Kind.AXIS for pair in _PAIR.finditer(text)):
        return None
    pairs: list[tuple[str, str]] = []

    def take(match: re.Match[str]) -> str:
        kind = _kind(match[1])
        counted = match.re is _COUNTED
        if kind not in _COUNTS if counted else kind is not Kind.AXIS and not _begins(match[2]):
            return match[0]
        pairs.append((match[1], match[2].rstrip(",")))
        return f"{match[1]}= "

    rest = _COUNTED.sub(take, _PAIR.sub(take, text))
    names, numbers = zip(*pairs, strict=True)
    others = tuple(
        rest[max(0, m.start() - 1) : m.start()].strip(_LOOSE) + m[0] for m in _NUMBER.finditer(rest)
    )
    shape = "".join(_NUMBER.sub("0", rest).split())
    return _Reading(line, shape, names, numbers, others)


@lru_cache(maxsize=1024)
def _kind(name: str) -> Kind:
    return read_name(name).kind


def _begins(value: str) -> bool:
    """Say whether a value begins as a number does."""
    return value[0].isdecimal() or value[0] in "+-.," or value[0] == MINUS


def _check_alike(rows: Sequence[_Reading], found: Sequence[_Reading], faults: Faults) -> None:
    """Refuse lines that name an axis, say no other words, and are not as the rows are."""
    words = {*_WORD.findall(rows[0].shape)}
    for one in found:
        if one.shape != rows[0].shape and words.issuperset(_WORD.findall(one.shape)):
            faults.add("names an axis, and is not as the other lines", one.line, remedy=_REMEDY)


def _check_between(rows: Sequence[_Reading], lines: Sequence[str], faults: Faults) -> None:
    """Refuse numbers between the readings: another test may begin there."""
    for one, following in pairwise(rows):
        for k in range(one.line, following.line - 1):
            if _NUMBER.search(_WHEN.sub("@", lines[k])):
                what = f"{quoted(lines[k])} between readings: does another test begin?"
                faults.add(what, k + 1, remedy=_REMEDY)
                break


def _check_others(rows: Sequence[_Reading], faults: Faults) -> None:
    """Refuse numbers without a name that change as no count and no clock does: places, poses."""
    for texts in zip(*(one.others for one in rows), strict=True):
        if len(set(texts)) == 1 or _is_count(texts) or all(map(_is_instant, texts)):
            continue
        k = next(k for k, text in enumerate(texts) if text != texts[0])
        what = f"{texts[k]} where line {rows[0].line} has {texts[0]}: another place or pose?"
        remedy = "leave the lines of one place in the file"
        faults.add(what, rows[k].line, remedy=remedy)


def _is_count(texts: Sequence[str]) -> bool:
    whole = all(text.isdecimal() for text in texts)
    return whole and all(int(after) == int(before) + 1 for before, after in pairwise(texts))


def _is_instant(text: str) -> bool:
    return text[:1].isdecimal() and float(text.replace(",", ".")) > _EPOCH


SKIPPED = "-"
ONE_A_ROW = (
    "write a row for each reading: pose,approach,cycle,X with the target as its pose; where the "
    "columns are of several poses, head them P1_X, P1_Y, P2_X"
)
_TARGET = re.compile(r"(?:targets?|ziel|soll|direction|richtung)\b.*|(?:ziel|soll)pos.*")
_BRACKETS = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]")
_MOST = 40
"""Fields that a suggestion names."""


def column_names(columns: str | Sequence[str]) -> tuple[str, ...]:
    """Return the names of ``X,Y,-`` or of a sequence; `UsageError` where none is an axis."""
    names = columns.split(",") if isinstance(columns, str) else columns
    found = tuple(name.strip() for name in names)
    if not names_an_axis(found) or not all(found) or len(found) > COLUMNS:
        raise UsageError(
            f"columns {quoted(','.join(found))} name no axis X, Y, Z or theta",
            remedy="name each field in turn, - for one to leave out: `columns=cycle,X,Y,-`",
        )
    return found


def place_columns(rows: Sequence[Row], names: Sequence[str]) -> Layout | None:
    """Return the layout that ``names`` give the first row of as many fields, numbers for axes."""
    columns = read_names(["note" if name == SKIPPED else name for name in names], [""] * len(names))
    fitting = [row for row in rows if _fits(row, columns)]
    for row in fitting:
        if not _is_like(row, fitting[-1]):
            continue  # LabVIEW's "Samples 5 5" above its columns
        above = [one for one in rows if one.line < row.line]
        found = (settle(c, names[c.position], row.cells[c.position]) for c in columns)
        settled = (_with_unit(column, above) for column in found)
        return Layout(tuple(settled), _header(names), row.line, row.line, sure=True)
    return None


def _is_like(row: Row, other: Row) -> bool:
    """Say whether no field holds a number in one row and words in the other."""
    kinds = (
        (parse_cell(a), parse_cell(b), a, b) for a, b in zip(row.cells, other.cells, strict=False)
    )
    return all((x is None) == (y is None) or not a.strip() or not b.strip() for x, y, a, b in kinds)


def _header(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"field {k}" if name == SKIPPED else name for k, name in enumerate(names, start=1))


def _fits(row: Row, columns: Sequence[Column]) -> bool:
    if len(row.cells) < len(columns) or any(cell.strip() for cell in row.cells[len(columns) :]):
        return False
    sized = (c for c in columns if c.kind in (Kind.AXIS, Kind.CYCLE))
    return all(parse_cell(row.cells[c.position]) is not None for c in sized)


def count_fitting(rows: Sequence[Row], names: Sequence[str]) -> int:
    """Return how many rows have the named fields, with numbers for the axes."""
    columns = read_names(list(names), [""] * len(names))
    return sum(_fits(row, columns) for row in rows)


def check_header(rows: Sequence[Row], layout: Layout, faults: Faults) -> None:
    """Refuse names that the file's own header gives to other fields, and rows that lack some."""
    for row in rows:
        filled = [cell for cell in row.cells if cell.strip()]
        if row.line < layout.header_line and filled and all(map(parse_cell, filled)):
            what = f"{len(filled)} numbers above the first row of {layout.width} fields"
            faults.add(what, row.line, remedy="complete the line, or remove it")
        if row.line >= layout.header_line:
            continue
        _check_units(row, layout, faults)
        if not names_an_axis(row.cells):
            continue
        own = read_names(header_cells(row.cells), [""] * len(header_cells(row.cells)))
        stated = {c.name: c.position for c in layout.of(Kind.AXIS)}
        for column in own:
            k = stated.get(column.name, column.position)
            if column.kind is Kind.AXIS and k != column.position:
                what = f"{column.name} by the header, and `columns=` says it is field {k + 1}"
                remedy = "leave `columns=` out, or remove the header"
                faults.add(what, row.line, column.position + 1, remedy=remedy)


def _unit_above(row: Row, column: Column) -> str:
    """Return the unit in brackets that a heading of the file gives the field, or nothing."""
    cell = row.cells[column.position] if column.position < len(row.cells) else ""
    found = _BRACKETS.search(cell) if len(cell) <= LONGEST_NAME else None
    return found[1].strip() if found and read_unit(found[1]) is not None else ""


def _with_unit(column: Column, above: Sequence[Row]) -> Column:
    """Return an axis with the unit of the file's own heading, where `columns=` states none."""
    stated = [unit for row in above if (unit := _unit_above(row, column))]
    lacks = column.kind is Kind.AXIS and not column.unit and stated
    return replace(column, unit=stated[-1]) if lacks else column


def _check_units(row: Row, layout: Layout, faults: Faults) -> None:
    """Refuse a unit in the file's own heading of an axis other than `columns=` states."""
    for column in layout.of(Kind.AXIS):
        unit = _unit_above(row, column)
        if unit and read_unit(unit) != read_unit(column.unit):
            what = f"{quoted(unit)} heads {column.name}, and `columns=` states {column.unit}"
            faults.add(what, row.line, column.position + 1, remedy="name the unit that is true")


_OFTEN = 3  # times that each pose comes again
_FEWEST_ACROSS = 12  # a row of a measuring report has nominal, tolerances, measured, deviation
_TURN = (
    "the axes stand in rows: turn the table, so that each has a column "
    "(in a spreadsheet: copy, then paste special, transpose)"
)


def suggest_columns(tables: Sequence[Sequence[Row]]) -> str:
    """Return what to do with rows that no header names, split in each way that there is.

    Most rows of the same number of fields, most of them numbers, are taken for the table.
    """
    if any(map(runs_across, tables)):
        return ONE_A_ROW
    if any(map(_targets_across, tables)):
        return f"the targets of ISO 230-2: {ONE_A_ROW}"
    if any(map(_axes_in_rows, tables)):
        return _TURN
    rows = max((_alike(rows) for rows in tables), key=lambda r: (len(r), _width(r)), default=[])
    if len(rows) < 2 or _width(rows) > _MOST:
        return ""
    row = rows[-1]
    said = ", ".join(clean(cell) for cell in row.cells)
    counts = _counters(rows)
    numbers = [
        k
        for k, cell in enumerate(row.cells)
        if k not in counts and _is_number(cell) and not _is_clock(rows, k)
    ]
    if not numbers:
        return ""
    named_as = {**counts, **dict(zip(numbers[:3], ("X", "Y", "Z"), strict=False))}
    named = ",".join(named_as.get(k, SKIPPED) for k in range(_width(rows)))
    return (
        f"no header says what {quoted(said)} is: name the fields in turn, {SKIPPED} for what is no "
        f"reading, for example `columns={named}`"
    )


def _axes_in_rows(rows: Sequence[Row]) -> bool:
    """Say whether a row begins with an axis and goes on with its readings."""
    return any(
        len(row.cells) > _FEWEST_ACROSS
        and read_name(row.cells[0]).kind is Kind.AXIS
        and all(map(_is_number, row.cells[1:]))
        for row in rows
    )


def _targets_across(rows: Sequence[Row]) -> bool:
    """Say whether a cell is a heading of ISO 230-2, where targets stand in place of axes."""
    short = (clean(cell).lower() for row in rows for cell in row.cells if len(cell) <= LONGEST_NAME)
    return any(map(_TARGET.fullmatch, short))


def _counters(rows: Sequence[Row]) -> dict[int, str]:
    """Return the fields that count or repeat, as cycle and pose, beside one that does neither."""
    columns = [[row.cells[k].strip() for row in rows] for k in range(_width(rows))]
    whole = {k: list(map(int, c)) for k, c in enumerate(columns) if all(map(str.isdecimal, c))}
    cycle = (k for k, c in whole.items() if all(b == a + 1 for a, b in pairwise(c)))
    pose = (k for k, c in whole.items() if 1 < len(set(c)) <= len(c) // _OFTEN)
    found = {next(cycle, -1): "cycle", next(pose, -1): "pose"} if len(whole) < len(columns) else {}
    return {k: name for k, name in found.items() if k >= 0}


def _is_clock(rows: Sequence[Row], k: int) -> bool:
    """Say whether a field rises from row to row, as a clock and a count do, or never changes."""
    values = [number.value for row in rows if (number := parse_cell(row.cells[k]))]
    rises = all(after > before for before, after in pairwise(values))
    return len(values) > 2 and (rises or len(set(values)) == 1)


def _alike(rows: Sequence[Row]) -> list[Row]:
    numbers = [row for row in rows if _mostly_numbers(row.cells)]
    widths = [len(row.cells) for row in numbers]
    usual = max(widths, key=widths.count, default=0)
    return [row for row in numbers if len(row.cells) == usual]


def _width(rows: Sequence[Row]) -> int:
    return len(rows[0].cells) if rows else 0


def _is_number(cell: str) -> bool:
    number = parse_cell(cell)
    return number is not None and (not number.unit or read_unit(number.unit) is not None)


def _mostly_numbers(cells: Sequence[str]) -> bool:
    numbers = sum(map(_is_number, cells))
    if not 0 < numbers or 3 * numbers < len(cells):
        return False
    words = (cell for cell in cells if len(cell) <= LONGEST_NAME)
    return not any(read_name(word).kind is Kind.AXIS for word in words)  # a row for each axis
