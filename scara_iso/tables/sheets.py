"""Rows of cells to a run: a workbook, and tables of several poses on one sheet or in one file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from scara_iso.base.errors import DataError
from scara_iso.run import Run
from scara_iso.tables.assemble import ReadOptions, assemble
from scara_iso.tables.blocks import (
    Block,
    Line,
    check_header,
    find_blocks,
    find_wide,
    place_columns,
    suggest_columns,
)
from scara_iso.tables.body import Body, Delimited
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults, listed, names_a_footer, quoted, refuse, together
from scara_iso.tables.layout import HEAD, Layout, find_layout
from scara_iso.tables.names import Kind, pose_in
from scara_iso.tables.poses import PosePart, merge
from scara_iso.tables.preamble import form_rows, read_statements
from scara_iso.tables.statements import is_of_axes
from scara_iso.tables.subjects import topic_of
from scara_iso.tables.text import Row
from scara_iso.tables.workbook import Sheet, read_sheets

NO_HEADER = "begin with a header row that names its columns, such as 'cycle,X,Y,Z,theta'"


def read_workbook(data: bytes, name: str, options: ReadOptions) -> Run:
    """Return the run of a workbook: of its only table, or of the sheets that name a pose.

    Sheets without a table state what holds for all: a cover sheet.
    """
    sheets = list(read_sheets(data, name))
    asked = [one for one in sheets if options.sheet in (None, one.name)]
    seen = [one for one in asked if options.sheet or not one.hidden]
    notes = [f"sheet {quoted(one.name)} is hidden: not used" for one in asked if one not in seen]
    found = {one.name: one for one in seen if _holds_table(one, name, options)}
    cover, unused = _cover([one for one in sheets if one.name not in found and not one.hidden])
    notes += unused
    if len(found) == 1:
        (sheet,) = found.values()
        run = _read_sheet(sheet, name, options, cover)
        return with_notes(run, notes)
    parts, left = _poses_of(found, name, options, cover)
    if len(parts) < 2:
        suggested = suggest_columns([_head(_lines(one)) for one in asked])
        raise _which_sheet(name, [one.name for one in sheets], list(found), options, suggested)
    notes += [f"sheet {quoted(title)} names no pose: not used" for title in left]
    return merge(parts, name, notes=notes)


def with_notes(run: Run, notes: Iterable[str]) -> Run:
    """Return a run that says more of what was met and not used."""
    return replace(run, origin=replace(run.origin, notes=(*run.origin.notes, *notes)))


def _holds_table(sheet: Sheet, name: str, options: ReadOptions) -> bool:
    rows = _lines(sheet)
    return _find_table(rows, options.columns) is not None or bool(_blocks(rows, name, options))


def _lines(sheet: Sheet) -> list[Line]:
    return list(enumerate(sheet.rows, 1))


def _cover(sheets: Sequence[Sheet]) -> tuple[list[Row], list[str]]:
    """Return the rows of other sheets that state something, and what to say of the others.

    Their line is 0: they stand above every table. A mean or the like is of a calculation.
    """
    stated: list[Row] = []
    notes: list[str] = []
    for sheet in sheets:
        rows = [replace(row, line=0, end=0) for row in form_rows(_lines(sheet)) if _states(row)]
        stated += rows
        if not rows and any(cell != "" for cells in sheet.rows for cell in cells):
            notes.append(f"sheet {quoted(sheet.name)} holds no table: not used")
    return stated, notes


def _states(row: Row) -> bool:
    stated = read_statements(row)
    matters = any(topic_of(one.written) for one in stated)
    return matters or (bool(stated) and not names_a_footer(row.text))


def _above(cover: Sequence[Row], head: Sequence[Row]) -> Iterator[Row]:
    """Yield the rows of a cover that state what a table's own head, or a row before, does not.

    What is of the axes is stated twice, and must be the same.
    """
    known = {one.key for row in head for one in read_statements(row)}
    for row in cover:
        keys = {one.key for one in read_statements(row)}
        if any(map(is_of_axes, keys)) or not keys <= known:
            yield row
        known |= keys


def read_blocks(
    blocks: Sequence[Block],
    name: str,
    options: ReadOptions,
    how: str,
    sheet: Sheet | None = None,
    cover: Sequence[Row] = (),
    *,
    text: Delimited | None = None,
) -> Run:
    """Return the run of blocks that each stand under their pose's name, or every fault of all."""
    parts, errors = [], []
    for block in blocks:
        try:
            called = f"{name}, block of {block.pose}"
            run = read_rows(block.rows, called, options, how, sheet, cover, text=text)
            parts.append(PosePart(run, f"block of {block.pose}", "", block.place, block.pose))
        except DataError as error:
            errors.append(error)
    if errors:
        raise together(errors, name)
    return merge(parts, name)


def _poses_of(
    sheets: dict[str, Sheet], name: str, options: ReadOptions, cover: Sequence[Row]
) -> tuple[list[PosePart], list[str]]:
    """Return the sheets that name a pose, and those that do not; raises the faults of the first."""
    parts: list[PosePart] = []
    left: list[str] = []
    errors: list[DataError] = []
    for title, sheet in sheets.items():
        try:
            run = _read_sheet(sheet, f"{name}, sheet {quoted(title)}", options, cover)
        except DataError as error:
            if pose_in(title):
                errors.append(error)
            else:
                left.append(title)
            continue
        if pose_in(title) or run.pose is not None or "pose" in run.metadata:
            parts.append(PosePart(run, f"sheet {quoted(title)}", title, "the sheet's name"))
        else:
            left.append(title)
    if errors and len(errors) + len(parts) > 1:
        raise together(errors, name)
    return parts, left


def _read_sheet(sheet: Sheet, name: str, options: ReadOptions, cover: Sequence[Row]) -> Run:
    how, rows = f"workbook, sheet {quoted(sheet.name)}", _lines(sheet)
    if blocks := _blocks(rows, name, options):
        return read_blocks(blocks, name, options, how, sheet, cover)
    return read_rows(rows, name, options, how, sheet, cover)


def _blocks(rows: Sequence[Line], name: str, options: ReadOptions) -> list[Block]:
    return [] if options.columns is not None else find_blocks(rows, name) or find_wide(rows, name)


def read_rows(
    rows: Sequence[Line],
    name: str,
    options: ReadOptions,
    how: str,
    sheet: Sheet | None = None,
    cover: Sequence[Row] = (),
    *,
    text: Delimited | None = None,
) -> Run:
    """Return the run of one table; ``how`` says how the file was split into rows of cells.

    ``sheet`` is the one of a workbook that holds them, ``cover`` what its other sheets state, and
    ``text`` the one that they were split from.
    """
    table = _find_table(rows, options.columns)
    if table is None:
        raise refuse(name, "no header that names an axis X, Y, Z or theta", remedy=NO_HEADER)
    head, layout = table
    faults = Faults(name, sheet=sheet.name if sheet else "")
    if options.columns is not None:
        check_header(head, layout, faults)
    most = sum(len(cells) for _, cells in rows) // max(layout.width, 1) + 1
    columns = Columns(layout, options.decimal, faults, most)
    body = Body(layout, faults)
    below = ((line, cells) for line, cells in rows if line >= layout.data_line)
    columns.add(list(body.sort(below)))
    if sheet is not None:
        _check_shown(sheet, columns, faults)
    return finish([*_above(cover, head), *head], columns, body, options, how, text)


def _check_shown(sheet: Sheet, columns: Columns, faults: Faults) -> None:
    """Refuse readings that a sheet does not show: of a filter, or of nobody's choice."""
    for line in columns.all_lines().tolist() if sheet.hidden_rows else ():
        if line in sheet.hidden_rows:
            what = f"row {line} is hidden, by hand or by a filter, and holds readings"
            remedy = "show all rows, and delete those that do not count (`allow_gaps=`)"
            faults.add(what, line, remedy=remedy)
    for column in columns.layout.of(Kind.AXIS):
        if column.position + 1 in sheet.hidden_columns:
            what = f"the column of {column.name} is hidden"
            remedy = "show the column if its readings count, else delete it"
            faults.add(what, columns.layout.header_line, column.position + 1, remedy=remedy)


def finish(
    head: list[Row],
    columns: Columns,
    body: Body,
    options: ReadOptions,
    how: str,
    text: Delimited | None,
) -> Run:
    """Return the run of the columns, after the checks that a ``text`` needs."""
    if text is None:
        return assemble(head, columns, body, options, how)
    text.check_end(head, columns, body, options.resolution)
    run = assemble(head, columns, body, options, f"{how}, {text.said(columns, options.decimal)}")
    if options.decimal is None:
        text.check_numbers(run, columns)
    return run


def _find_table(
    rows: Sequence[Line], names: Sequence[str] | None
) -> tuple[list[Row], Layout] | None:
    head = _head(rows)
    layout = place_columns(head, names) if names else find_layout(head)
    return (head, layout) if layout else None


def _head(rows: Sequence[Line]) -> list[Row]:
    return form_rows(rows[:HEAD])


def _which_sheet(
    name: str, names: list[str], found: list[str], options: ReadOptions, suggested: str
) -> DataError:
    asked = options.sheet
    if asked is not None and asked not in names:
        return refuse(
            name,
            f"no sheet {quoted(asked)}; there are {listed(map(quoted, names))}",
            remedy="name one of them with `sheet=`",
        )
    if not found:
        return refuse(
            name,
            "no sheet with a header that names an axis X, Y, Z or theta",
            remedy=suggested or NO_HEADER,
        )
    return refuse(
        name,
        f"sheets {listed(map(quoted, found))} hold a table each",
        remedy=f"say which, for example `sheet={quoted(found[0])}`, or name the sheets of one "
        "test by their poses: P1, P2",
    )
