"""DuckDB, which reads and writes tables of many robots: the one place that knows it."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from scara_iso.disk import write_file
from scara_iso.errors import DataError, UsageError, WriteError

Query = Callable[..., list[Any]]
"""SQL and its parameters to rows."""

_OF_A_ROW = re.compile(r"CSV Error on Line: (?P<line>\d+)\n.*\n+(?P<reason>\S.*)")
_REMEDY = "pip install 'scara-iso[fleet]'"


def connect() -> Any:
    """Return a connection in memory, of one thread; `UsageError` without the package for it."""
    try:
        import duckdb  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise UsageError("tables of a fleet need DuckDB", remedy=_REMEDY) from error
    connection = duckdb.connect()
    connection.execute("SET threads = 1")  # the processes share the cores
    return connection


def fetched(sql: str, parameters: Sequence[object], where: str) -> Any:
    """Return what a query gives as a pandas table; `DataError` where a file cannot be read."""
    connection = connect()
    import duckdb  # noqa: PLC0415 - it is there

    try:
        return connection.execute(sql, list(parameters)).df()
    except duckdb.Error as error:
        raise DataError(
            f"cannot be read: {_brief(error)}", where=where, remedy="mend the file"
        ) from error
    finally:
        connection.close()


def fetched_csv(path: Path, delimiter: str, names: Sequence[str]) -> Any:
    """Return a CSV file of these columns as a pandas table of text: nothing of it is guessed."""
    sql = (
        "SELECT * FROM read_csv(?, auto_detect=false, header=true, columns=?, delim=?, "
        "quote='\"', escape='\"', comment='#')"
    )
    columns = {name or f"column {k}": "VARCHAR" for k, name in enumerate(names, 1)}
    return fetched(sql, [str(path), columns, delimiter], str(path))


@contextmanager
def results_in(folder: Path) -> Iterator[Query]:
    """Yield how ``fleet`` is queried, which is all Parquet files of a folder: the SQL to its rows.

    Every query has no rows where there are no files.
    """
    connection = connect()
    import duckdb  # noqa: PLC0415 - it is there

    try:
        if any(folder.glob("*.parquet")):
            quoted = str(folder / "*.parquet").replace("'", "''")
            connection.execute(f"CREATE VIEW fleet AS FROM read_parquet('{quoted}')")
            yield lambda sql, *parameters: connection.execute(sql, list(parameters)).fetchall()
        else:
            yield lambda *_: []
    except duckdb.Error as error:
        raise DataError(
            f"the results cannot be read: {_brief(error)}", where=str(folder),
            remedy="remove the damaged file; the same command makes it anew",
        ) from error  # fmt: skip
    finally:
        connection.close()


def _brief(error: Exception) -> str:
    """Return what is wrong in one line: of a CSV the line and the reason, without its text."""
    text = str(error)
    row = _OF_A_ROW.search(text)
    said = text if row is None else f"line {row['line']}: {row['reason']}"
    return " ".join(said.split())[:200]


def write_parquet(path: Path, columns: Mapping[str, tuple[str, Sequence[object]]]) -> None:
    """Write columns, each with its SQL type, as one Parquet file, whole or not at all."""
    listed = ", ".join(f'unnest(?::{kind}[]) AS "{name}"' for name, (kind, _) in columns.items())
    _write(path, f"SELECT {listed}", [list(values) for _, values in columns.values()])


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
        "FROM read_parquet(?) AS result LEFT JOIN (SELECT unnest(?::VARCHAR[]) AS robot, "
        "unnest(?::VARCHAR[]) AS test, unnest(?::DOUBLE[]) AS p, unnest(?::BOOLEAN[]) AS floor) "
        "AS made USING (robot, test)"
    )
    _write(path, sql, [orders, str(path), robots, tests, values, floors])


def _write(path: Path, sql: str, parameters: Sequence[object]) -> None:
    connection = connect()
    import duckdb  # noqa: PLC0415 - it is there

    try:
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder, "part.parquet")
            connection.execute(f"CREATE TABLE made AS {sql}", list(parameters))
            connection.execute(f"COPY made TO '{made}' (FORMAT parquet)")
            data = made.read_bytes()
    except (duckdb.IOException, OSError) as error:
        raise WriteError(
            "the folder for temporary files cannot be written, as where its disk is full",
            where=tempfile.gettempdir(), remedy="make room, or name another one by TMPDIR",
        ) from error  # fmt: skip
    finally:
        connection.close()
    write_file(path, data)
