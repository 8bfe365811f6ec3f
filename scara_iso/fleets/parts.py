"""The parts of a fleet's tables, and the tables of a part.

A part is a Parquet file, or a CSV file, with the columns robot and X, Y, Z or theta, and as they
are there test, pose, cycle and any other; or a table of one robot as `read_table` takes it, a
workbook too.

Pieces of parts, so that the tables of one are shared among many processes.

The rows of several robots as text: what is stated above their header, and what stands below.

Decimal commas in the text of a part: read as `read_table` does, or refused where unsure.
"""

from __future__ import annotations

import csv
import hashlib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from scara_iso.base.errors import DataError, NoInputError, ScaraIsoError
from scara_iso.base.files import is_folder, open_file
from scara_iso.base.quantities import parse_number, parse_unit
from scara_iso.fleets.database import Query, alone, fetched, workspace
from scara_iso.run import AXES, POSE_NAMES, Run, make_frame
from scara_iso.tables import (
    WHICH_MARK,
    Mark,
    are_mixed,
    are_undecided,
    decode_text,
    may_be_grouped,
    parse_cell,
    read_table,
)

One = TypeVar("One")


@dataclass(frozen=True, slots=True)
class Share:
    """One of so many equal shares of what stands in an order, counted from 0."""

    number: int
    of: int

    def take(self, several: Sequence[One]) -> Sequence[One]:
        """Return this share of it, which may be nothing."""
        first, end = (k * len(several) // self.of for k in (self.number, self.number + 1))
        return several[first:end]


WHOLE = Share(0, 1)


@dataclass(frozen=True, slots=True)
class Piece:
    """A share of the tables of a part."""

    path: str
    share: Share = WHOLE


DELIMITERS = (",", ";", "\t")
_STATEMENT = re.compile(r"#\s*([A-Za-z][\w ]*?)\s*:\s*(.*)")
_COMMENT = "#"


@dataclass(frozen=True, eq=False, slots=True)
class TextRows:
    """A text file with a header that names the robot of each row."""

    statements: Mapping[str, str]
    """What ``# key: value`` above the header says."""
    names: Sequence[str]
    delimiter: str
    columns: Sequence[Sequence[str | None]]
    """By name, the cells below the header; None for an empty one."""


def text_rows(path: Path) -> TextRows | None:
    """Return the rows of a text file, None where its header names no column ``robot``.

    A line of one cell below the header that begins with ``#`` is a comment. Raises `NoInputError`
    and `DataError`, of a row that is not as long as the header with its line.
    """
    with open_file(path) as file:
        data = file.read()
    lines = decode_text(data, str(path))[0].split("\n")
    statements, above = _above(lines)
    header = "".join(lines[above : above + 1])
    for delimiter in DELIMITERS:
        names = [name.strip() for name in next(csv.reader([header], delimiter=delimiter), [])]
        if "robot" in map(str.lower, names):
            rows = list(_rows(lines, above + 1, delimiter, len(names), str(path)))
            columns = list(zip(*rows, strict=True)) or [()] * len(names)
            return TextRows(statements, names, delimiter, columns)
    return None


def _above(lines: Sequence[str]) -> tuple[dict[str, str], int]:
    """Return what is stated above the header, and how many lines that are."""
    found: dict[str, str] = {}
    for number, line in enumerate(lines):
        stated = _STATEMENT.match(line)
        if stated:
            found[stated[1].lower().replace(" ", "_")] = stated[2].strip()
        elif line.strip() and not line.startswith(_COMMENT):
            return found, number
    return found, len(lines)


def _rows(
    lines: Sequence[str], above: int, delimiter: str, width: int, where: str
) -> Iterator[list[str | None]]:
    """Yield the rows below the header, each of its ``width``."""
    below = (f"{line}\n" for line in islice(lines, above, None))
    reader, line = csv.reader(below, delimiter=delimiter, strict=True), above + 1
    try:
        for row in reader:
            if len(row) == width:
                yield [cell.strip() or None for cell in row]
            elif row and not (len(row) == 1 and _is_no_row(row[0])):
                raise DataError(
                    f"line {line}: {len(row)} cells, and the header has {width}",
                    where=where,
                    remedy="mend that row; quotes around a cell keep it whole",
                )
            line = above + reader.line_num + 1
    except csv.Error as error:
        raise DataError(
            f"line {line}: a quotation mark opens or closes in the wrong place: {error}",
            where=where,
            remedy="mend that row",
        ) from error


def _is_no_row(text: str) -> bool:
    return not text.strip() or text.startswith(_COMMENT)


def settle_marks(frame: Any, names: Iterable[str], decimal: str | None, where: str) -> None:
    """Put decimal points into the numbers of text columns of a pandas table.

    ``decimal`` says which mark is the decimal one. Raises `DataError` where nothing does and the
    commas of the whole part may group thousands, or stand beside points.
    """
    text = {name: list(map(str, frame[name])) for name in names}
    found = {
        name: [parse_cell(cell, decimal) for cell in cells]
        for name, cells in text.items()
        if decimal is not None or any("," in cell for cell in cells)
    }
    if decimal is None:
        _refuse_unsure(_marks(text), where)
    for name, numbers in found.items():
        frame[name] = [
            cell if number is None or number.unit else repr(number.value)
            for cell, number in zip(text[name], numbers, strict=True)
        ]


def _marks(text: Mapping[str, Sequence[str]]) -> dict[Mark, str]:
    """Return the decimal marks that occur, each with a cell that has it."""
    marks: dict[Mark, str] = {}
    for cell in (cell for cells in text.values() for cell in cells if "," in cell or "." in cell):
        number = parse_cell(cell)
        if number is not None and not number.unit:
            marks.setdefault(number.mark, cell)
    return marks


def _refuse_unsure(marks: Mapping[Mark, str], where: str) -> None:
    if are_mixed(marks):
        one = next(marks[mark] for mark in (Mark.BOTH, Mark.COMMA, Mark.EITHER) if mark in marks)
        raise DataError(f"{one!r}: commas and points both occur", where=where, remedy=WHICH_MARK)
    if are_undecided(marks):
        raise DataError(
            f"{marks[Mark.EITHER]!r} could have a decimal comma or group thousands",
            where=where,
            remedy=WHICH_MARK,
        )


def refuse_groups(frame: Any, axes: Mapping[str, Mapping[str, Any]], where: str) -> None:
    """Raise `DataError` for 1.512 um between semicolons, which may be 1512: as `read_table`."""
    for name, stated in axes.items():
        if parse_unit(stated["unit"]).name == "um" and stated["resolution"] is None:
            numbers = [number.value for cell in frame[name] if (number := parse_cell(str(cell)))]
            if numbers and may_be_grouped(np.abs(np.array(numbers))):
                raise DataError(
                    f"{name}: {frame[name].iloc[0]} um could have a decimal point or group "
                    "thousands",
                    where=where,
                    remedy=f"{WHICH_MARK}; or state the dial's resolution",
                )


_ENDINGS = (".csv", ".parquet", ".tsv", ".txt", ".xlsx")
_BLOCK = 1 << 20
_NO_NUMBER = ("n/a", "na", "n.a.", "nil", "none", "tbd", "unknown")
_NAMES = {name.lower(): name for name in AXES}

TableName = tuple[str, str]
"""Robot and test, in a part."""


@dataclass(frozen=True, slots=True)
class ReadAs:
    """How the tables are to be read, where they do not state it."""

    unit: str | None = None
    resolution: float | None = None
    decimal: str | None = None
    """The decimal mark, where the numbers can be read two ways."""


@dataclass(frozen=True, eq=False, slots=True)
class FleetTable:
    """One table: whose it is, and its readings, or why there are none."""

    robot: str
    """Its serial number, else its name, else that of the file."""
    test: str
    run: Run | ScaraIsoError
    name: str | None = None
    """Of the robot, as it is stated."""


def parts_of(source: Path) -> list[Path]:
    """Return the parts in a folder by name; `NoInputError` where there is none."""
    if not is_folder(source):
        raise NoInputError("is no folder", where=str(source), remedy="name the folder of the parts")
    found = sorted(
        path
        for path in source.iterdir()
        if path.suffix.lower() in _ENDINGS and not path.name.startswith((".", "~$"))
    )
    if not found:
        raise NoInputError(
            f"holds no {', '.join(_ENDINGS)}",
            where=str(source),
            remedy="put the parts into it; what lies in a folder in it is not looked at",
        )
    return found


def digest(path: Path) -> str:
    """Return the SHA-256 of a file; raises as `open_file`."""
    found = hashlib.sha256()
    with open_file(path) as file:
        while block := file.read(_BLOCK):
            found.update(block)
    return found.hexdigest()


def tables_in(
    path: Path,
    reading: ReadAs,
    only: Collection[TableName] | None = None,
    share: Share = WHOLE,
) -> Iterator[FleetTable]:
    """Yield the tables of a part, ``only`` some or a ``share``; one not readable with its error.

    Raises `DataError` where the part itself cannot be read.
    """
    several = _several(path, only)
    if several is None:
        for table in (_single(path, reading) for path in share.take([path])):
            if only is None or (table.robot, table.test) in only:
                yield table
        return
    attributes = _settled(several, path, reading)
    tables = several.frame.groupby(_keys(several.frame), sort=False, dropna=False)
    mine = share.take(range(tables.ngroups))
    for number, (key, rows) in enumerate(tables):
        robot, test = (*("" if one != one else str(one) for one in key), "")[:2]  # noqa: PLR0124
        if number in mine and (only is None or (robot, test) in only):
            where = f"{path.name}: {robot} {test}".rstrip()
            yield FleetTable(robot, test, _run(rows, attributes, where), robot)


def columns_of(query: Query, path: Path) -> dict[str, str]:
    """Return the columns of a Parquet file with their SQL types; `DataError` for a name twice."""
    schema = query("SELECT name FROM parquet_schema(?)", alone(path))
    _refuse_twice([str(row[0]) for row in schema[1:]], path)
    return {row[0]: row[1] for row in query("DESCRIBE SELECT * FROM parquet(?)", alone(path))}


@dataclass(frozen=True, eq=False, slots=True)
class _Several:
    """The rows of several robots, and what is stated above them."""

    frame: Any
    statements: Mapping[str, str]
    grouped: bool
    """The numbers may have been grouped, between semicolons."""


def _several(path: Path, only: Collection[TableName] | None) -> _Several | None:
    """Return the rows of several robots, of ``only`` some if that is easy; None if of one robot."""
    if path.suffix.lower() == ".parquet":
        return _Several(_parquet_rows(path, only), {}, grouped=False)
    if path.suffix.lower() == ".xlsx":
        return None
    rows = text_rows(path)
    if rows is None:
        return None
    _refuse_twice(list(rows.names), path)
    cells = zip(rows.names, rows.columns, strict=True)
    columns = {name or f"column {k}": own for k, (name, own) in enumerate(cells, 1)}
    return _Several(make_frame(columns, {}), rows.statements, grouped=rows.delimiter == ";")


def _parquet_rows(path: Path, only: Collection[TableName] | None) -> Any:
    """Return the rows of a Parquet file as a pandas table, in their order."""
    with workspace(path) as query:
        columns = columns_of(query, path)
    if only is None or "robot" not in columns:
        return fetched("SELECT * FROM parquet(?)", [alone(path)], str(path))
    test = "coalesce(test::VARCHAR, '')" if "test" in columns else "''"
    sql = (
        "SELECT * EXCLUDE (file_row_number) FROM read_parquet(?, file_row_number = true, "  # noqa: S608
        f"hive_partitioning = false) WHERE (robot::VARCHAR, {test}) "
        "IN (SELECT (unnest(?::VARCHAR[]), unnest(?::VARCHAR[]))) "
        "ORDER BY file_row_number"
    )
    robots, tests = zip(*only, strict=True)
    return fetched(sql, [alone(path), list(robots), list(tests)], str(path))


def _refuse_twice(names: list[str], path: Path) -> None:
    """Raise `DataError` for columns of one name: DuckDB would read them under names of its own."""
    low = [name.lower() for name in names]
    twice = [name for name in dict.fromkeys(low) if low.count(name) > 1]
    if twice:
        raise DataError(
            f"has several columns {', '.join(twice)}", where=str(path), remedy="name each apart"
        )


def _single(path: Path, reading: ReadAs) -> FleetTable:
    try:
        run = read_table(
            path, unit=reading.unit, resolution=reading.resolution, decimal=reading.decimal
        )
    except ScaraIsoError as error:
        return FleetTable(path.stem, "", error)
    name = run.metadata.get("robot")
    number = run.metadata.get("serial_number", "")
    robot = (number if _is_number(number) else "") or name or path.stem
    return FleetTable(robot, run.metadata.get("test", path.stem), run, name)


def _is_number(stated: str) -> bool:
    """Say whether a serial number is one, and no word or mark that stands for none."""
    return stated.lower() not in _NO_NUMBER and any(map(str.isalnum, stated))


def _settled(several: _Several, path: Path, reading: ReadAs) -> dict[str, Any]:
    """Put names and decimal marks of the rows right; return the attributes of every table."""
    frame = several.frame
    if frame.empty:
        raise DataError("holds no rows", where=str(path), remedy="put readings below its header")
    frame.columns = [_NAMES.get(str(name).lower(), str(name)) for name in frame.columns]
    if "robot" not in frame.columns:
        raise DataError("has no column robot", where=str(path), remedy="name the robot of each row")
    nameless = int(frame["robot"].isna().sum())
    if nameless:
        raise DataError(
            f"{nameless} rows name no robot", where=str(path), remedy="name the robot of each row"
        )
    axes = _axes(frame, several.statements, reading, path)
    settle_marks(frame, _text_columns(frame), reading.decimal, str(path))
    if several.grouped and reading.decimal is None:
        refuse_groups(frame, axes, str(path))
    return {"axes": axes, "metadata": dict(several.statements)}


def _keys(frame: Any) -> list[str]:
    """Return the columns that tell tables apart."""
    return [name for name in ("robot", "test") if name in frame.columns]


def _text_columns(frame: Any) -> list[str]:
    """Return the columns of text that should hold numbers."""
    names = {"robot", "test", "date", "approach", *POSE_NAMES}
    return [
        name
        for name in frame.columns
        if frame[name].dtype.kind not in "iufb" and name.lower() not in names
    ]


def _axes(
    frame: Any, statements: Mapping[str, str], reading: ReadAs, path: Path
) -> dict[str, dict[str, Any]]:
    """Return unit and resolution of each axis, where they are stated."""
    found: dict[str, dict[str, Any]] = {}
    for name in (name for name in AXES if name in frame.columns):
        low = name.lower()
        unit = statements.get(f"unit_{low}", statements.get("unit", reading.unit))
        if unit is not None:
            own = statements.get(f"resolution_{low}", statements.get("resolution"))
            resolution = _resolution(own, path) if own else reading.resolution
            found[name] = {"unit": unit, "resolution": resolution}
    return found


def _resolution(stated: str, path: Path) -> float:
    found = parse_number(stated)
    if found is None:
        raise DataError(
            f"states a resolution {stated[:30]!r}, which is no number",
            where=str(path),
            remedy="write '# resolution: 0.001', in the unit of its readings",
        )
    return found


def _run(rows: Any, attributes: dict[str, Any], where: str) -> Run | ScaraIsoError:
    if "date" in rows.columns:
        attributes = _dated(rows.pop("date"), attributes)
    rows = rows.drop(columns=_keys(rows)).dropna(axis=1, how="all").reset_index(drop=True)
    for name in rows.columns:
        if rows[name].dtype.kind not in "iuf" and str(name).lower() not in POSE_NAMES:
            rows[name] = _numbers(rows[name])
    rows.attrs = attributes
    try:
        run = Run.from_frame(rows)
    except ScaraIsoError as error:
        error.where = where
        return error
    return replace(run, origin=replace(run.origin, source=where))


def _dated(dates: Any, attributes: dict[str, Any]) -> dict[str, Any]:
    """Return the attributes of a table with the first of its dates."""
    stated = dates.dropna()
    if stated.empty:
        return attributes
    return {**attributes, "metadata": {**attributes["metadata"], "date": str(stated.iloc[0])}}


def _numbers(column: Any) -> Any:
    """Return a column of text as numbers where each cell is one, else as it is: it is refused."""
    found = [parse_number(str(cell)) for cell in column]
    return column if None in found else found
