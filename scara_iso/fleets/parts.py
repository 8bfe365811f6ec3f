"""The parts of a fleet's tables, and the tables of a part.

A part is a Parquet file, or a CSV file, with the columns robot and X, Y, Z or theta, and as they
are there test, pose, cycle and any other; or a table of one robot as `read_table` takes it, a
workbook too. The rows of several robots as text are split into one table for each, with the head
of the file above it, and `read_table` reads these too: what it refuses is refused here.
"""

import csv
import hashlib
import io
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias

from scara_iso.base.errors import DataError, NoInputError, ScaraIsoError
from scara_iso.base.files import is_folder, open_file
from scara_iso.fleets.database import Query, alone, workspace
from scara_iso.run import AXES, POSE_NAMES, Run
from scara_iso.tables import decode_text, is_axis, read_table

TableName = tuple[str, str]
"""Robot and test, in a part."""
DELIMITERS = (",", ";", "\t")
_COMMENT = "#"
_ENDINGS = (".csv", ".parquet", ".tsv", ".txt", ".xlsx")
_BLOCK = 1 << 20
_NO_NUMBER = ("n/a", "na", "n.a.", "nil", "none", "tbd", "unknown")
_NAMES = {name.lower(): name for name in AXES}
_IN_OTHER_WORDS = {
    **dict.fromkeys(("roboter", "robô"), "robot"),
    **dict.fromkeys(("prüfung", "versuch", "essai", "prova", "ensayo", "prueba"), "test"),
    **dict.fromkeys(("datum", "data", "fecha"), "date"),
}
_NAME_THE_ROBOT = "name the robot of each row"


Share: TypeAlias = tuple[int, int]
"""Which, from 0, of how many equal shares of what stands in an order; it may be empty."""
WHOLE: Share = (0, 1)


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
    """Of the robot, as it is stated, else that of the file; None of a serial number alone."""


def parts_of(source: Path) -> list[Path]:
    """Return the parts in a folder by name; `NoInputError` where there is none."""
    if not is_folder(source):
        raise NoInputError("is not a folder", where=str(source), remedy="name the folder of parts")
    found = sorted(
        path
        for path in source.iterdir()
        if path.suffix.lower() in _ENDINGS and not path.name.startswith((".", "~$"))
    )
    if not found:
        raise NoInputError(
            f"holds no {', '.join(_ENDINGS)}",
            where=str(source),
            remedy="put the parts into it; its subfolders are not searched",
        )
    return found


def folders_left(source: Path, manifest: str) -> Iterator[str]:
    """Yield the folders beside the parts that hold such files and no ``manifest`` of results."""
    for folder in sorted(path for path in source.iterdir() if is_folder(path)):
        count = sum(path.suffix.lower() in _ENDINGS for path in folder.iterdir())
        if count and not (folder / manifest).exists():
            yield f"folder {folder.name}, {count} table{'s' * (count > 1)} in it: not looked at"


def is_parquet(path: Path) -> bool:
    """Say whether a part is a Parquet file."""
    return path.suffix.lower() == ".parquet"


@dataclass(frozen=True, slots=True)
class PartFile:
    """A file, and what stood in it when it was looked at."""

    path: Path
    sha256: str
    size: int
    """Bytes."""


def part_at(path: Path) -> PartFile:
    """Return what stands in a file; raises as `open_file`."""
    found, size = hashlib.sha256(), 0
    with open_file(path) as file:
        while block := file.read(_BLOCK):
            found.update(block)
            size += len(block)
    return PartFile(path, found.hexdigest(), size)


def tables_in(
    path: Path,
    reading: ReadAs,
    only: Collection[TableName] | None = None,
    share: Share = WHOLE,
) -> Iterator[FleetTable]:
    """Yield the tables of a part, ``only`` some or a ``share``; one not readable with its error.

    Raises `DataError` where the part itself cannot be read.
    """
    tables = _tables(path, reading, only)
    names = [name for name in tables if only is None or name in only]
    yield from (tables[name]() for name in _taken(names, share))


def _taken(names: Sequence[TableName], share: Share) -> Sequence[TableName]:
    number, of = share
    first, end = (k * len(names) // of for k in (number, number + 1))
    return names[first:end]


def _tables(
    path: Path, reading: ReadAs, only: Collection[TableName] | None
) -> dict[TableName, Callable[[], FleetTable]]:
    if is_parquet(path):
        runs = _in_parquet(path, reading, only)
    elif path.suffix.lower() != ".xlsx" and (text := _text(path)) is not None:
        runs = _in_text(path, text, reading)
    else:
        table = _single(path, reading)
        return {(table.robot, table.test): lambda: table}
    return {name: partial(_named, path, name, run) for name, run in runs.items()}


def _single(path: Path, reading: ReadAs) -> FleetTable:
    try:
        run = read_table(path, **asdict(reading))
    except ScaraIsoError as error:
        return FleetTable(path.stem, "", error)
    head = {key.partition("[")[0]: text for key, text in run.metadata.items()}
    stated = head.get("serial_number", "")
    # no word or mark that stands for none
    is_number = stated.lower() not in _NO_NUMBER and any(map(str.isalnum, stated))
    number = stated if is_number else None
    name = head.get("robot") or (path.stem if number is None else None)
    return FleetTable(number or name or "", run.metadata.get("test", path.stem), run, name)


def _named(path: Path, name: TableName, run: Callable[[], Run]) -> FleetTable:
    """Return a table among others of a part, or why it cannot be read."""
    robot, test = name
    where = f"{path.name}: {robot} {test}".rstrip()
    try:
        read = run()
    except ScaraIsoError as error:
        error.where = where
        return FleetTable(robot, test, error, robot)
    return FleetTable(robot, test, replace(read, origin=replace(read.origin, source=where)), robot)


# ---- several robots as text


@dataclass(frozen=True, slots=True)
class _Text:
    """A text file whose header names a column ``robot``."""

    lines: Sequence[str]
    header: int
    """Index of the line that names the columns."""
    delimiter: str
    names: Sequence[str]


_Row: TypeAlias = tuple[int, Sequence[str]]
"""Line of the file, from 1, and cells."""


def _text(path: Path) -> _Text | None:
    """Return the text of several robots; None where no header names a column of that meaning."""
    with open_file(path) as file:
        lines = decode_text(file.read(), str(path))[0].split("\n")
    stated = (n for n, line in enumerate(lines) if line.strip() and not line.startswith(_COMMENT))
    header = next(stated, len(lines))
    for delimiter in DELIMITERS:
        cells = next(csv.reader(lines[header : header + 1], delimiter=delimiter), [])
        names = [name.strip() for name in cells]
        if "robot" in map(_meaning, names) and any(map(is_axis, names)):
            return _Text(lines, header, delimiter, names)
    return None


def _in_text(path: Path, text: _Text, reading: ReadAs) -> dict[TableName, Callable[[], Run]]:
    _refuse_twice([name for name in text.names if name], path)
    low = [_meaning(name) for name in text.names]
    robot, test = (low.index(key) if key in low else None for key in ("robot", "test"))
    rows: dict[TableName, list[_Row]] = {}
    for row in _rows(text, str(path)):
        name = tuple("" if at is None else row[1][at] for at in (robot, test))
        rows.setdefault((name[0], name[1]), []).append(row)
    if not rows:
        raise DataError("holds no rows", where=str(path), remedy="put readings below its header")
    _refuse_nameless(sum(len(own) for (name, _), own in rows.items() if not name), path)
    return {name: partial(_read, text, own, reading) for name, own in rows.items()}


def _meaning(column: str) -> str:
    """Return what a column is called in English, in small letters."""
    low = column.lower()
    return _IN_OTHER_WORDS.get(low, low)


def _rows(text: _Text, where: str) -> Iterator[_Row]:
    """Yield the rows below the header, each as long as it; a line of one cell is a comment."""
    below = (f"{line}\n" for line in islice(text.lines, text.header + 1, None))
    reader = csv.reader(below, delimiter=text.delimiter, strict=True)
    line, width = text.header + 2, len(text.names)
    try:
        for cells in reader:
            if len(cells) == width:
                yield line, [cell.strip() for cell in cells]
            elif len(cells) > 1 or any(cell.strip() and cell[0] != _COMMENT for cell in cells):
                raise DataError(
                    f"line {line}: {len(cells)} cells, and the header has {width}",
                    where=where,
                    remedy="mend that row; quotes around a cell keep it whole",
                )
            line = text.header + 2 + reader.line_num
    except csv.Error as error:
        raise DataError(
            f"line {line}: a quotation mark opens or closes in the wrong place: {error}",
            where=where,
            remedy="mend that row",
        ) from error


def _read(text: _Text, rows: Sequence[_Row], reading: ReadAs) -> Run:
    """Return rows read as a table of their own; a fault names line and column of the file."""
    every = [cells for _, cells in rows]
    kept = _kept(text.names, every)
    head = [*text.lines[: text.header], *_dated(text.names, every)]
    try:
        return _read_cells(head, text.names, every, text.delimiter, reading)
    except DataError as error:
        lines = [*range(1, len(head) + 1), text.header + 1, *(line for line, _ in rows)]
        error.faults = tuple(
            fault._replace(
                line=lines[fault.line - 1] if fault.line else None,
                column=kept[fault.column - 1] + 1 if fault.column else None,
            )
            for fault in error.faults
        )
        raise


def _kept(names: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int]:
    return [
        k
        for k, name in enumerate(names)
        if _meaning(name) not in ("robot", "test", "date") and any(cells[k] for cells in rows)
    ]


def _dated(names: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the statement of the first date, where a column has one."""
    columns = [k for k, name in enumerate(names) if _meaning(name) == "date"]
    dates = [cells[k] for k in columns for cells in rows if cells[k]]
    return [f"# date: {date}" for date in dates[:1]]


def _read_cells(
    head: Sequence[str],
    names: Sequence[str],
    rows: Sequence[Sequence[str]],
    delimiter: str,
    reading: ReadAs,
) -> Run:
    """Return the run of a head and of the columns of a table alone, as `read_table` reads it."""
    kept = _kept(names, rows)
    made = io.StringIO(newline="")
    made.writelines(f"{line}\n" for line in head)
    writer = csv.writer(made, delimiter=delimiter, lineterminator="\n")
    writer.writerows([row[k] for k in kept] for row in (names, *rows))
    return read_table(made.getvalue().encode(), **asdict(reading))


# ---- Parquet


def columns_of(query: Query, path: Path) -> dict[str, str]:
    """Return the columns of a Parquet file with their SQL types; `DataError` for a name twice."""
    schema = query("SELECT name FROM parquet_schema(?)", alone(path)).fetchall()
    _refuse_twice([str(row[0]) for row in schema[1:]], path)
    found = query("DESCRIBE SELECT * FROM parquet(?)", alone(path)).fetchall()
    return {row[0]: row[1] for row in found}


def _in_parquet(
    path: Path, reading: ReadAs, only: Collection[TableName] | None
) -> dict[TableName, Callable[[], Run]]:
    frame = _parquet_rows(path, only)
    frame.columns = [_NAMES.get(str(name).lower(), str(name)) for name in frame.columns]
    if frame.empty:
        raise DataError("holds no rows", where=str(path), remedy="put readings below its header")
    if "robot" not in frame.columns:
        raise DataError("has no column robot", where=str(path), remedy=_NAME_THE_ROBOT)
    _refuse_nameless(int(frame["robot"].isna().sum()), path)
    frame["robot"] = frame["robot"].map(str)
    frame["test"] = _objects(frame["test"]).map(_text_of) if "test" in frame.columns else ""
    groups = frame.groupby(["robot", "test"], sort=False).indices
    return {name: partial(_of_frame, frame, rows, reading) for name, rows in groups.items()}


def _parquet_rows(path: Path, only: Collection[TableName] | None) -> Any:
    """Return the rows of a Parquet file as a pandas table, in their order; ``only`` some."""
    with workspace(path) as query:
        columns = columns_of(query, path)
        if only is None or "robot" not in columns:
            return query("FROM parquet(?)", alone(path)).df()
        test = "coalesce(test::VARCHAR, '')" if "test" in columns else "''"
        sql = (
            "SELECT * EXCLUDE (file_row_number) FROM read_parquet(?, file_row_number = true, "  # noqa: S608
            f"hive_partitioning = false) WHERE (robot::VARCHAR, {test}) "
            "IN (SELECT (unnest(?::VARCHAR[]), unnest(?::VARCHAR[]))) ORDER BY file_row_number"
        )
        robots, tests = zip(*only, strict=True)
        return query(sql, alone(path), list(robots), list(tests)).df()


def _of_frame(frame: Any, at: Any, reading: ReadAs) -> Run:
    """Return the run of some rows of typed columns; columns of text are read as in a text file."""
    rows, known = frame.iloc[at], {"robot", "test", "date", "approach", *POSE_NAMES}
    if any(rows[k].dtype.kind not in "iufb" and k.lower() not in known for k in rows.columns):
        names = list(rows.columns)
        cells = [list(map(_text_of, row)) for row in _objects(rows).itertuples(index=False)]
        return _read_cells(_dated(names, cells), names, cells, "\t", reading)
    rows = rows.drop(columns=["robot", "test"]).dropna(axis=1, how="all").reset_index(drop=True)
    metadata = {}
    if "date" in rows.columns:
        metadata = {"date": _text_of(rows.pop("date").dropna().iloc[0])}
    return Run.from_frame(rows, unit=reading.unit, resolution=reading.resolution, metadata=metadata)


def _objects(frame: Any) -> Any:
    """Return cells of any kind, NaN where one is missing: pandas' NA is not to be compared."""
    return frame.astype(object).where(frame.notna())


def _text_of(cell: object) -> str:
    return "" if cell is None or cell != cell else str(cell)  # noqa: PLR0124 - NaN


def _refuse_twice(names: Sequence[str], path: Path) -> None:
    """Raise `DataError` for columns of one name: DuckDB would read them under names of its own."""
    low = [name.lower() for name in names]
    twice = [name for name in dict.fromkeys(low) if low.count(name) > 1]
    if twice:
        raise DataError(
            f"has several columns {', '.join(twice)}", where=str(path), remedy="rename them"
        )


def _refuse_nameless(count: int, path: Path) -> None:
    if count:
        raise DataError(f"{count} rows name no robot", where=str(path), remedy=_NAME_THE_ROBOT)
