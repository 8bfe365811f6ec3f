"""Tables whose columns have names that whoever asks knows, and no cycles.

So are a gauge study, a force loop, a sweep of reversals.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from scara_iso.run import UNITS, FloatArray, unit_of_condition
from scara_iso.tables.body import check_remarks, rare_remarks, rows_in_words
from scara_iso.tables.columns import Columns, check_marks
from scara_iso.tables.grid import (
    CellGrid,
    Faults,
    Line,
    Row,
    grids_of,
    is_comment,
    refuse,
    stripped,
    text_row,
)
from scara_iso.tables.scales import Scales, sizes_in
from scara_iso.tables.source import Source, open_source, refuse_other_marks
from scara_iso.tables.statements import Statement, read_head
from scara_iso.tables.vocabulary.names import (
    Column,
    Kind,
    Layout,
    axis_column,
    names_and_units,
    read_name,
    read_unit,
)
from scara_iso.tables.vocabulary.words import (
    LONGEST_NAME,
    clean,
    listed,
    names_a_footer,
    parse_cell,
    quoted,
)

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


def read_columns(
    source: Source, names: ColumnNames, *, unit: str | None = None, decimal: str | None = None
) -> NamedColumns:
    """Return the columns of a table, text or .xlsx, in the spellings that `read_table` takes.

    ``unit`` and ``decimal`` as there; ``#`` begins a comment line. Raises `NoInputError` where it
    cannot be read, `DataError` with every fault and its line, `UsageError` for another mark.
    """
    refuse_other_marks(decimal)
    where, found = open_source(source, names.remedy)
    if isinstance(found, list):
        grids = [sheet for sheet in found if _known(sheet, names) >= max(len(names.needed), 1)]
        if len(grids) != 1:
            titles = listed(quoted(sheet.title) for sheet in grids) if grids else ""
            which = f"sheets {titles} hold" if grids else "no sheet holds"
            remedy = "leave one" if grids else names.remedy
            raise refuse(where, f"{which} {names.what}", remedy=remedy)
    else:
        grids = grids_of(found, where)
    best = max(grids, key=lambda grid: _known(grid, names))
    return _fill_named(best._replace(where=where), names, unit=unit, decimal=decimal)


def _known(grid: CellGrid, names: ColumnNames) -> int:
    layout = names.find(grid.head)
    return layout.known if layout else 0


def _fill_named(
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
        remarks=(*of_rows, *rows_in_words(readings, scales.units.values(), faults, form)),
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
