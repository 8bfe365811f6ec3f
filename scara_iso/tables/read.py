"""From a source to a `Run`: bytes, grids, the one that is a table, its head, header and body.

A text is parted in every way that there is, a workbook into its sheets. What a grid is tried for,
in this order, is said by `_kind_of`: named positions, a header above numbers, poses in the
headings, a header alone; blocks under poses' names have a header each. A text that is none of these
may be a log that names its numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

from scara_iso.base.errors import DataError, ScaraIsoError, UsageError
from scara_iso.run import Run
from scara_iso.tables.assemble import ReadOptions, assemble
from scara_iso.tables.grid import (
    HEAD,
    CellGrid,
    Delimiter,
    Faults,
    FileText,
    Row,
    grids_of,
    head_of,
    refuse,
    split_rows,
    text_row,
    together,
)
from scara_iso.tables.layout import (
    ONE_A_ROW,
    check_names,
    column_names,
    find_layout,
    find_worded,
    place_columns,
    runs_across,
    suggest_columns,
)
from scara_iso.tables.poses import PosePart, merge
from scara_iso.tables.shapes import find_axes, find_blocks, find_headings, find_log
from scara_iso.tables.source import Source, called_text, open_source, refuse_other_marks
from scara_iso.tables.statements import read_statements, refuse_unused
from scara_iso.tables.vocabulary.names import COLUMNS, Layout, is_axis, length_in_words, pose_in
from scara_iso.tables.vocabulary.sentences import (
    holds_an_open_ratio,
    in_parts_of_a_unit,
    speaks_of_cycles,
    speaks_of_scale,
)
from scara_iso.tables.vocabulary.words import (
    Mark,
    clean,
    listed,
    names_a_footer,
    parse_cell,
    quoted,
    quoted_whole,
    topic_of,
)

_NO_HEADER = "begin with a header row that names its columns, such as 'cycle,X,Y,Z,theta'"
_TEXT_HEAD = 100_000
"""Characters in which a text is known by its sentences."""
_MOST_QUOTED = 20
"""Lines of words of a sheet without a table that are quoted."""
_TOO_WIDE = (
    "leave the columns in the file that are needed: cycle, pose, the axes, and what they depend on"
)


def read_table(
    source: Source,
    *,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    sheet: str | None = None,
    columns: str | Sequence[str] | None = None,
) -> Run:
    """Return the `Run` that a table holds: text in any usual spelling, or an .xlsx workbook.

    ``source`` is a path, ``-`` for standard input, bytes or a binary file. ``unit`` and
    ``resolution`` (in that unit) stand for the file's statements of that name; ``decimal``, "," or
    ".", says how to read numbers that can be read two ways, and lets the other mark group
    thousands; ``sheet`` names the sheet of a workbook; ``columns`` names the fields of a row in
    turn where no header does, ``-`` one to leave out: ``"cycle,X,Y,-"``, or a sequence.

    Readings come in mm, or degrees where their unit is an angle. `Axis` holds what the file
    states as unit, resolution, indicator_uncertainty and command_X; ``Run.metadata`` every other
    statement, keys in lower case with underscores. Columns of a fault are field numbers, from 1.

    Raises `NoInputError` for a file that cannot be opened, `DataError` with its faults (the first
    thousand kept) for one that is not a table or could be read two ways, `UsageError` for an option
    that is not valid.
    """
    refuse_other_marks(decimal)
    if resolution is not None and not 0 < resolution < math.inf:
        raise UsageError(f"resolution {resolution!r}", remedy="give a number above zero")
    named = None if columns is None else column_names(columns)
    options = ReadOptions(unit, resolution, decimal, sheet, named)
    name, found = open_source(source, _NO_HEADER)
    if isinstance(found, list):
        return _of_workbook(found, name, options)
    if sheet is not None:
        raise refuse(name, "`sheet=` is for workbooks, this is text", remedy="leave `sheet=` out")
    with called_text(found.text[:_TEXT_HEAD].split("\n"), name):
        return _of_text(found, name, options)


def _of_text(text: FileText, name: str, options: ReadOptions) -> Run:
    """Return the run of a text under the delimiter that makes most of it, or of a log."""
    grids = grids_of(text, name)
    wide = [row for grid in grids for row in grid.head if len(row.cells) > COLUMNS]
    grids = [grid for grid in grids if all(len(row.cells) <= COLUMNS for row in grid.head)]
    unlike: dict[str, CellGrid] = {}
    for grid in grids:  # a text without most delimiters is one and the same by each of them
        unlike.setdefault(repr([row.cells for row in grid.head]), grid)
    grids = list(unlike.values())
    ranked = [(kind, grid) for grid in grids if (kind := _kind_of(grid, options.columns))]
    best = max(ranked, key=lambda one: one[0], default=None)
    if wide and (best is None or best[0] < _SURE):
        what = f"line {wide[0].line} has {len(wide[0].cells)} fields, more than {COLUMNS}"
        raise refuse(name, what, remedy=_TOO_WIDE)
    if best is not None:
        return _read(best[1], options)
    return _of_log(text, name, options)


def _layout_of(grid: CellGrid, names: Sequence[str] | None) -> Layout | None:
    """Return the layout by named positions, else of a header, whose axes a word may be with."""
    if names:
        return place_columns(grid.head, names)
    return find_layout(grid.head) or find_worded(grid.head)


_SURE, _HEADINGS, _WORDED, _ALONE = (2, 0), (1, 1), (1, 0), (0, 0)


def _kind_of(grid: CellGrid, names: Sequence[str] | None) -> tuple[int, int] | None:
    """Return how well a grid is understood, None where it holds no table.

    Best is a header above a row of numbers, or named positions, then headings that name poses, then
    a header alone; of two alike that which knows more columns, or rows of the named width.
    """
    layout = _layout_of(grid, names)
    if layout and not layout.worded:
        return (_SURE if layout.sure else _ALONE)[0], layout.known
    if not names and find_headings(grid.head):
        return _HEADINGS
    if not names and layout is None and find_axes(grid):
        return _ALONE
    return _WORDED if layout else None


def _read(grid: CellGrid, options: ReadOptions) -> Run:
    """Return the run of a grid, of its blocks if it has some, or every fault of all."""
    blocks = [] if options.columns is not None else find_blocks(grid)
    if not blocks:
        layout = _layout_of(grid, options.columns)
        axes = [] if options.columns or layout else find_axes(grid)
        return _of_axes(axes, options) if axes else _read_one(grid, layout, options)
    parts, errors = [], []
    options = options._replace(sizes=_with_decimal_commas(grid))
    for pose, block, place in blocks:
        try:
            run = _read_one(block, _layout_of(block, None), options)
            parts.append(PosePart(run, f"block of {pose}", "", place, pose))
        except DataError as error:
            errors.append(error)
    if errors:
        raise together(errors, grid.where)
    return merge(parts, grid.where)


def _of_axes(grids: Sequence[CellGrid], options: ReadOptions) -> Run:
    """Return the run of a table with a row for each axis of a visit: its axes side by side."""
    try:
        runs = [_read_one(grid, _layout_of(grid, None), options) for grid in grids]
        run = merge([PosePart(one, " ".join(one.axes)) for one in runs], grids[0].where)
    except DataError as error:
        error.remedy += "; a column names the axis of each row, which is read as a column"
        raise
    stated = {**run.metadata, **runs[0].metadata}
    own = {k: v for k, v in stated.items() if k != "axes_recorded" or k in runs[0].metadata}
    of_others = tuple(f"there is no axis {axis}" for axis in run.axes)
    notes = tuple(note for note in run.origin.notes if not note.endswith(of_others))
    return replace(run, metadata=own, lines=runs[0].lines, origin=replace(run.origin, notes=notes))


def _with_decimal_commas(grid: CellGrid) -> tuple[str, ...]:
    """Return numbers that can only have a decimal comma, none where some have a point."""
    texts = (cell for _, cells in grid.rows() for cell in cells if isinstance(cell, str))
    marks = {number.mark: text for text in texts if (number := parse_cell(text))}
    return () if {Mark.POINT, Mark.BOTH} & {*marks} else tuple(marks.get(Mark.COMMA, "").split())


def _read_one(grid: CellGrid, layout: Layout | None, options: ReadOptions) -> Run:
    if layout is None:
        what = "no header that names an axis X, Y, Z or theta"
        raise refuse(grid.where, what, remedy=_NO_HEADER)
    if not layout.sure and (across := runs_across(grid.head)):
        raise refuse(grid.where, f"line {across.line} names runs side by side", remedy=ONE_A_ROW)
    faults = Faults(grid.where, sheet=grid.title)
    if options.columns:
        check_names(grid.head, layout, faults)
    return assemble(grid, layout, options, faults)


def _of_log(text: FileText, name: str, options: ReadOptions) -> Run:
    """Return the run of a log that names its numbers, or say why the file is no table."""
    lines = text.text.split("\n")
    log = None if options.columns else find_log(lines, name)
    if log is None:
        heads = [split_rows(lines[:HEAD], delimiter) for delimiter in Delimiter]
        raise _no_table(heads, name, options.columns)
    head, readings, unit, notes = log
    how = f"numbers with their names, {text.encoding}"
    grid = CellGrid(name, how, [*head, *head_of(readings)][:HEAD], readings)
    options = options._replace(unit=options.unit or unit)
    run = _read_one(grid, _layout_of(grid, options.columns), options)
    return _with_notes(replace(run, origin=replace(run.origin, header_line=None)), notes)


def _no_table(heads: Sequence[Sequence[Row]], name: str, names: Sequence[str] | None) -> DataError:
    if any(map(runs_across, heads)):
        return refuse(name, "a column for each run", remedy=ONE_A_ROW)
    if name.lower().endswith(".toml"):
        remedy = "name the table of readings; a model goes to `model=`, where that is taken"
        return refuse(name, "a .toml file is not a table of readings", remedy=remedy)
    what = f"no header that names an axis X, Y, Z or theta in the first {HEAD} lines"
    if names:
        what = f"no row of {len(names)} fields with numbers for the axes in the first {HEAD} lines"
    return refuse(name, what, remedy=_suggest(heads))


def _suggest(heads: Sequence[Sequence[Row]]) -> str:
    """Return what to do where no header is found, such as about a number in one."""
    for row in chain.from_iterable(heads):
        numbers = [cell for cell in row.cells if parse_cell(cell)]
        if numbers and len(row.cells) > 2 * len(numbers) and any(map(is_axis, row.cells)):
            what = f"row {row.line} names an axis, and {quoted(numbers[0])} names no column"
            return f"{what}: remove what stands beside the table, or head each of its columns"
    return suggest_columns(heads) or _NO_HEADER


def _with_notes(run: Run, notes: Iterable[str]) -> Run:
    return replace(run, origin=replace(run.origin, notes=(*run.origin.notes, *notes)))


def _of_workbook(sheets: Sequence[CellGrid], name: str, options: ReadOptions) -> Run:
    """Return the run of a workbook: of its only table, or of the sheets that name a pose.

    Sheets without a table state what holds for all: a cover sheet. One with a table that was not
    asked for states for that alone.
    """
    asked = [one for one in sheets if options.sheet in (None, one.title)]
    seen = [one for one in asked if options.sheet or not one.hidden]
    notes = [f"sheet {quoted(one.title)} is hidden: not used" for one in asked if one not in seen]
    found = {one.title: one for one in seen if _kind_of(one, options.columns)}
    others = [one for one in sheets if one.title not in found and not one.hidden]
    apart = [one for one in others if (_kind_of(one, None) or _ALONE) >= _SURE]
    notes += [f"sheet {quoted(one.title)} holds another table: not used" for one in apart]
    others = [one for one in others if one not in apart]
    cover, unused = _cover(others, name) if found else ([], [])
    notes += unused
    found = {title: one._replace(cover=[*one.cover, *cover]) for title, one in found.items()}
    if len(found) == 1:
        return _with_notes(_read(next(iter(found.values())), options), notes)
    parts, left = _poses_of(found, name, options)
    if len(parts) < 2:
        raise _which_sheet(name, sheets, found, options, _suggest([s.head for s in asked]))
    if left:
        what = f"sheet {quoted(left[0])} holds readings and names no pose, as the others do"
        remedy = "call it by its pose, or hide it; `sheet=` names one to read alone"
        raise refuse(name, what, remedy=remedy)
    return merge(parts, name, notes=notes)


def _cover(sheets: Iterable[CellGrid], name: str) -> tuple[list[Row], list[str]]:
    """Return the rows of other sheets that state something, and what to say of the others.

    Their line is 0: they stand above every table. A mean or the like is of a calculation. Raises
    what is wrong with them, once, and where it stands.
    """
    stated: list[Row] = []
    notes: list[str] = []
    errors: list[ScaraIsoError] = []
    for sheet in sheets:
        faults, others = Faults(name, sheet=sheet.title), list[Row]()
        before = len(stated)
        for row in (text_row(line, cells) for line, cells in sheet.rows()):
            if _states_something(row):
                refuse_unused(row, faults)
                stated.append(row._replace(line=0, end=0))
            else:
                others.append(row)
        notes += _left_on(sheet, others, states=len(stated) > before)
        try:
            faults.check()
        except DataError as error:
            errors.append(error)
    if errors:
        raise together(errors, name)
    return stated, notes


def _left_on(sheet: CellGrid, others: Sequence[Row], *, states: bool) -> Iterator[str]:
    """Yield what of a sheet is not used; one with a table, which is not read, is not quoted."""
    called = f"sheet {quoted(sheet.title)}"
    if not states and any(row.text for row in others):
        yield f"{called} holds no table: not used"
    left = [] if _kind_of(sheet, None) else list(filter(_is_sentence, others))
    for row in left[:_MOST_QUOTED]:
        yield f"{called}, row {row.line}: {quoted_whole(row.text)} not used"
    if len(left) > _MOST_QUOTED:
        yield f"{called}: {len(left) - _MOST_QUOTED} more lines of words not used"


def _is_sentence(row: Row) -> bool:
    """Say whether a row holds words of several, and no number as a calculation has."""
    cells = [cell for cell in map(clean, row.cells) if cell]
    numbers = any(parse_cell(cell) is not None for cell in cells)
    return len(row.text.split()) > 1 and not numbers and not names_a_footer(cells[0])


def _poses_of(
    sheets: Mapping[str, CellGrid], name: str, options: ReadOptions
) -> tuple[list[PosePart], list[str]]:
    """Return the sheets that name a pose, and those that do not; raises the faults of the first."""
    parts: list[PosePart] = []
    left: list[str] = []
    errors: list[DataError] = []
    for title, sheet in sheets.items():
        called = f"sheet {quoted(title)}"
        try:
            run = _read(sheet._replace(where=f"{name}, {called}"), options)
        except DataError as error:
            if pose_in(title):
                errors.append(error)
            else:
                left.append(title)
            continue
        if pose_in(title) or run.pose is not None or "pose" in run.metadata:
            parts.append(PosePart(run, called, title, "the sheet's name"))
        else:
            left.append(title)
    if errors and len(errors) + len(parts) > 1:
        raise together(errors, name)
    return parts, left


def _which_sheet(
    name: str,
    sheets: Iterable[CellGrid],
    found: Iterable[str],
    options: ReadOptions,
    suggested: str,
) -> DataError:
    asked, names, found = options.sheet, [one.title for one in sheets], list(found)
    if asked is not None and asked not in names:
        what = f"no sheet {quoted(asked)}; there are {listed(map(quoted, names))}"
        return refuse(name, what, remedy="name one of them with `sheet=`")
    if not found:
        begun = " names an axis, and " in suggested
        header = "of names alone" if begun else "that names an axis X, Y, Z or theta"
        return refuse(name, f"no sheet with a header {header}", remedy=suggested)
    return refuse(
        name,
        f"sheets {listed(map(quoted, found))} hold a table each",
        remedy=f"say which, for example `sheet={quoted(found[0])}`, or name the sheets of one "
        "test by their poses: P1, P2; save those of several robots or days as a file each",
    )


def _states_something(row: Row) -> bool:
    """Say whether a row of another sheet states what may be of a table's readings."""
    stated = read_statements(row)
    speaks = (speaks_of_scale, speaks_of_cycles, holds_an_open_ratio, in_parts_of_a_unit)
    matters = any(one(row.text) for one in (*speaks, length_in_words))
    matters = matters or any(topic_of(one.written) for one in stated)
    return matters or (bool(stated) and not names_a_footer(row.text))
