"""From a source to a `Run`: the steps in their order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from scara_iso.base.errors import DataError, UsageError
from scara_iso.run import Run
from scara_iso.tables.assemble import ReadOptions
from scara_iso.tables.blocks import (
    ONE_A_ROW,
    Block,
    Line,
    check_header,
    column_names,
    count_fitting,
    find_blocks,
    find_labelled,
    find_wide,
    has_blocks,
    place_columns,
    suggest_columns,
)
from scara_iso.tables.body import Body, delimited, refuse_other_marks, split_each
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults, quoted, refuse
from scara_iso.tables.layout import COLUMNS, HEAD, Layout, find_layout, runs_across
from scara_iso.tables.preamble import MACHINE_UNIT, find_machine
from scara_iso.tables.sheets import NO_HEADER, finish, read_blocks, read_rows, read_workbook
from scara_iso.tables.text import (
    LINE_LIMIT,
    OLD_WORKBOOK,
    TEXT_HEAD,
    WORKBOOK,
    Delimiter,
    Row,
    Source,
    called_text,
    decode,
    in_pieces,
    plain_text,
    read_bytes,
    separator_of,
    split_columns,
    split_head,
    stated_delimiter,
    taken_from,
)

_SHOWN = 20
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
    data, name = read_bytes(source)
    if not data.strip():
        raise refuse(name, "the file is empty", remedy=NO_HEADER)
    if data.startswith(WORKBOOK):
        return read_workbook(data, name, options)
    if data.startswith(OLD_WORKBOOK):
        raise refuse(name, "an old .xls or a protected workbook", remedy="save it as .xlsx or CSV")
    if sheet is not None:
        raise refuse(name, "`sheet=` is for workbooks, this is text", remedy="leave `sheet=` out")
    ended = bool(set(data[-2:]) & set(b"\r\n\x1a"))  # of two bytes: UTF-16
    with called_text(data[:TEXT_HEAD], name):
        text, encoding = decode(data, name)
        del data  # it may be large
        text = plain_text(text, name)
        pieces = in_pieces(text)
        del text
        return _read_text(pieces, encoding, ended, name, options)


def _read_text(
    pieces: list[str], encoding: str, ended: bool, name: str, options: ReadOptions
) -> Run:
    faults = Faults(name)
    head = pieces[0].split("\n")[:HEAD]
    _check_length(1, head, faults)
    faults.check()
    tables = _tables(head)
    wide_row = _leave_out_wide(tables)
    understood = _understand(tables, options.columns)
    sure = options.columns is not None or (understood is not None and understood[2].sure)
    if wide_row and not (understood and understood[2].sure):
        what = f"line {wide_row.line} has {len(wide_row.cells)} fields, more than {COLUMNS}"
        raise refuse(name, what, remedy=_TOO_WIDE)
    if wide := None if sure else _wide(pieces, tables, name):
        delimiter, blocks = wide
        how = f"{delimiter.value}, {encoding}"
        return read_blocks(blocks, name, options, how, text=delimited(pieces, delimiter, ended))
    if understood is None:
        return _of_labels(_lines(pieces), name, options, encoding)
    delimiter, rows, layout = understood
    parted = delimited(pieces, delimiter, ended)
    how = f"{delimiter.value}, {encoding}"
    if not layout.sure and (across := runs_across(rows)):
        raise refuse(name, f"line {across.line} names runs side by side", remedy=ONE_A_ROW)
    if options.columns is not None:
        check_header(rows, layout, faults)
    elif has_blocks(rows) and (blocks := find_blocks(_split_all(pieces, delimiter, name), name)):
        return read_blocks(blocks, name, options, how, text=parted)
    columns = Columns(layout, options.decimal, faults, parted.most_rows(layout.width))
    body = Body(layout, faults)
    for first, lines in taken_from(pieces):
        skip = max(0, layout.data_line - first)
        _take(first + skip, lines[skip:], delimiter, columns, body)
    return finish(rows, columns, body, options, how, parted)


def _tables(head: list[str]) -> dict[Delimiter, list[Row]]:
    """Return the rows of a file's head by each delimiter that there can be."""
    stated = stated_delimiter(head[0])
    lines = ["", *head[1:]] if stated else head
    return {
        delimiter: split_head(lines, delimiter) for delimiter in ([stated] if stated else Delimiter)
    }


def _leave_out_wide(tables: dict[Delimiter, list[Row]]) -> Row | None:
    """Take out each delimiter under which a row has too many fields; return such a row."""
    too_wide = {d: row for d, rows in tables.items() for row in rows if len(row.cells) > COLUMNS}
    for delimiter in too_wide:
        del tables[delimiter]
    return next(iter(too_wide.values()), None)


def _wide(
    pieces: list[str], tables: Mapping[Delimiter, list[Row]], name: str
) -> tuple[Delimiter, list[Block]] | None:
    """Return what parts a table whose headings name poses, and its blocks; None for another."""
    for delimiter, rows in tables.items():
        if find_wide([(row.line, row.cells) for row in rows], name):
            return delimiter, find_wide(_split_all(pieces, delimiter, name), name)
    return None


def _of_labels(lines: list[str], name: str, options: ReadOptions, encoding: str) -> Run:
    """Return the run of a log that names its numbers, or say why the file is no table."""
    if options.columns is None and (rows := find_labelled(lines, name)):
        machine = find_machine(lines)
        if machine is not None and options.unit is None:
            options = replace(options, unit=MACHINE_UNIT)
        run = read_rows(rows, name, options, f"numbers with their names, {encoding}")
        used = {line for line, _ in rows} | {machine.line if machine else 0}
        left = [k for k, line in enumerate(lines, 1) if k not in used and line.strip()]
        notes = [f"line {k}: {quoted(lines[k - 1])} not used" for k in left[:_SHOWN]]
        notes = [*(machine.notes if machine else ()), *notes]
        origin = replace(run.origin, header_line=None, notes=(*run.origin.notes, *notes))
        return replace(run, origin=origin)
    raise _no_table([split_head(lines[:HEAD], d) for d in Delimiter], name, options.columns)


def _lines(pieces: list[str]) -> list[str]:
    return [line for piece in pieces for line in piece.split("\n")]


def _split_all(pieces: list[str], delimiter: Delimiter, name: str) -> list[Line]:
    faults = Faults(name)
    lines = _lines(pieces)
    _check_length(1, lines, faults)
    faults.check()
    rows: list[Line] = [(line, cells) for line, cells in split_each(1, lines, delimiter, faults)]
    faults.check()
    return rows


def _check_length(first: int, lines: list[str], faults: Faults) -> None:
    for line, text in enumerate(lines, first):
        if len(text) > LINE_LIMIT:
            what = f"a line of {len(text)} characters, more than {LINE_LIMIT}"
            faults.add(what, line, remedy="end each row with a line end, and leave texts out")


def _understand(
    tables: Mapping[Delimiter, list[Row]], names: Sequence[str] | None
) -> tuple[Delimiter, list[Row], Layout] | None:
    """Return the delimiter under which a header and a row below it name and hold most.

    With the columns' ``names`` it is the one under which most rows have as many fields.
    """
    best: tuple[tuple[bool, int], Delimiter, list[Row], Layout] | None = None
    for delimiter, rows in tables.items():
        layout = place_columns(rows, names) if names else find_layout(rows)
        score = (layout.sure, layout.known) if layout else (False, 0)
        score = (True, count_fitting(rows, names)) if names else score
        if layout and (best is None or score > best[0]):
            best = (score, delimiter, rows, layout)
    return best[1:] if best else None


def _no_table(tables: Sequence[Sequence[Row]], name: str, names: Sequence[str] | None) -> DataError:
    if any(map(runs_across, tables)):
        return refuse(name, "a column for each run", remedy=ONE_A_ROW)
    if name.lower().endswith(".toml"):
        remedy = "name the table of readings; a model goes to `model=`, where that is taken"
        return refuse(name, "a .toml file is no table of readings", remedy=remedy)
    what = f"no header that names an axis X, Y, Z or theta in the first {HEAD} lines"
    if names:
        what = f"no row of {len(names)} fields with numbers for the axes in the first {HEAD} lines"
    return refuse(name, what, remedy=suggest_columns(tables) or NO_HEADER)


def _take(first: int, lines: list[str], delimiter: Delimiter, columns: Columns, body: Body) -> None:
    if not lines:
        return
    if len(lines) * LINE_LIMIT < sum(map(len, lines)) or max(map(len, lines)) > LINE_LIMIT:
        _check_length(first, lines, columns.faults)
        return
    if body.plain:
        separator = separator_of(delimiter)
        if separator is not None and columns.add_block(lines, separator, first):
            body.count(len(lines))
            return
        cells = split_columns(lines, delimiter, columns.layout.width)
        if cells is not None and columns.add_clean(cells, first):
            body.count(len(lines))
            return
    columns.add(list(body.sort(split_each(first, lines, delimiter, columns.faults))))
