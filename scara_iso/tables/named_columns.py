"""Tables that hold no cycles: numbers under known names, read as strictly as readings are.

The unit of a named column, and the sizes that a table's ``# key: value`` lines state in it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from scara_iso.base.errors import Fault
from scara_iso.base.quantities import Unit, parse_unit
from scara_iso.run import FloatArray
from scara_iso.tables.faults import Faults, listed, quoted, refuse
from scara_iso.tables.grid import (
    HEAD,
    Cell,
    Row,
    TextPieces,
    grids_of,
    is_comment,
    split_rows,
    stripped,
    text_row,
)
from scara_iso.tables.marks import check_marks, refuse_other_marks
from scara_iso.tables.names import LONGEST_NAME, clean, read_unit
from scara_iso.tables.numbers import Mark, parse_cell
from scara_iso.tables.source import (
    WORKBOOK,
    Source,
    decode_text,
    read_bytes,
    refuse_old_workbook,
)
from scara_iso.tables.statements import read_head

_SMALLEST = 1e-30
_MOST_ROWS = 100_000
_WITH_UNIT = re.compile(r"(.+?)(?: ?[\[(](.+)[\])]|[_ ]([^_ ]+))")

_Rows = list[tuple[Row, Sequence[Cell]]]
"""Rows as text, each with its cells."""


@dataclass(frozen=True, slots=True)
class ColumnNames:
    """What a table is to hold: ``what`` it is, its columns, and what to do where it does not."""

    what: str
    needed: tuple[str, ...]
    remedy: str
    optional: tuple[str, ...] = ()
    positive: frozenset[str] = frozenset()
    with_unit: frozenset[str] = frozenset()
    """Columns that may state their unit: ``reading_mm``, ``reading [um]``."""
    labels: frozenset[str] = frozenset()
    """Columns of names, which are text: ``operator``."""
    aliases: Mapping[str, str] = field(default_factory=dict)
    """Other spellings of a header, in lower case."""

    def find(self, cell: Cell) -> tuple[str | None, str]:
        """Return the column that a header cell names, None for another, and the unit it states."""
        known = {name.lower(): name for name in (*self.needed, *self.optional)} | dict(self.aliases)
        text = clean(str(cell))
        if text.lower() in known:
            return known[text.lower()], ""
        match = _WITH_UNIT.fullmatch(text) if len(text) <= LONGEST_NAME else None
        name = known.get(match[1].lower()) if match else None
        unit = (match[2] or match[3]) if match else ""
        if name not in self.with_unit or (match and match[3] and read_unit(unit) is None):
            return None, ""
        return name, unit

    def count(self, header: Sequence[Cell]) -> int:
        """Return how many cells of a header are known."""
        return sum(self.find(cell)[0] is not None for cell in header)


@dataclass(frozen=True, eq=False, slots=True)
class NamedColumns:
    """The columns that were found, shape (rows,) each; those of other names are left out."""

    values: Mapping[str, FloatArray]
    units: Mapping[str, str]
    """By column, as its header states it."""
    statements: Mapping[str, str]
    """``# key: value`` lines by key."""
    source: str
    header_line: int
    left_out: tuple[str, ...]
    labels: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """The columns of names, as text."""
    decimal: str | None = None
    """The decimal mark that was named, if one was."""
    notes: tuple[str, ...] = ()
    """What above the header was not used, a line each."""


def read_columns(source: Source, names: ColumnNames, *, decimal: str | None = None) -> NamedColumns:
    """Return the columns of a table, text or .xlsx, in the spellings that `read_table` takes.

    ``decimal`` as there; ``#`` begins a comment line. Raises `NoInputError` where it cannot be
    read, `DataError` with every fault and its line, `UsageError` for another mark.
    """
    refuse_other_marks(decimal)
    data, where = read_bytes(source)
    read = _of_workbook if data.startswith(WORKBOOK) else _of_text
    rows = [row for row in read(data, where, names) if row[0].text]
    faults = Faults(where, names.what)
    place = _find_header(rows, names)
    body = [row for row in rows[place + 1 :] if not is_comment(row[0].text)]
    if not body or len(body) >= _MOST_ROWS or is_comment(rows[place][0].text):
        raise refuse(where, "a header and at least one row are needed", remedy=names.remedy)
    form = (row for k, (row, _) in enumerate(rows) if k < place or is_comment(row.text))
    stated, notes = read_head(form, faults)
    header = rows[place][0]
    named = [names.find(cell) for cell in header.cells]
    _check_names([name for name, _ in named], header.line, names, faults)
    whole = [(row.line, cells) for row, cells in body if _is_whole(row, header, faults)]
    marks: dict[Mark, tuple[int, int, str]] = {}
    values, labels = dict[str, FloatArray](), dict[str, tuple[str, ...]]()
    for k, (name, _) in enumerate(named):
        column = [(line, k + 1, cells[k]) for line, cells in whole]
        if name in names.labels:
            labels[name] = tuple(_label(name, one, faults) for one in column)
        elif name:
            read_one = (_value(name, one, names, marks, faults, decimal) for one in column)
            values[name] = np.fromiter(read_one, np.float64, len(column))
    if decimal is None:
        check_marks({mark: at for mark, at in marks.items() if mark is not Mark.NONE}, faults)
    faults.check()
    return NamedColumns(
        values=values,
        units={name: unit for name, unit in named if name and unit},
        statements={key: one.value for key, one in stated.items()},
        source=where,
        header_line=header.line,
        left_out=tuple(
            clean(c) for c, (name, _) in zip(header.cells, named, strict=True) if name is None
        ),
        labels=labels,
        decimal=decimal,
        notes=tuple(notes),
    )


def _of_text(data: bytes, where: str, names: ColumnNames) -> _Rows:
    refuse_old_workbook(data, where)
    text, encoding = decode_text(data, where)
    grids = grids_of(TextPieces.of(text, encoding, ended=True), where)
    best = max(grids, key=lambda grid: _known([(r, r.cells) for r in grid.head], names))
    rows = split_rows(text.split("\n"), best.delimiter) if best.delimiter else []
    return [(row, row.cells) for row in rows[len(grids) == 1 :]]  # sep=; states the only one


def _of_workbook(data: bytes, where: str, names: ColumnNames) -> _Rows:
    from scara_iso.tables.workbook import read_sheets  # noqa: PLC0415 - for workbooks only

    sheets = {one.title: one.rows() for one in read_sheets(data, where)}
    rows = {title: [(text_row(*one), one[1]) for one in lines] for title, lines in sheets.items()}
    found = {t: r for t, r in rows.items() if r and _known(r, names) >= len(names.needed)}
    if len(found) != 1:
        which = f"sheets {listed(map(quoted, found))} hold" if found else "no sheet holds"
        remedy = "leave one" if found else names.remedy
        raise refuse(where, f"{which} {names.what}", remedy=remedy)
    return next(iter(found.values()))


def _known(rows: _Rows, names: ColumnNames) -> int:
    """Return how many cells of the header are known."""
    return names.count(rows[_find_header(rows, names)][0].cells) if rows else 0


def _find_header(rows: _Rows, names: ColumnNames) -> int:
    """Return the place of the header among rows.

    It is the row without a number of which most cells are known, and a row with a number follows;
    of several the last, as ``Operator, Anna`` may stand above. Else the first.
    """
    head = [(k, row) for k, (row, _) in enumerate(rows[:HEAD]) if not is_comment(row.text)]
    numbers = [any(map(parse_cell, row.cells)) for _, row in head]
    found = [
        (names.count(row.cells), k)
        for (k, row), own, below in zip(head, numbers, numbers[1:], strict=False)
        if not own and below
    ]
    known, place = max(found, default=(0, 0))
    if not known:
        return next((k for k, _ in head), 0)
    return next(k for k, row in head if row.cells == rows[place][0].cells)


def _check_names(
    found: Sequence[str | None], line: int, names: ColumnNames, faults: Faults
) -> None:
    for missing in (n for n in names.needed if n not in found):
        faults.add(f"column {missing} is missing", line, remedy=names.remedy)
    for name in (n for n in (*names.needed, *names.optional) if found.count(n) > 1):
        faults.add(f"column {name} is there twice", line, remedy=names.remedy)


def _is_whole(row: Row, header: Row, faults: Faults) -> bool:
    width, wanted = len(row.cells), len(header.cells)
    if width != wanted:
        remedy = "for decimal commas in a comma-separated table, export it with semicolons"
        faults.add(f"{width} fields, the header has {wanted}", row.line, remedy=remedy)
    return width == wanted


def _label(name: str, at: tuple[int, int, Cell], faults: Faults) -> str:
    """Return a name as text; a workbook gives 3 as 3.0."""
    line, field_, cell = at
    text = f"{cell:.15g}" if isinstance(cell, float) else clean(cell)
    if not text:
        faults.add(f"{name}: the cell is empty", line, field_, remedy="write its name")
    return text


def _value(
    name: str,
    at: tuple[int, int, Cell],
    names: ColumnNames,
    marks: dict[Mark, tuple[int, int, str]],
    faults: Faults,
    decimal: str | None,
) -> float:
    cell = at[2]
    value = cell if isinstance(cell, float) else math.nan
    if isinstance(cell, str):
        number = parse_cell(cell, decimal)
        if number is not None and not number.unit:
            value = number.value
            marks.setdefault(number.mark, (*at[:2], stripped(cell)))
    if not math.isfinite(value):
        faults.add(f"{name}: {quoted(str(cell))} is not a number", *at[:2], remedy=names.remedy)
    elif name in names.positive and value <= 0 and Mark.BOTH not in marks:
        faults.add(f"{name}: {value:g} is not positive", *at[:2], remedy=names.remedy)
    elif value and not _SMALLEST < abs(value) < 1 / _SMALLEST:
        faults.add(f"{name}: {value:g} is beyond any drive", *at[:2], remedy=names.remedy)
    return value


def stated_unit(
    table: NamedColumns, column: str, option: str | None, faults: list[Fault]
) -> Unit | None:
    """Return the unit of a column: of its header, of ``# unit``, or ``option``, None for none.

    ``# unit_theta`` holds for that column in place of ``# unit``. A unit that is not known, or is
    stated in two ways, is a fault. Raises `UsageError` for an option that is no unit.
    """
    own = f"unit_{column.lower()}"
    key = own if own in table.statements else "unit"
    stated = {
        "the header": table.units.get(column),
        f"# {key}": table.statements.get(key),
    }
    found = {} if option is None else {"`unit=`": parse_unit(option)}
    before = len(faults)
    for place, text in stated.items():
        if text is not None:
            unit = read_unit(text)
            if unit is None:
                faults.append(Fault(f"{place}: unknown unit {text[:30]!r}", table.header_line))
            else:
                found[place] = unit
    if not found and len(faults) == before:
        faults.append(Fault(f"no unit stated for {column}", table.header_line))
    if len({unit.name for unit in found.values()}) > 1:
        said = ", ".join(f"{place} {unit.name}" for place, unit in found.items())
        faults.append(Fault(f"the unit is stated in two ways: {said}", table.header_line))
    return next(iter(found.values()), None)


def stated_size(
    table: NamedColumns,
    key: str,
    unit: Unit | None,
    faults: list[Fault],
    *,
    above_zero: bool = True,
) -> float | None:
    """Return what a statement gives [mm, deg], in ``unit`` or in its own; None for none.

    What is no number, can be read two ways, or is not above zero where it must be, is a fault.
    """
    text = table.statements.get(key)
    if text is None or unit is None:
        return None
    number = parse_cell(text, table.decimal)
    own = read_unit(number.unit) if number and number.unit else unit
    sure = table.decimal is not None
    doubtful = not sure and number is not None and number.mark in (Mark.EITHER, Mark.BOTH)
    if number is None or own is None or own.dimension is not unit.dimension or doubtful:
        faults.append(Fault(f"{key}: {quoted(text)} is not a size in {unit.name}"))
        return None
    if above_zero and not 0 < number.value < math.inf:
        faults.append(Fault(f"{key}: {quoted(text)} is not a size above zero"))
        return None
    return own.to_base(number.value)
