"""What a public function takes for a table of readings, or for the tables of one test."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, TypeVar, Union

from scara_iso.errors import NoInputError, ScaraIsoError, UsageError
from scara_iso.frames import FRAME, is_frame
from scara_iso.run import Run
from scara_iso.tables import Part, Source, listed, merge, read_table, together

if TYPE_CHECKING:
    import pandas as pd

Table: TypeAlias = Union[Run, Source, "pd.DataFrame"]
"""A path, ``-`` for standard input, bytes, an open file, a `Run` or a pandas table."""
Tables: TypeAlias = Table | Sequence[Table]
"""A table, or those of one test, a pose each: a sequence of tables, or the path of their folder."""

_ENDINGS = frozenset({".csv", ".tsv", ".txt", ".xlsx"})
_NAMELESS = ("", "bytes", "file object", FRAME)
_MOST_NAMED = 5
One = TypeVar("One")
Other = TypeVar("Other")


@dataclass(frozen=True, slots=True)
class TableOptions:
    """How tables are to be read, as in `read_table`; a pandas table needs its ``unit``."""

    unit: str | None = None
    resolution: float | None = None
    decimal: str | None = None
    sheet: str | None = None
    columns: str | Sequence[str] | None = None

    def read(self, tables: Tables) -> Run:
        """Return the run of a table, or of those of one test.

        Errors as in `read_table`, `Run.from_frame` and `tables.merge`, with the faults of every
        table; `UsageError` for an option that the kind of table has no use for.
        """
        found = tables_of(tables)
        if len(found) == 1:
            return self._read_one(found[0])
        runs = every(found, self._read_one, f"of {len(found)} tables")
        parts = [_part(k, run) for k, run in enumerate(runs, 1)]
        return merge(parts, together_as(tables) or _named(part.name for part in parts))

    def _read_one(self, table: Table) -> Run:
        if isinstance(table, Run):
            self._refuse("a Run", ("unit", "resolution", "decimal", "sheet", "columns"))
            return table
        if is_frame(table):
            self._refuse("a data frame", ("decimal", "sheet", "columns"))
            return Run.from_frame(table, unit=self.unit, resolution=self.resolution)
        return read_table(table, **asdict(self))

    def _refuse(self, kind: str, options: tuple[str, ...]) -> None:
        given = [name for name in options if getattr(self, name) is not None]
        if given:
            raise UsageError(
                f"{', '.join(given)}: {kind} is not read from text", remedy="leave it out"
            )


def tables_of(tables: Tables) -> list[Table]:
    """Return the single tables of a sequence or a folder; `NoInputError` where there is none."""
    if isinstance(tables, list | tuple):
        found = [one for table in tables for one in tables_of(table)]
    elif isinstance(tables, str | Path) and Path(tables).is_dir():
        found = list(_in_folder(Path(tables)))
    else:
        return [tables]  # type: ignore[list-item]  # a sequence is a list or a tuple
    if not found:
        where = "" if isinstance(tables, list | tuple) else str(tables)
        raise NoInputError("no table is there", where=where, remedy="name tables: P1.csv P2.csv")
    if sum(isinstance(one, str) and one == "-" for one in found) > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")
    return found


def together_as(tables: Tables) -> str:
    """Return what the tables of one test are called together: their folder, else nothing."""
    one = tables[0] if isinstance(tables, list | tuple) and len(tables) == 1 else tables
    return str(one) if isinstance(one, str | Path) else ""


def _in_folder(folder: Path) -> list[Path]:
    """Return the tables of a folder, P10 behind P9."""
    found = [
        path
        for path in folder.iterdir()
        if path.suffix.lower() in _ENDINGS and not path.name.startswith((".", "~$"))
    ]
    return sorted(found, key=lambda path: (_natural(path.name), path.name))


def _natural(name: str) -> list[tuple[int, str]]:
    parts = re.split(r"([0-9]+)", name.casefold())
    return [(int(part), "") if part.isdecimal() else (0, part) for part in parts]


def _part(k: int, run: Run) -> Part:
    source = run.origin.source
    name = f"table {k}" if source in _NAMELESS else source
    return Part(run, name, Path(source).name)


def _named(names: Iterable[str]) -> str:
    names = list(names)
    left = len(names) - _MOST_NAMED
    return listed([*names[:_MOST_NAMED], f"{left} more"] if left > 0 else names)


def every(tables: Sequence[One], work: Callable[[One], Other], of: str) -> list[Other]:
    """Return what ``work`` makes of each, or raise one error with the faults of all.

    ``of`` stands behind the number of those that failed, as in ``2 of 5 tables``.
    """
    found: list[Other] = []
    errors: list[ScaraIsoError] = []
    for table in tables:
        try:
            found.append(work(table))
        except ScaraIsoError as error:
            errors.append(error)
    if errors:
        raise together(errors, "", f"{len(errors)} {of} cannot be used")
    return found
