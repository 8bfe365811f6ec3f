"""DuckDB, which reads and writes tables of many robots: the one place that knows it."""

import glob
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from scara_iso.base.errors import DataError, ScaraIsoError, UsageError, WriteError, with_extra

Query = Callable[..., Any]
"""SQL and its parameters to a result of DuckDB: ``fetchall()``, ``fetchnumpy()``, ``df()``."""
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


def connect(threads: int = 1) -> Any:
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
    connection.execute(f"SET memory_limit = '{_MEMORY}'")  # what is more goes to the disk
    connection.execute("SET enable_progress_bar = false")  # it would stand in what is printed
    own = f"scara-iso-{os.getpid()}-{id(connection)}"  # a folder of two would be lost
    connection.execute("SET temp_directory = ?", [str(Path(tempfile.gettempdir(), own))])
    return connection


def alone(path: Path) -> str:
    """Return a path as DuckDB takes it for this file and no other: a ``*`` of it is a letter."""
    return glob.escape(str(path))


@contextmanager
def workspace(where: Path, threads: int = 1) -> Iterator[Query]:
    """Yield how files are queried; `DataError` naming ``where`` if one cannot be read."""
    with _session(connect(threads), "cannot be read", where, "mend the file") as query:
        yield query


@contextmanager
def results_in(folder: Path) -> Iterator[Query]:
    """Yield how ``fleet`` is queried, which is all Parquet files of a folder: the SQL to its rows.

    Tables that state a robot's name alone are of the one ``robot`` that has this name and a serial
    number; ``as_read`` is what stands in the files, and the table ``named`` has the names of each
    serial number. Every query has no rows where there are no files.
    """
    failure = "the results cannot be read"
    remedy = "remove the damaged file; the same command makes it anew"
    with _session(connect(), failure, folder, remedy) as query:
        if not any(folder.glob("*.parquet")):
            yield lambda *_: []
            return
        quoted = f"{alone(folder)}/*.parquet".replace("'", "''")
        query(
            f"CREATE VIEW stated AS FROM read_parquet('{quoted}', hive_partitioning = false, "
            "filename = true)"
        )
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
        yield lambda sql, *parameters: query(sql, *parameters).fetchall()


@contextmanager
def _session(connection: Any, failure: str, where: Path, remedy: str) -> Iterator[Query]:
    """Yield how a connection is queried, and close it; `DataError` or `WriteError` if it fails."""
    import duckdb  # noqa: PLC0415 - it is there

    try:
        yield lambda sql, *parameters: connection.execute(sql, list(parameters))
    except duckdb.Error as error:
        raise _as_ours(error, failure, str(where), remedy) from error
    finally:
        connection.close()


def _as_ours(error: Exception, failure: str, where: str, remedy: str) -> ScaraIsoError:
    import duckdb  # noqa: PLC0415 - it is there

    full = isinstance(error, duckdb.OutOfMemoryException | duckdb.IOException)
    if full and any(words in str(error) for words in _DISK_IS_FULL):
        return WriteError("no room for temporary files", where=tempfile.gettempdir(), remedy=_ROOM)
    if isinstance(error, duckdb.OutOfMemoryException):
        first = str(error).partition("\n")[0].removeprefix("Out of Memory Error: ")
        return DataError(
            f"takes more memory than there is for it: {first}", where=where, remedy=_FEWER
        )
    return DataError(f"{failure}: {' '.join(str(error).split())[:200]}", where=where, remedy=remedy)


def as_parquet(tables: Sequence[Any], kinds: Mapping[str, str]) -> bytes:
    """Return pandas tables below each other as a Parquet file of columns with these SQL types."""
    import duckdb  # noqa: PLC0415 - an extra

    columns = ", ".join(f'"{name}"::{kind} AS "{name}"' for name, kind in kinds.items())
    rows = " UNION ALL ".join(f"SELECT {columns} FROM table{k}" for k in range(len(tables)))  # noqa: S608
    connection = connect()
    connection.execute("SET pandas_analyze_sample = 0")  # a column of objects is text
    try:
        for k, table in enumerate(tables):
            connection.register(f"table{k}", table)
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder, "part.parquet")
            connection.execute(f"COPY ({rows}) TO '{made}' (FORMAT parquet)")
            return made.read_bytes()
    except (duckdb.IOException, OSError) as error:
        raise WriteError(
            "the folder for temporary files cannot be written, as where its disk is full",
            where=tempfile.gettempdir(),
            remedy=_ROOM,
        ) from error
    finally:
        connection.close()
