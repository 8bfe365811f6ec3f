"""DuckDB, which reads and writes tables of many robots: the one place that knows it."""

from __future__ import annotations

import glob
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from scara_iso.base.disk import write_file
from scara_iso.base.errors import DataError, ScaraIsoError, UsageError, WriteError, with_extra

Query = Callable[..., list[Any]]
"""SQL and its parameters to rows."""

_ROOM = "make room, or name another folder by TMPDIR"
_FEWER = "split the part in two, or a folder of many parts into several fleets"
_DISK_IS_FULL = ("'max_temp_directory_size'", "No space left on device")
"""In what DuckDB says: it found no more room beforehand, or when it wrote."""
_MEMORY = "1GB"

_NOTHING_FROM_ELSEWHERE = (
    "autoinstall_known_extensions",
    "autoload_known_extensions",
    "allow_persistent_secrets",
    "python_enable_replacements",
)
"""Neither a server's code, nor the user's folder of it, nor a variable for a table."""
_ROWS = (
    "CREATE TEMP MACRO parquet(path) AS TABLE FROM read_parquet(path, hive_partitioning = false)"
)
"""The rows of a file that `alone` names: a folder ``X=7`` above it is no column."""

Columns = Mapping[str, tuple[str, Sequence[object]]]
"""By name, each with its SQL type."""


def connect(threads: int = 1, memory: str = _MEMORY) -> Any:
    """Return a connection in memory, of one thread; `UsageError` without the package for it."""
    try:
        import duckdb  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise UsageError("tables of a fleet need DuckDB", remedy=with_extra("fleet")) from error
    connection = duckdb.connect()
    connection.execute(_ROWS)
    for setting in _NOTHING_FROM_ELSEWHERE:
        connection.execute(f"SET {setting} = false")
    connection.execute(f"SET threads = {threads}")  # one where processes share the cores
    connection.execute(f"SET memory_limit = '{memory}'")  # what is more goes to the disk
    connection.execute("SET enable_progress_bar = false")  # it would stand in what is printed
    own = f"scara-iso-{os.getpid()}-{id(connection)}"  # a folder of two would be lost
    connection.execute("SET temp_directory = ?", [str(Path(tempfile.gettempdir(), own))])
    return connection


def alone(path: Path) -> str:
    """Return a path as DuckDB takes it for this file and no other: a ``*`` of it is a letter."""
    return glob.escape(str(path))


def fetched(sql: str, parameters: Sequence[object], where: str) -> Any:
    """Return what a query gives as a pandas table; `DataError` where a file cannot be read."""
    connection = connect()
    import duckdb  # noqa: PLC0415 - it is there

    try:
        return connection.execute(sql, list(parameters)).df()
    except duckdb.Error as error:
        raise _said(error, "cannot be read", where, "mend the file") from error
    finally:
        connection.close()


@contextmanager
def results_in(folder: Path, memory: str = _MEMORY) -> Iterator[Query]:
    """Yield how ``fleet`` is queried, which is all Parquet files of a folder: the SQL to its rows.

    Tables that state a robot's name alone are of the one ``robot`` that has this name and a serial
    number; ``as_read`` is what stands in the files, and the table ``named`` has the names of each
    serial number. What takes more ``memory`` goes to the disk. Every query has no rows where there
    are no files.
    """
    said = "the results cannot be read"
    remedy = "remove the damaged file; the same command makes it anew"
    with _session(connect(memory=memory), said, folder, remedy) as query:
        if any(folder.glob("*.parquet")):
            quoted = f"{alone(folder)}/*.parquet".replace("'", "''")
            query(f"CREATE VIEW stated AS FROM parquet('{quoted}')")
            query(
                "CREATE TEMP TABLE named AS SELECT DISTINCT name, robot AS serial FROM stated "
                "WHERE name <> robot AND error IS NULL"
            )
            query(
                "CREATE VIEW fleet AS SELECT stated.* REPLACE (coalesce(serial, robot) AS robot), "
                "robot AS as_read FROM stated LEFT JOIN (SELECT name, min(serial) AS serial "
                "FROM named GROUP BY name HAVING count(*) = 1) AS own "
                "ON stated.robot = own.name AND stated.name = own.name"
            )
            yield query
        else:
            yield lambda *_: []


def _brief(error: Exception) -> str:
    """Return what is wrong in one line."""
    return " ".join(str(error).split())[:200]


@contextmanager
def workspace(where: Path, threads: int = 1) -> Iterator[Query]:
    """Yield how tables are made and queried that end with it; `DataError` naming ``where``."""
    with _session(connect(threads), "cannot be read", where, "mend the file") as query:
        query("SET preserve_insertion_order = false")
        yield query


@contextmanager
def _session(connection: Any, said: str, where: Path, remedy: str) -> Iterator[Query]:
    """Yield how a connection is queried, and close it; `DataError` or `WriteError` if it fails."""
    import duckdb  # noqa: PLC0415 - it is there

    try:
        yield lambda sql, *parameters: connection.execute(sql, list(parameters)).fetchall()
    except duckdb.Error as error:
        raise _said(error, said, str(where), remedy) from error
    finally:
        connection.close()


def _said(error: Exception, said: str, where: str, remedy: str) -> ScaraIsoError:
    """Return an error of DuckDB as one of ours: its disk is full, its memory, or it cannot read."""
    import duckdb  # noqa: PLC0415 - it is there

    full = isinstance(error, duckdb.OutOfMemoryException | duckdb.IOException)
    if full and any(words in str(error) for words in _DISK_IS_FULL):
        return WriteError("no room for temporary files", where=tempfile.gettempdir(), remedy=_ROOM)
    if isinstance(error, duckdb.OutOfMemoryException):
        first = str(error).partition("\n")[0].removeprefix("Out of Memory Error: ")
        return DataError(
            f"takes more memory than there is for it: {first}", where=where, remedy=_FEWER
        )
    return DataError(f"{said}: {_brief(error)}", where=where, remedy=remedy)


def unnested(columns: Columns) -> tuple[str, list[list[object]]]:
    """Return the SQL that gives columns as a table, and its parameters."""
    listed = ", ".join(f'unnest(?::{kind}[]) AS "{name}"' for name, (kind, _) in columns.items())
    return f"SELECT {listed}", [list(values) for _, values in columns.values()]


def as_parquet(sql: str, parameters: Sequence[object] = (), query: Query | None = None) -> bytes:
    """Return what SQL gives as a Parquet file, of the tables of ``query`` where that is given."""
    with _written_beside() as made:
        if query is None:
            with closing(connect()) as connection:
                connection.execute(f"CREATE TABLE made AS {sql}", list(parameters))
                connection.execute(f"COPY made TO '{made}' (FORMAT parquet)")
        else:
            query(f"COPY ({sql}) TO '{made}' (FORMAT parquet)", *parameters)
        return made.read_bytes()


def joined_parquet(files: Sequence[bytes]) -> bytes:
    """Return the rows of several Parquet files of the same columns as one, in their order."""
    with _written_beside() as beside:
        paths = [beside.with_name(f"{k}.parquet") for k in range(len(files))]
        for path, content in zip(paths, files, strict=True):
            path.write_bytes(content)
        return as_parquet("FROM parquet(?)", [list(map(alone, paths))])


@contextmanager
def _written_beside() -> Iterator[Path]:
    """Yield where a file may be made for a while; `WriteError` where none can."""
    import duckdb  # noqa: PLC0415 - an extra

    try:
        with tempfile.TemporaryDirectory() as folder:
            yield Path(folder, "part.parquet")
    except (duckdb.IOException, OSError) as error:
        raise WriteError(
            "the folder for temporary files cannot be written, as where its disk is full",
            where=tempfile.gettempdir(),
            remedy=_ROOM,
        ) from error


def rewrite_parquet(
    path: Path, p_values: Mapping[tuple[str, str], tuple[float, bool]], orders: int
) -> None:
    """Put p-values by robot and test, with whether they are at their floor, into a Parquet file."""
    made = [(*key, *value) for key, value in p_values.items()]
    robots, tests, values, floors = map(list, zip(*made, strict=True))
    sql = (
        "SELECT result.* REPLACE (coalesce(made.p, p_value) AS p_value, "
        "coalesce(made.floor, at_floor) AS at_floor, "
        "CAST(if(made.p IS NULL, orders, ?) AS INTEGER) AS orders) "
        "FROM parquet(?) AS result LEFT JOIN (SELECT unnest(?::VARCHAR[]) AS robot, "
        "unnest(?::VARCHAR[]) AS test, unnest(?::DOUBLE[]) AS p, unnest(?::BOOLEAN[]) AS floor) "
        "AS made USING (robot, test)"
    )
    given = [orders, alone(path), robots, tests, values, floors]
    write_file(path, as_parquet(sql, given))
