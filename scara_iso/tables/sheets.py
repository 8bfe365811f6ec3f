"""Rows of cells to a run: a workbook, and tables of several poses on one sheet or in one file."""

from __future__ import annotations

from collections.abc import Sequence

from scara_iso.errors import DataError
from scara_iso.run import Run
from scara_iso.tables.assemble import ReadOptions, assemble
from scara_iso.tables.blocks import Block, Line, find_blocks
from scara_iso.tables.body import Body
from scara_iso.tables.columns import Cell, Columns
from scara_iso.tables.delimited import Delimited
from scara_iso.tables.faults import Faults, listed, quoted, refuse, together
from scara_iso.tables.layout import HEAD, Layout, find_layout
from scara_iso.tables.parts import PosePart, merge
from scara_iso.tables.pose_names import pose_in
from scara_iso.tables.positions import check_header, place_columns, suggest_columns
from scara_iso.tables.text import Row
from scara_iso.tables.wide import find_wide

NO_HEADER = "begin with a header row that names its columns, such as 'cycle,X,Y,Z,theta'"


def read_workbook(data: bytes, name: str, options: ReadOptions) -> Run:
    """Return the run of a workbook: of its only table, or of the sheets that name a pose."""
    from scara_iso.tables.workbook import read_sheets  # noqa: PLC0415 - zip and XML for few

    found: dict[str, Sequence[Line]] = {}
    names: list[str] = []
    heads: list[list[Row]] = []
    for title, cells in read_sheets(data, name):
        names.append(title)
        rows: Sequence[Line] = list(enumerate(cells, 1))
        if options.sheet in (None, title):
            heads.append(_head(rows))
            if _find_table(rows, options.columns) or _blocks(rows, name, options):
                found[title] = rows
    if len(found) == 1:
        ((title, rows),) = found.items()
        return _read_sheet(rows, name, options, title)
    parts, left = _poses_of(found, name, options)
    if len(parts) < 2:
        raise _which_sheet(name, names, list(found), options, suggest_columns(heads))
    unused = [f"sheet {quoted(title)} names no pose: not used" for title in left]
    return merge(parts, name, notes=unused)


def read_blocks(
    blocks: Sequence[Block],
    name: str,
    options: ReadOptions,
    how: str,
    sheet: str = "",
    *,
    text: Delimited | None = None,
) -> Run:
    """Return the run of blocks that each stand under their pose's name, or every fault of all."""
    parts, errors = [], []
    for block in blocks:
        try:
            called = f"{name}, block of {block.pose}"
            run = read_rows(block.rows, called, options, how, sheet, text=text)
            parts.append(PosePart(run, f"block of {block.pose}", "", block.place, block.pose))
        except DataError as error:
            errors.append(error)
    if errors:
        raise together(errors, name)
    return merge(parts, name)


def _poses_of(
    sheets: dict[str, Sequence[Line]], name: str, options: ReadOptions
) -> tuple[list[PosePart], list[str]]:
    """Return the sheets that name a pose, and those that do not; raises the faults of the first."""
    parts: list[PosePart] = []
    left: list[str] = []
    errors: list[DataError] = []
    for title, rows in sheets.items():
        try:
            run = _read_sheet(rows, f"{name}, sheet {quoted(title)}", options, title)
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


def _read_sheet(rows: Sequence[Line], name: str, options: ReadOptions, sheet: str) -> Run:
    how = f"workbook, sheet {quoted(sheet)}"
    if blocks := _blocks(rows, name, options):
        return read_blocks(blocks, name, options, how, sheet)
    return read_rows(rows, name, options, how, sheet)


def _blocks(rows: Sequence[Line], name: str, options: ReadOptions) -> list[Block]:
    return [] if options.columns is not None else find_blocks(rows, name) or find_wide(rows, name)


def read_rows(
    rows: Sequence[Line],
    name: str,
    options: ReadOptions,
    how: str,
    sheet: str = "",
    *,
    text: Delimited | None = None,
) -> Run:
    """Return the run of one table; ``how`` says how the file was split into rows of cells.

    ``sheet`` is the one of a workbook that holds them, ``text`` the one that they were split from.
    """
    table = _find_table(rows, options.columns)
    if table is None:
        raise refuse(name, "no header that names an axis X, Y, Z or theta", remedy=NO_HEADER)
    head, layout = table
    faults = Faults(name, sheet=sheet)
    if options.columns is not None:
        check_header(head, layout, faults)
    most = sum(len(cells) for _, cells in rows) // max(layout.width, 1) + 1
    columns = Columns(layout, options.decimal, faults, most)
    body = Body(layout, faults)
    below = ((line, cells) for line, cells in rows if line >= layout.data_line)
    columns.add(list(body.sort(below)))
    return finish(head, columns, body, options, how, text)


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
    texts = [(line, [_as_text(cell) for cell in cells]) for line, cells in rows[:HEAD]]
    return [Row(line, cells, _joined(cells), line) for line, cells in texts]


def _as_text(cell: Cell) -> str:
    return cell if isinstance(cell, str) else f"{cell:.15g}"


def _joined(cells: list[str]) -> str:
    return ", ".join(cell.strip() for cell in cells if cell.strip())


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
