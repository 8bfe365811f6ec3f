"""Columns that whoever asks names: by their position (`columns=`), or under names that are known.

Tables of the second kind hold no cycles: a gauge study, a force loop, a sweep of reversals.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.run import UNITS, FloatArray, unit_of_condition
from scara_iso.tables.body import check_remarks, rare_remarks, rows_in_words
from scara_iso.tables.columns import Columns, check_marks
from scara_iso.tables.grid import (
    CellGrid,
    Faults,
    Line,
    Row,
    is_comment,
    is_filled,
    refuse,
    stripped,
    text_row,
)
from scara_iso.tables.names import (
    COLUMNS,
    Column,
    Kind,
    Layout,
    axes_in,
    axis_column,
    header_cells,
    holds_other_delimiter,
    names_an_axis,
    names_and_units,
    read_name,
    read_names,
    read_unit,
    settle,
    unit_in_brackets,
)
from scara_iso.tables.scales import Scales, sizes_in
from scara_iso.tables.statements import Statement, read_head
from scara_iso.tables.words import LONGEST_NAME, clean, names_a_footer, parse_cell, quoted

SKIPPED = "-"


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
    columns = [
        column._replace(heading=f"field {column.position + 1}") if name == SKIPPED else column
        for name, column in zip(
            names, read_names(["note" if n == SKIPPED else n for n in names]), strict=True
        )
    ]
    fitting = [row for row in rows if _fits(row, columns)]
    if holds_other_delimiter([row.cells for row in fitting]):
        return None
    # LabVIEW's "Samples 5 5" above its columns is not like the rows
    row = next((row for row in fitting if _is_like(row, fitting[-1])), None)
    if row is None:
        return None
    above = [one for one in rows if one.line < row.line]
    found = (settle(c, row.cells[c.position]) for c in columns)
    settled = tuple(_with_unit(column, above) for column in found)
    return Layout(settled, row.line, row.line, sure=True, known=len(fitting))


def _fits(row: Row, columns: Sequence[Column]) -> bool:
    if len(row.cells) < len(columns) or any(map(is_filled, row.cells[len(columns) :])):
        return False
    sized = (c for c in columns if c.kind in (Kind.AXIS, Kind.CYCLE))
    return all(parse_cell(row.cells[c.position]) is not None for c in sized)


def _is_like(row: Row, other: Row) -> bool:
    """Say whether no field holds a number in one row and words in the other."""
    pairs = [p for p in zip(row.cells, other.cells, strict=False) if all(map(str.strip, p))]
    return all((parse_cell(a) is None) == (parse_cell(b) is None) for a, b in pairs)


def _unit_above(row: Row, column: Column) -> str:
    return unit_in_brackets(row.cells[column.position]) if column.position < len(row.cells) else ""


def _with_unit(column: Column, above: Sequence[Row]) -> Column:
    """Return an axis with the unit of the file's own heading, where `columns=` states none."""
    stated = [unit for row in above if (unit := _unit_above(row, column))]
    lacks = column.kind is Kind.AXIS and not column.unit and stated
    return column._replace(unit=stated[-1]) if lacks else column


def check_names(rows: Iterable[Row], layout: Layout, faults: Faults) -> None:
    """Refuse names and units that the file's own header gives otherwise, and incomplete rows."""
    axes = layout.of(Kind.AXIS)
    for row in (row for row in rows if row.line < layout.header_line):
        filled = [cell for cell in row.cells if cell.strip()]
        if filled and all(map(parse_cell, filled)):
            what = f"{len(filled)} numbers above the first row of {layout.width} fields"
            faults.add(what, row.line, remedy="complete the line, or remove it")
        for column in axes:
            place, unit = (row.line, column.position + 1), _unit_above(row, column)
            if unit and read_unit(unit) != read_unit(column.unit):
                what = f"{quoted(unit)} heads {column.name}, and `columns=` states {column.unit}"
                faults.add(what, *place, remedy="name the unit that is true")
            wide = len(row.cells) >= layout.width and ":" not in row.cells[0]
            cell = row.cells[column.position] if wide and not names_an_axis(row.cells) else ""
            if (named := axes_in(cell)) and column.name not in named:
                what = f"{quoted(cell)} heads {column.name} of `columns=`"
                faults.add(what, *place, remedy="name each field by the axis that its heading says")
        own = header_cells(row.cells) if names_an_axis(row.cells) else []
        stated = {c.name: c.position for c in axes}
        for column in read_names(own):
            k = stated.get(column.name, column.position)
            if column.kind is Kind.AXIS and k != column.position:
                what = f"{column.name} by the header, and `columns=` says it is field {k + 1}"
                remedy = "leave `columns=` out, or remove the header"
                faults.add(what, row.line, column.position + 1, remedy=remedy)


_SMALLEST = 1e-30
_MOST_ROWS = 100_000


@dataclass(frozen=True, slots=True)
class ColumnNames:
    """What a table is to hold: ``what`` it is, its columns, and what to do where it does not."""

    what: str
    needed: tuple[str, ...]
    remedy: str
    optional: tuple[str, ...] = ()
    positive: frozenset[str] = frozenset()
    with_unit: tuple[str, ...] = ()
    """Columns in a unit, which their header may state: ``reading_mm``, ``reading [um]``."""
    same_unit: str = ""
    """The one of them that is in the unit of the first where it states none."""
    labels: frozenset[str] = frozenset()
    """Columns of names, which are text: ``operator``."""
    aliases: Mapping[str, str] = field(default_factory=dict)
    """Other spellings of a header, in lower case."""

    def find(self, rows: Sequence[Row]) -> Layout | None:
        """Return the layout of the header among rows.

        It is the first row, or one without a number above one with a number, of which most cells
        are known; of several the last, as ``Operator, Anna`` may stand above.
        """
        rows = [row for row in rows if row.text and not is_comment(row.text)]
        numbers = [any(map(parse_cell, row.cells)) for row in rows]
        pairs = zip(rows, numbers, numbers[1:], strict=False)
        heads = [*rows[:1], *(row for row, here, below in pairs if below and not here)]
        found = [(sum(c.name != "" for c in map(self._column, r.cells)), r) for r in heads]
        if not found:
            return None
        known, best = max(reversed(found), key=lambda one: one[0])
        row = next(row for row in rows if row.cells == best.cells)
        columns = (self._column(c)._replace(position=k, heading=c) for k, c in enumerate(row.cells))
        return Layout(tuple(columns), row.line, row.end + 1, True, known)

    def _column(self, cell: str) -> Column:
        """Return the column that a header cell names; of any other name a comment of none."""
        known = {n.lower(): n for n in (*self.needed, *self.optional)} | {**self.aliases}
        for text, unit in names_and_units(clean(cell)) if len(cell) <= LONGEST_NAME else ():
            name = known.get(text.lower(), "")
            if name in self.with_unit:
                return Column(Kind.AXIS, name, unit)
            if name and not unit:
                return Column(Kind.LABEL if name in self.labels else Kind.COVARIATE, name)
        axis = axis_column(clean(cell), "")
        if axis is not None and axis.kind is Kind.AXIS and axis.name in self.with_unit:
            return axis
        return Column(Kind.COMMENT, "")

    def check(self, layout: Layout, faults: Faults) -> None:
        """Add the columns that are missing, or there twice."""
        found = [column.name for column in layout.columns]
        for name in (*self.needed, *self.optional):
            if found.count(name) > 1 or (name in self.needed and name not in found):
                what = "there twice" if name in found else "missing"
                faults.add(f"column {name} is {what}", layout.header_line, remedy=self.remedy)


@dataclass(frozen=True, eq=False, slots=True)
class NamedColumns:
    """The columns that were found, shape (rows,) each; those of other names are left out."""

    values: Mapping[str, FloatArray]
    """Those with a unit in mm or degrees."""
    labels: Mapping[str, tuple[str, ...]]
    """The columns of names, as text."""
    statements: Mapping[str, str]
    """``# key: value`` lines by key."""
    scales: Scales
    """Units and sizes of the columns that have a unit."""
    source: str
    header_line: int
    lines: tuple[int, ...]
    """Of the rows."""
    faults: Faults
    """Where to add what else is wrong with the table, and to raise it."""
    notes: tuple[str, ...]
    """What was not used, a line each."""
    groups: Mapping[str, int]
    """Columns that were not used and part the rows into groups, with the number of these."""
    remarks: tuple[str, ...]
    """What columns that were not used say of few rows."""


def fill_named(
    grid: CellGrid,
    names: ColumnNames,
    *,
    unit: str | None,
    decimal: str | None,
) -> NamedColumns:
    """Return the columns of a grid that has them; raises `DataError` with every fault of a cell."""
    faults = Faults(grid.where, names.what, sheet=grid.title)
    layout = names.find(grid.head)
    body, apart = ([], []) if layout is None else _parted(grid, layout, faults)
    if layout is None or not body or len(body) >= _MOST_ROWS:
        faults.check()
        what = "a header and at least one row are needed"
        raise refuse(grid.where, what, remedy=names.remedy)
    form = [r for r in grid.head if r.line < layout.header_line or is_comment(r.text)]
    stated, notes = read_head(form, faults)
    names.check(layout, faults)
    before, columns = faults.total, Columns(layout, decimal, faults)
    columns.add(body)
    numbers = {c: columns.values(c) for c in layout.of(Kind.AXIS, Kind.COVARIATE)}
    for column, values in numbers.items():
        _check(column, values, columns, names)
    if faults.total > before == 0:
        faults.first_remedy = names.remedy
    else:
        check_marks(columns, sizes_in(stated))
    check_remarks(columns, (), discarded=0)
    _check_labels(columns)
    faults.check()
    scales = _scales(columns, names, stated, unit)
    notes += [f"column {clean(c.heading)!r} not used" for c in layout.of(Kind.COMMENT)]
    groups, of_rows = _unused(columns)
    to_base = {name: one.to_base for name, one in scales.units.items()}
    readings = {name: to_base[name](v) for c, v in numbers.items() if (name := c.name) in to_base}
    return NamedColumns(
        values={c.name: v for c, v in numbers.items()} | readings,
        labels={c.name: tuple(columns.labels(c).tolist()) for c in layout.of(Kind.LABEL)},
        statements={key: one.value for key, one in stated.items()},
        scales=scales,
        source=grid.where,
        header_line=layout.header_line,
        lines=tuple(columns.all_lines().tolist()),
        faults=faults,
        notes=(*notes, *apart),
        groups=groups,
        remarks=(*of_rows, *rows_in_words(readings, faults, form)),
    )


def _unused(columns: Columns) -> tuple[dict[str, int], list[str]]:
    """Return what parts the rows into groups, and what is said of few rows: `NamedColumns`."""
    layout, called = columns.layout, columns.faults.row
    rare = {column: rare_remarks(columns, column) for column in layout.of(Kind.COMMENT)}
    groups = {
        column.heading: len(columns.distinct(column))
        for column, found in rare.items()
        if not found and _is_factor(column, columns)
    }
    of_rows = [f"{called} {line} {text}" for f in rare.values() for line, text in f]
    return groups, of_rows


def _is_factor(column: Column, columns: Columns) -> bool:
    """Say whether a column holds what comes again and again, and is no count, time or condition."""
    labels = columns.labels(column)
    named = read_name(column.heading)
    is_condition = unit_of_condition(named.unit) in UNITS and read_unit(named.unit) is None
    known = named.kind in (Kind.CYCLE, Kind.TIMESTAMP) or is_condition
    counts = np.unique(labels, return_counts=True)[1]
    return not known and 1 < len(counts) <= len(labels) / 2


def _scales(
    columns: Columns, names: ColumnNames, stated: Mapping[str, Statement], unit: str | None
) -> Scales:
    sized = columns.layout.of(Kind.AXIS)
    if unit is None and "unit" not in stated:
        first = next((column.unit for column in sized if column.unit), "")
        as_first = {c for c in sized if not c.unit and c.name == names.same_unit}
        sized = [c._replace(unit=first) if c in as_first else c for c in sized]
    return Scales(columns, sized, stated, unit)


def _below(grid: CellGrid, layout: Layout, faults: Faults) -> Iterator[Line]:
    for line, cells in grid.rows():
        row = text_row(line, cells)
        if line < layout.data_line or not row.text or is_comment(row.text):
            continue
        if len(cells) == layout.width:
            yield line, cells
        else:
            remedy = (
                "put a text that holds a comma in quotes; decimal commas want a table that is "
                "separated by semicolons"
            )
            faults.add(f"{len(cells)} fields, the header has {layout.width}", line, remedy=remedy)


def _parted(grid: CellGrid, layout: Layout, faults: Faults) -> tuple[list[Line], list[str]]:
    """Return the rows below the header, and a note of each whose first cell is a footer's name.

    In a column of names a word is one, unless most of them are numbers.
    """
    body = list(_below(grid, layout, faults))
    if not layout.columns or layout.columns[0].kind not in (Kind.COMMENT, Kind.LABEL):
        return body, []
    named = [stripped(str(cells[0])) for _, cells in body]
    words = [bool(text) and parse_cell(text) is None for text in named]
    if layout.columns[0].kind is Kind.LABEL and 2 * sum(words) >= len(words):
        return body, []
    apart = {k for k, text in enumerate(named) if words[k] and names_a_footer(text)}
    rows = [text_row(*one) for k, one in enumerate(body) if k in apart]
    notes = [f"{faults.row} {row.line}: {quoted(row.text)} counts as no reading" for row in rows]
    return [one for k, one in enumerate(body) if k not in apart], notes


def _check_labels(columns: Columns) -> None:
    """Add a label that may be a summary of other rows: a footer's name, or a word among numbers.

    Half as many rows have it as a usual one, or numbers count the rows.
    """
    for column in columns.layout.of(Kind.LABEL, Kind.COMMENT):
        labels, counts = np.unique(columns.labels(column), return_counts=True)
        words = [parse_cell(label) is None for label in labels.tolist()]
        numbered = column.position == 0 and 2 * sum(words) < len(words)
        usual = np.median(counts)
        for label, count, is_word in zip(labels.tolist(), counts.tolist(), words, strict=True):
            rare = 2 * count <= usual or (numbered and usual == 1)
            named = column.kind is Kind.LABEL and names_a_footer(label)
            if label and is_word and rare and (named or numbered):
                columns.faults.add(
                    f"{quoted(label)} among {quoted(column.heading)}: a summary?",
                    columns.layout.header_line,
                    remedy="remove rows that hold something else, or name them as the others",
                )


def _check(column: Column, values: FloatArray, columns: Columns, names: ColumnNames) -> None:
    """Add numbers with a unit in a column that has none, not positive, or of no drive."""
    lines, units = columns.all_lines(), {*columns.units.get(column, {})} - {""}
    size = np.abs(values)
    faults = {
        "is beyond any drive": (size > 0) & ~((size > _SMALLEST) & (size < 1 / _SMALLEST)),
        "is not positive": (values <= 0) & (column.name in names.positive),
        f"has a unit, {quoted(''.join(units))}": np.full(
            len(values), column.kind is Kind.COVARIATE and bool(units)
        ),
    }
    for what, rows in faults.items():
        for k in np.flatnonzero(rows).tolist():
            said = f"{column.name}: {values[k]:g} {what}"
            columns.fault(column, said, int(lines[k]), remedy=names.remedy)
