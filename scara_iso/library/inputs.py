"""What a public function takes for a table of readings, or for the tables of one test."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict, TypeVar, Union, Unpack

from scara_iso.base.errors import NoInputError, ScaraIsoError, UsageError
from scara_iso.base.files import is_folder
from scara_iso.iso9283 import Counting, CountingOptions
from scara_iso.library.conditions import ConditionRun, read_condition
from scara_iso.run import FRAME, Run, is_frame
from scara_iso.tables import PosePart, Source, listed, merge, read_table, together
from scara_iso.testfolder import is_test_folder

if TYPE_CHECKING:
    import pandas as pd

Table: TypeAlias = Union[Run, Source, "pd.DataFrame"]
"""A path, ``-`` for standard input, bytes, an open file, a `Run` or a pandas table."""
Tables: TypeAlias = Table | Sequence[Table] | ConditionRun
"""A table, or those of one test, a pose each: a sequence of tables, or the path of their folder.

The folder of a test (with a test.toml) is its parts under one condition, as is a `ConditionRun`.
"""

EVENTS = "events.csv"
"""What was done to a robot, which stands beside its tables and is none."""
_ENDINGS = frozenset({".csv", ".tsv", ".txt", ".xlsx"})
_NAMELESS = ("", "bytes", "file object", FRAME)
_MOST_NAMED = 5
_NAME_TABLES = "name tables, as P1.csv P2.csv, or a folder of .csv, .tsv, .txt or .xlsx"
One = TypeVar("One")
Other = TypeVar("Other")


class ReadingOptions(TypedDict, total=False):
    """The fields of `TableOptions`, as a function takes them."""

    unit: str | None
    resolution: float | None
    decimal: str | None
    sheet: str | None
    columns: str | Sequence[str] | None


class TablesOptions(ReadingOptions, CountingOptions, total=False):
    """How tables are read, and which of their cycles count."""


def parted(**options: Unpack[TablesOptions]) -> tuple[TableOptions, Counting]:
    """Return how tables are read, and which of their cycles count; errors as of both."""
    reading: dict[str, Any] = dict(options)
    names = CountingOptions.__annotations__.keys() & reading.keys()
    counting = {name: reading.pop(name) for name in names}
    return TableOptions(**reading), Counting(**counting)


@dataclass(frozen=True, slots=True)
class TableOptions:
    """How tables are to be read, as in `read_table`; a pandas table needs its ``unit``."""

    unit: str | None = None
    resolution: float | None = None
    decimal: str | None = None
    sheet: str | None = None
    columns: str | Sequence[str] | None = None

    def read(self, tables: Tables, condition: str | None = None) -> Run:
        """Return the run of a table, or of those of one test; of a folder under ``condition``.

        Errors as in `read_table`, `Run.from_frame` and `tables.merge`, with the faults of every
        table; `UsageError` for an option that the kind of table has no use for.
        """
        if (measured := self.measured(tables, condition)) is not None:
            return measured.readings
        found = tables_of(tables)
        if len(found) == 1:
            return self._read_one(found[0])
        runs = every(found, self._read_one, f"of {len(found)} tables")
        parts = [_part(k, run) for k, run in enumerate(runs, 1)]
        return merge(parts, together_as(tables) or _named(part.name for part in parts))

    def measured(self, tables: Tables, condition: str | None = None) -> ConditionRun | None:
        """Return what a test's folder holds under ``condition``, None where it is another table.

        Errors as in `read_condition`; `UsageError` for an option of a table beside a folder, for a
        folder beside other tables, and for a condition beside a table.
        """
        several = tables if isinstance(tables, list | tuple) else (tables,)
        for one in several:
            _refuse_other(one)
        folders = [one for one in several if isinstance(one, ConditionRun) or is_test_folder(one)]
        if not folders:
            if condition is not None:
                raise UsageError(
                    "`condition=` is for the folder of a test",
                    where=_path(tables),
                    remedy="leave it out",
                )
            return None
        if len(several) > 1:  # of a folder, what is struck is no table
            raise UsageError(
                "the folder of a test is not taken together with other tables",
                where=_path(folders[0]),
                remedy="name it alone, or the tables of its parts",
            )
        given = [name for name, value in asdict(self).items() if value is not None]
        if given:
            raise UsageError(
                f"`{given[0]}=` is for a table, and each part of a test states its own",
                where=_path(folders[0]),
                remedy="leave it out",
            )
        only = folders[0]
        return only if isinstance(only, ConditionRun) else read_condition(str(only), condition)

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


def _refuse_other(table: object) -> None:
    """Raise `UsageError` for what is no table, such as an array without the names of its axes."""
    known = isinstance(table, Run | ConditionRun | str | Path | bytes | list | tuple)
    if not (known or is_frame(table) or hasattr(table, "read")):
        raise UsageError(
            f"{type(table).__name__} is no table of readings",
            remedy="give a path, a Run, or a pandas table with a column for each axis, such as "
            'pandas.DataFrame({"X": readings}), and `unit=mm`',
        )


def tables_of(tables: Tables) -> list[Table]:
    """Return the single tables of a sequence or a folder; `NoInputError` where there is none."""
    if isinstance(tables, list | tuple):
        found = [one for table in tables for one in tables_of(table)]
    elif isinstance(tables, str | Path) and is_folder(tables):
        found = list(tables_in(Path(tables)))
    else:
        return [tables]  # type: ignore[list-item]  # a sequence is a list or a tuple
    if not found:
        where = "" if isinstance(tables, list | tuple) else str(tables)
        raise NoInputError("no table is there", where=where, remedy=_where_tables_are(where))
    if sum(isinstance(one, str) and one == "-" for one in found) > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")
    return found


def _where_tables_are(folder: str) -> str:
    below = folders_seen(Path(folder)) if folder else []
    return f"its folders hold tables: name one, as {below[0]}" if below else _NAME_TABLES


def folders_below(folder: Path) -> list[Path]:
    """Return the folders that hold tables, in a folder and in those in it; 10 stands behind 9."""
    below = [deeper for path in _folders_in(folder) for deeper in (path, *_folders_in(path))]
    return [path for path in below if tables_in(path)]


def folders_seen(folder: Path) -> list[Path]:
    """Return `folders_below` for who need not read them: none where one is closed, or is gone."""
    try:
        return folders_below(folder)
    except OSError:
        return []


def _folders_in(folder: Path) -> list[Path]:
    found = [path for path in folder.iterdir() if path.is_dir() and not path.name.startswith(".")]
    return sorted(found, key=lambda path: _natural(path.name))


def paths_of(tables: Tables) -> list[Path]:
    """Return the files among them."""
    return [Path(one) for one in tables_of(tables) if isinstance(one, str | Path) and one != "-"]


def _path(table: object) -> str:
    return str(table) if isinstance(table, str | Path) else ""


def together_as(tables: Tables) -> str:
    """Return what the tables of one test are called together: their folder, else nothing."""
    one = tables[0] if isinstance(tables, list | tuple) and len(tables) == 1 else tables
    return str(one) if isinstance(one, str | Path) else ""


def tables_in(folder: Path) -> list[Path]:
    """Return the tables that lie in a folder itself, P10 behind P9; `EVENTS` is none."""
    found = [
        path
        for path in folder.iterdir()
        if path.suffix.lower() in _ENDINGS
        and not path.name.startswith((".", "~$"))
        and path.name != EVENTS
    ]
    return sorted(found, key=lambda path: (_natural(path.name), path.name))


def _natural(name: str) -> list[tuple[int, str]]:
    parts = re.split(r"([0-9]+)", name.casefold())
    return [(int(part), "") if part.isdecimal() else (0, part) for part in parts]


def _part(k: int, run: Run) -> PosePart:
    source = run.origin.source
    name = f"table {k}" if source in _NAMELESS else source
    return PosePart(run, name, Path(source).name)


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
        except UsageError:  # an option's fault, and not a table's
            raise
        except ScaraIsoError as error:
            errors.append(error)
    if errors:
        raise together(errors, "", f"{len(errors)} {of} cannot be used")
    return found
