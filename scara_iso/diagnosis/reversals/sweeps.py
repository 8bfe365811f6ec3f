"""A sweep of measured reversals: one row each, at several inertias, gaps or torques."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.effects import Sweep
from scara_iso.run import FloatArray
from scara_iso.tables import (
    BLANKS,
    OLD_WORKBOOK,
    WORKBOOK,
    Cell,
    Delimiter,
    Faults,
    Mark,
    Source,
    clean,
    decode_text,
    is_comment,
    listed,
    parse_cell,
    quoted,
    read_bytes,
    refuse,
    split_head,
    split_lines,
    stated_delimiter,
)

_NEEDED = ("Im", "IL", "arcmin", "deviation_rad")
_OPTIONAL = ("ratio", "torque_Nm", "u_rad")
_KNOWN = {name.lower(): name for name in (*_NEEDED, *_OPTIONAL)}
_POSITIVE = {"Im", "IL", "arcmin", "ratio", "u_rad"}
_SMALLEST = 1e-30
_MOST_ROWS = 100_000
_WHAT = "a sweep of reversals"
_REMEDY = f"give the columns {', '.join(_NEEDED)} in kg m2, arcmin and rad"

_Rows = list[tuple[int, Sequence[Cell]]]


@dataclass(frozen=True, eq=False, slots=True)
class MeasuredSweep:
    """Reversals and the load deviations measured at them, in rad, shape (m,)."""

    sweep: Sweep
    deviation: FloatArray
    """With eq. 16's sign: not positive."""
    uncertainty: FloatArray | None
    """Standard uncertainties in rad, None where not given."""
    notes: tuple[str, ...] = ()


def read_sweep(source: Source) -> MeasuredSweep:
    """Return the sweep of a table with the columns Im, IL, arcmin and deviation_rad.

    Optional columns are ratio, torque_Nm and u_rad; others are left out. Text or .xlsx, in the
    spellings that `tables.read_table` takes; ``#`` begins a comment line. Raises `NoInputError`
    where it cannot be read, and `DataError` with every fault and its line.
    """
    data, name = read_bytes(source)
    found = _of_workbook(data, name) if data.startswith(WORKBOOK) else _of_text(data, name)
    rows = [(line, cells) for line, cells in found if _is_row(cells)]
    if not 2 <= len(rows) <= _MOST_ROWS:
        raise refuse(name, "a header and at least one row are needed", remedy=_REMEDY)
    faults = Faults(name, _WHAT)
    columns = _columns(rows, faults)
    faults.check()
    deviation = columns["deviation_rad"]
    sizes = bool(np.all(deviation >= 0))
    return MeasuredSweep(
        Sweep(
            I_m=columns["Im"],
            I_L=columns["IL"],
            gap=np.radians(columns["arcmin"] / 60),
            torque=columns.get("torque_Nm"),
            ratio=columns.get("ratio"),
        ),
        -deviation if sizes else deviation,
        columns.get("u_rad"),
        ("deviations are taken as sizes: eq. 16's sign is negative",) if sizes else (),
    )


def _of_text(data: bytes, name: str) -> _Rows:
    if data.startswith(OLD_WORKBOOK):
        raise refuse(name, "an old .xls or a protected workbook", remedy="save it as .xlsx or CSV")
    text, _ = decode_text(data, name)
    lines = list(enumerate(text.split("\n"), 1))
    stated = stated_delimiter(lines[0][1])
    lines = [(k, line) for k, line in lines[bool(stated) :] if _is_row([line])]
    if not lines:
        return []
    header = lines[0][1]
    named = {d: _known_names(split_head([header], d)[0].cells) for d in Delimiter}
    delimiter = stated or max(named, key=lambda d: named[d])
    faults = Faults(name, _WHAT)
    rows: _Rows = []
    for k, line in lines:
        try:
            rows.append((k, split_lines([line], delimiter)[0]))
        except csv.Error as error:
            faults.add(f"{error}: {quoted(line)}", k, remedy="close or remove the quote")
    faults.check()
    return rows


def _of_workbook(data: bytes, name: str) -> _Rows:
    from scara_iso.tables import read_sheets  # noqa: PLC0415 - zip and XML for few

    found: dict[str, _Rows] = {}
    for title, cells in read_sheets(data, name):
        numbered: _Rows = [(k, row) for k, row in enumerate(cells, 1) if _is_row(row)]
        if numbered and _known_names(numbered[0][1]) >= len(_NEEDED):
            found[title] = numbered
    if len(found) != 1:
        which = f"sheets {listed(map(quoted, found))} hold" if found else "no sheet holds"
        raise refuse(name, f"{which} a sweep", remedy=_REMEDY if not found else "keep one of them")
    return next(iter(found.values()))


def _is_row(cells: Sequence[Cell]) -> bool:
    texts = [cell.strip(BLANKS) if isinstance(cell, str) else "0" for cell in cells]
    return any(texts) and not is_comment(texts[0])


def _names(header: Sequence[Cell]) -> list[str | None]:
    return [_KNOWN.get(clean(str(cell)).lower()) for cell in header]


def _known_names(header: Sequence[Cell]) -> int:
    return sum(name is not None for name in _names(header))


def _columns(rows: _Rows, faults: Faults) -> dict[str, FloatArray]:
    (header_line, header), *body = rows
    names = _names(header)
    for missing in (n for n in _NEEDED if n not in names):
        faults.add(f"column {missing} is missing", header_line, remedy=_REMEDY)
    for name in (n for n in _KNOWN.values() if names.count(n) > 1):
        faults.add(f"column {name} is there twice", header_line, remedy=_REMEDY)
    whole = [row for row in body if _is_whole(row, len(header), faults)]
    marks: dict[Mark, tuple[int, int, str]] = {}
    found = {
        name: np.array([_value(name, cells[k], (line, k + 1), marks, faults)
                        for line, cells in whole])
        for k, name in enumerate(names)
        if name
    }  # fmt: skip
    _check_marks(marks, faults)
    return found


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
    marks: dict[Mark, tuple[int, int, str]],
    faults: Faults,
) -> float:
    value = cell if isinstance(cell, float) else math.nan
    if isinstance(cell, str):
        number = parse_cell(cell)
        if number is not None and not number.unit:
            value = number.value
            marks.setdefault(number.mark, (*place, cell.strip(BLANKS)))
    if not math.isfinite(value):
        faults.add(f"{name}: {quoted(str(cell))} is not a number", *place, remedy=_REMEDY)
    elif name in _POSITIVE and value <= 0 and Mark.BOTH not in marks:
        faults.add(f"{name}: {value:g} is not positive", *place, remedy=_REMEDY)
    elif value and not _SMALLEST < abs(value) < 1 / _SMALLEST:
        faults.add(f"{name}: {value:g} is beyond any drive", *place, remedy=_REMEDY)
    return value


def _check_marks(marks: dict[Mark, tuple[int, int, str]], faults: Faults) -> None:
    """Refuse a comma that could be a decimal or a thousands mark."""
    comma = Mark.COMMA in marks or Mark.EITHER in marks
    if Mark.BOTH in marks or (comma and Mark.POINT in marks):
        said = "commas and points both occur"
    elif Mark.EITHER in marks and Mark.COMMA not in marks:
        said = "could have a decimal comma or group thousands"
    else:
        return
    for mark in marks.keys() - {Mark.NONE}:
        line, column, text = marks[mark]
        faults.add(
            f"{quoted(text)}: {said}", line, column, remedy="write decimal points, no groups"
        )
