"""Tables that hold no cycles: numbers under known names, read as strictly as readings are.

The unit of a named column, and the sizes that a table's ``# key: value`` lines state in it.
"""

from __future__ import annotations

import csv
import math
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from scara_iso.base.errors import Fault
from scara_iso.base.quantities import Unit, parse_unit
from scara_iso.run import FloatArray
from scara_iso.tables.body import WHICH_MARK, are_mixed, are_undecided, refuse_other_marks
from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import Faults, listed, quoted, refuse
from scara_iso.tables.layout import HEAD, is_comment
from scara_iso.tables.names import LONGEST_NAME, clean, read_unit
from scara_iso.tables.numbers import BLANKS, Mark, parse_cell
from scara_iso.tables.preamble import (
    Line,
    count_known,
    find_header,
    form_rows,
    is_comment_row,
    read_preamble,
)
from scara_iso.tables.statements import refuse_unused
from scara_iso.tables.text import (
    OLD_WORKBOOK,
    WORKBOOK,
    Delimiter,
    Source,
    decode_text,
    read_bytes,
    split_head,
    split_lines,
    stated_delimiter,
)

_SMALLEST = 1e-30
_MOST_ROWS = 100_000
_WITH_UNIT = re.compile(r"(.+?)(?: ?[\[(](.+)[\])]|[_ ]([^_ ]+))")

_Rows = list[Line]
_Marks = dict[Mark, tuple[int, int, str]]


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
    found = (_of_workbook if data.startswith(WORKBOOK) else _of_text)(data, where, names)
    faults = Faults(where, names.what)
    place = find_header(found, names.count)
    body = [row for row in found[place + 1 :] if not is_comment_row(row[1])]
    comments = [row for row in found[place + 1 :] if is_comment_row(row[1])]
    if not body or len(body) >= _MOST_ROWS or is_comment_row(found[place][1]):
        raise refuse(where, "a header and at least one row are needed", remedy=names.remedy)
    form = form_rows([*found[:place], *comments])
    stated, notes = read_preamble(form, sys.maxsize, faults)
    refuse_unused(form, faults)
    statements = {key: one.value for key, one in stated.items()}
    header_line, header = found[place]
    found_names = _named(found[place], names, faults)
    whole = [row for row in body if _is_whole(row, len(header), faults)]
    values = _columns(whole, found_names, names, faults, decimal)
    labels = _labels(whole, found_names, names, faults)
    faults.check()
    named = dict(names.find(cell) for cell in header)
    return NamedColumns(
        values=values,
        units={name: unit for name, unit in named.items() if name and unit},
        statements=statements,
        source=where,
        header_line=header_line,
        left_out=tuple(clean(str(c)) for c in header if names.find(c)[0] is None),
        labels=labels,
        decimal=decimal,
        notes=tuple(notes),
    )


def _of_text(data: bytes, where: str, names: ColumnNames) -> _Rows:
    if data.startswith(OLD_WORKBOOK):
        raise refuse(where, "an old .xls or a protected workbook", remedy="save it as .xlsx or CSV")
    text, _ = decode_text(data, where)
    lines = [(k, line) for k, line in enumerate(text.split("\n"), 1) if line.strip(BLANKS)]
    sep = stated_delimiter(lines[0][1]) if lines else None
    lines = lines[bool(sep) :]
    head = [line for _, line in lines[:HEAD]]
    heads = {d: [(row.line, row.cells) for row in split_head(head, d)] for d in Delimiter}
    delimiter = sep or max(heads, key=lambda d: count_known(heads[d], names.count))
    faults = Faults(where, names.what)
    rows: _Rows = []
    for k, line in lines:
        comment = line.strip(BLANKS).strip('"')
        try:
            cells = [comment] if is_comment(comment) else split_lines([line], delimiter)[0]
            rows.append((k, cells))
        except csv.Error as error:
            faults.add(f"{error}: {quoted(line)}", k, remedy="close or remove the quote")
    faults.check()
    return [(k, cells) for k, cells in rows if _is_row(cells)]


def _of_workbook(data: bytes, where: str, names: ColumnNames) -> _Rows:
    from scara_iso.tables.workbook import read_sheets  # noqa: PLC0415 - for workbooks only

    found: dict[str, _Rows] = {}
    for sheet in read_sheets(data, where):
        numbered: _Rows = [(k, row) for k, row in enumerate(sheet.rows, 1) if _is_row(row)]
        if numbered and count_known(numbered, names.count) >= len(names.needed):
            found[sheet.name] = numbered
    if len(found) != 1:
        which = f"sheets {listed(map(quoted, found))} hold" if found else "no sheet holds"
        remedy = "leave one" if found else names.remedy
        raise refuse(where, f"{which} {names.what}", remedy=remedy)
    return next(iter(found.values()))


def _is_row(cells: Sequence[Cell]) -> bool:
    return any(not isinstance(cell, str) or cell.strip(BLANKS) for cell in cells)


def _named(
    header: tuple[int, Sequence[Cell]], names: ColumnNames, faults: Faults
) -> list[str | None]:
    """Return the column that each cell of the header names."""
    line, cells = header
    found = [names.find(cell)[0] for cell in cells]
    for missing in (n for n in names.needed if n not in found):
        faults.add(f"column {missing} is missing", line, remedy=names.remedy)
    for name in (n for n in (*names.needed, *names.optional) if found.count(n) > 1):
        faults.add(f"column {name} is there twice", line, remedy=names.remedy)
    return found


def _columns(
    whole: _Rows,
    found: Sequence[str | None],
    names: ColumnNames,
    faults: Faults,
    decimal: str | None,
) -> dict[str, FloatArray]:
    marks: _Marks = {}
    values = {
        name: np.array(
            [
                _value(name, cells[k], (line, k + 1), names, marks, faults, decimal)
                for line, cells in whole
            ]
        )
        for k, name in enumerate(found)
        if name and name not in names.labels
    }
    if decimal is None:
        _check_marks(marks, faults)
    return values


def _labels(
    whole: _Rows, found: Sequence[str | None], names: ColumnNames, faults: Faults
) -> dict[str, tuple[str, ...]]:
    labels: dict[str, tuple[str, ...]] = {}
    for k, name in enumerate(found):
        if name in names.labels and name is not None:
            texts = [(line, _label(cells[k])) for line, cells in whole]
            labels[name] = tuple(text for _, text in texts)
            for line in (line for line, text in texts if not text):
                faults.add(f"{name}: the cell is empty", line, k + 1, remedy="write its name")
    return labels


def _label(cell: Cell) -> str:
    """Return a name as text; a workbook gives 3 as 3.0."""
    return f"{cell:.15g}" if isinstance(cell, float) else clean(str(cell))


def _is_whole(row: tuple[int, Sequence[Cell]], width: int, faults: Faults) -> bool:
    line, cells = row
    if len(cells) != width:
        remedy = "for decimal commas in a comma-separated table, export it with semicolons"
        faults.add(f"{len(cells)} fields, the header has {width}", line, remedy=remedy)
    return len(cells) == width


def _value(
    name: str,
    cell: Cell,
    place: tuple[int, int],
    names: ColumnNames,
    marks: _Marks,
    faults: Faults,
    decimal: str | None,
) -> float:
    value = cell if isinstance(cell, float) else math.nan
    if isinstance(cell, str):
        number = parse_cell(cell, decimal)
        if number is not None and not number.unit:
            value = number.value
            marks.setdefault(number.mark, (*place, cell.strip(BLANKS)))
    if not math.isfinite(value):
        faults.add(f"{name}: {quoted(str(cell))} is not a number", *place, remedy=names.remedy)
    elif name in names.positive and value <= 0 and Mark.BOTH not in marks:
        faults.add(f"{name}: {value:g} is not positive", *place, remedy=names.remedy)
    elif value and not _SMALLEST < abs(value) < 1 / _SMALLEST:
        faults.add(f"{name}: {value:g} is beyond any drive", *place, remedy=names.remedy)
    return value


def _check_marks(marks: _Marks, faults: Faults) -> None:
    """Refuse a comma that could be a decimal or a thousands mark."""
    if are_mixed(marks):
        said = "commas and points both occur"
    elif are_undecided(marks):
        said = "could have a decimal comma or group thousands"
    else:
        return
    for mark in marks.keys() - {Mark.NONE}:
        line, column, text = marks[mark]
        faults.add(f"{quoted(text)}: {said}", line, column, remedy=WHICH_MARK)


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
