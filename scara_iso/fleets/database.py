"""DuckDB, which reads and writes tables of many robots: the one place that knows it."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scara_iso.disk import write_file
from scara_iso.errors import DataError, UsageError

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
        said = " ".join(str(error).split())[:200]
        raise DataError(f"cannot be read: {said}", where=where, remedy="mend the file") from error
    finally:
        connection.close()


def write_parquet(path: Path, columns: Mapping[str, tuple[str, Sequence[object]]]) -> None:
    """Write columns, each with its SQL type, as one Parquet file, whole or not at all."""
    connection = connect()
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "part.parquet")
        listed = ", ".join(
            f'unnest(?::{kind}[]) AS "{name}"' for name, (kind, _) in columns.items()
        )
        values = [list(values) for _, values in columns.values()]
        connection.execute(f"CREATE TABLE made AS SELECT {listed}", values)
        connection.execute(f"COPY made TO '{made}' (FORMAT parquet)")
        connection.close()
        write_file(path, made.read_bytes())
