"""What a public function takes: tables of readings, sizes by figure, models, own effects."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from difflib import get_close_matches
from enum import Enum
from functools import partial
from io import BytesIO
from numbers import Real
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    TypeAlias,
    TypedDict,
    TypeVar,
    Union,
    get_args,
    get_type_hints,
)

from scara_iso import iso9283
from scara_iso.base.errors import DataError, NoInputError, ScaraIsoError, UsageError
from scara_iso.base.files import is_file, is_folder
from scara_iso.base.quantities import is_size
from scara_iso.commands.shared.series import MeasurementSeries, Readable, read_conditions
from scara_iso.rawfile import check_recording, is_raw_file, raw_path
from scara_iso.run import FRAME, Run, is_frame
from scara_iso.tables import (
    PosePart,
    Source,
    listed,
    merge,
    pose_in,
    read_bytes,
    read_table,
    together,
)
from scara_iso.testfolder import is_test_folder

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas as pd

    from scara_iso.effects import OwnEffect
    from scara_iso.robot import Model

Reading: TypeAlias = Mapping[str, Any]
"""What is stated of `ReadingOptions`, by name."""
Table: TypeAlias = Union[Run, Source, "pd.DataFrame"]
"""A path, ``-`` for standard input, bytes, an open file, a `Run` or a pandas table."""
Tables: TypeAlias = Table | Sequence[Table] | MeasurementSeries
"""A table, or those of one test, a pose each: a sequence of tables, or the path of their folder.

A test.toml in the folder makes it the parts of one condition, as is a `MeasurementSeries`.
"""
EVENTS = "events.csv"
"""What was done to a robot, which stands beside its tables and is none."""
_ENDINGS = frozenset({".csv", ".tsv", ".txt", ".xlsx"})
_NAMELESS = ("", "bytes", "file object", FRAME)
_MOST_NAMED = 5
_NAME_TABLES = "name tables, as P1.csv P2.csv, or a folder of .csv, .tsv, .txt or .xlsx"
One = TypeVar("One")
Other = TypeVar("Other")
Word = TypeVar("Word", bound=Enum)


class DialOptions(TypedDict, total=False):
    """What of a table may be stated beside it."""

    unit: str | None
    resolution: float | None
    decimal: str | None


class ReadingOptions(DialOptions, total=False):
    """How a table is read, as in `read_table`; a pandas table needs its ``unit``."""

    sheet: str | None
    columns: str | Sequence[str] | None


class TablesOptions(ReadingOptions, iso9283.CountingOptions, total=False):
    """How tables are read, and which of their cycles count."""


def keywords_in(parameter: inspect.Parameter) -> Mapping[str, Any]:
    """Return the keywords, with types, for which ``**options: Unpack[..]`` stands."""
    unpacked = get_args(parameter.annotation) if parameter.kind is parameter.VAR_KEYWORD else ()
    return get_type_hints(unpacked[0]) if unpacked else {}


def refuse_unknown(function: Callable[..., Any], options: Mapping[str, object]) -> None:
    """Raise `UsageError` with the nearest name for an option that ``function`` does not have."""
    own = inspect.signature(function, eval_str=True).parameters
    known = [name for k, one in own.items() for name in keywords_in(one) or (k,)]
    if unknown := sorted(options.keys() - set(known)):
        near = get_close_matches(unknown[0], known, 1) or sorted(known)
        raise UsageError(
            f"{function.__name__}() has no option {unknown[0]}=",
            remedy=f"did you mean {'=, '.join(near)}=?",
        )


def reading_and_counting(
    function: Callable[..., Any], options: TablesOptions
) -> tuple[Reading, iso9283.Counting]:
    """Return how tables are read, and which of their cycles count; errors as of both."""
    refuse_unknown(function, options)
    given: dict[str, Any] = dict(options)
    reading = {name: given.pop(name, None) for name in ReadingOptions.__annotations__}
    return reading, iso9283.Counting(**given)


def read_run(tables: Tables, reading: Reading, condition: str | None = None) -> Run:
    """Return the run of a table, or of those of one test; of a folder under ``condition``.

    Errors as in `read_table`, `Run.from_frame` and `tables.merge`, with the faults of every
    table; `UsageError` for an option that the kind of table has no use for.
    """
    return read_series(tables, reading, condition).readings


def read_series(
    tables: Tables, reading: Reading, condition: str | None = None
) -> MeasurementSeries:
    """Return the tables of one test, or a test's folder under a condition or its only one.

    Errors as in `read_run`; `UsageError` where a folder has several and none is named.
    """
    found = each_series(tables, reading, condition)
    if len(found) > 1:
        names = [one.name for one in found]
        raise UsageError(
            f"{_path(tables)} holds {len(names)} conditions, and each is a result of its own",
            remedy=f"name one: `condition={names[0]}`, or {', '.join(names[1:10])}",
        )
    return found[0]


def each_series(
    tables: Tables, reading: Reading, condition: str | None = None
) -> tuple[MeasurementSeries, ...]:
    """Return what is a result of its own: tables of one test, or each condition of a folder.

    Errors as in `read_run` and `read_conditions`; `UsageError` for an option of a table beside a
    folder, for a folder beside other tables, and for a condition beside a table.
    """
    many = tables if isinstance(tables, list | tuple) else (tables,)
    for one in many:
        _refuse_other(one)
    folder = next((one for one in many if is_test(one)), None)
    if folder is None and condition is None:
        return (_of_tables(tables, reading),)
    stated = [name for name, value in reading.items() if value is not None]
    if folder is None:
        what, remedy = "`condition=` is for the folder of a test", "leave it out"
    elif len(many) > 1:  # of a folder, what is struck is no table
        what = "the folder of a test is not taken together with other tables"
        remedy = "name it alone, or the tables of its parts"
    elif stated:
        what = f"`{stated[0]}=` is for a table, and each part of a test states its own"
        remedy = "leave it out"
    elif isinstance(folder, MeasurementSeries):
        return (folder,)
    else:
        return read_conditions(str(folder), condition)
    raise UsageError(what, where=_path(tables if folder is None else folder), remedy=remedy)


def _of_tables(tables: Tables, reading: Reading) -> MeasurementSeries:
    found = tables_of(tables)
    named = tables if isinstance(tables, list | tuple) else (tables,)
    folders = [Path(one) for one in named if isinstance(one, str | Path) and is_folder(one)]
    stray = f"; or move files of something else out of {folders[0]}" if folders else ""
    both = collect_all(found, partial(_read_one, reading), f"of {len(found)} tables", stray)
    run = both[0][1]
    if len(found) > 1:
        parts = [_part(k, run) for k, (_, run) in enumerate(both, 1)]
        one = tables[0] if isinstance(tables, list | tuple) and len(tables) == 1 else tables
        run = merge(parts, _path(one) or _named([part.name for part in parts]))
    if below := [str(path) for folder in folders for path in folders_seen(folder)]:
        notes = (f"tables in {_named(below)}: not used", *run.origin.notes)
        run = replace(run, origin=replace(run.origin, notes=notes))
    read = tuple(kept for kept, _ in both)
    return MeasurementSeries(run=run, read=read, paths=tuple(paths_of(found)))


def _read_one(reading: Reading, table: Table) -> tuple[Readable, Run]:
    """Return a run twice, or a table whose bytes cannot change any more and its run."""
    if isinstance(table, Run) or is_frame(table):
        taken = () if isinstance(table, Run) else ("unit", "resolution")
        kind = "a data frame" if taken else "a Run"
        given = [name for name, one in reading.items() if one is not None and name not in taken]
        if given:
            raise UsageError(
                f"{', '.join(given)}: {kind} is not read from text", remedy="leave it out"
            )
        if not isinstance(table, Run):
            table = Run.from_frame(table, **{name: reading.get(name) for name in taken})
        return table, table
    try:
        data, name = read_bytes(table)
    except NoInputError as error:
        raise _of_its_recording(table, error) from error
    if is_raw_file(data):
        remedy = f"record `rebuild={name}` makes the table of it"
        raise DataError("is a raw file, not a table", where=name, remedy=remedy)
    file = BytesIO(data)
    setattr(file, "name", name)  # noqa: B010 - where errors and the report say it is from
    run = read_table(file, **reading)
    is_named = isinstance(table, str | Path) and str(table) != "-"
    return file, check_recording(run, Path(name)) if is_named else run


def _of_its_recording(table: Table, error: NoInputError) -> NoInputError:
    """Return the error with what makes the table, where a recorder was killed before it did."""
    if not isinstance(table, str | Path) or not Path(table).name or os.path.lexists(table):
        return error
    raw = raw_path(Path(table))
    remedy = f"record `rebuild={raw}` makes it of what was recorded"
    return NoInputError(error.what, where=error.where, remedy=remedy) if is_file(raw) else error


def is_test(table: object) -> bool:
    """Say whether this is the folder of a test, or its readings under a condition."""
    return isinstance(table, MeasurementSeries) or is_test_folder(table)


def _refuse_other(table: object) -> None:
    """Raise `UsageError` for what is no table, such as an array without the names of its axes."""
    known = isinstance(table, Run | MeasurementSeries | str | Path | bytes | list | tuple)
    if not (known or is_frame(table) or hasattr(table, "read")):
        raise UsageError(
            f"{type(table).__name__} is not a table of readings",
            remedy="give a path, a Run, or a pandas table with a column for each axis, such as "
            'pandas.DataFrame({"X": readings}), and `unit=mm`',
        )


def names_a_pose(table: str | Path, reading: Reading) -> bool:
    """Say whether a table, or the name of its file, names poses; what cannot be read does not."""
    if pose_in(Path(table).name):
        return True
    try:
        run = read_run(table, reading)
    except ScaraIsoError:  # it is read again, and its fault is said then
        return False
    return run.pose is not None or "pose" in run.metadata


def tables_of(tables: Tables) -> list[Table]:
    """Return the single tables of a sequence or a folder; `NoInputError` where there is none."""
    if isinstance(tables, list | tuple):
        found = [one for table in tables for one in tables_of(table)]
    elif isinstance(tables, str | Path) and is_folder(tables):
        found = list(table_files(Path(tables)))
    else:
        return [tables]  # type: ignore[list-item]  # a sequence is a list or a tuple
    if not found:
        where = _path(tables)
        below = folders_seen(Path(where)) if where else []
        remedy = f"its folders hold tables: name one, as {below[0]}" if below else _NAME_TABLES
        raise NoInputError("no table is there", where=where, remedy=remedy)
    if sum(isinstance(one, str) and one == "-" for one in found) > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")
    return found


def each_of(
    tables: Tables, work: Callable[[str], One], executor: Executor | None = None
) -> Iterator[One]:
    """Yield what ``work`` makes of the path of each table, shared among processes."""
    from scara_iso import fleets

    with nullcontext(executor) if executor is not None else fleets.open_processes() as pool:
        yield from pool.map(work, map(str, tables_of(tables)))


def folders_below(folder: Path) -> list[Path]:
    """Return the folders that hold tables, in a folder and in those in it; 10 stands behind 9."""
    below = [deeper for path in _folders_in(folder) for deeper in (path, *_folders_in(path))]
    return [path for path in below if table_files(path)]


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


def table_files(folder: Path) -> list[Path]:
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


def _named(names: Sequence[str]) -> str:
    left = len(names) - _MOST_NAMED
    return listed([*names[:_MOST_NAMED], f"{left} more"] if left > 0 else names)


def collect_all(
    tables: Sequence[One], work: Callable[[One], Other], of: str, also: str = ""
) -> list[Other]:
    """Return what ``work`` makes of each, or raise one error with the faults of all.

    ``of`` stands behind the number of those that failed, as in ``2 of 5 tables``, ``also`` behind
    the remedy where few did. Those that are not there are named alone.
    """
    found = [attempt(work, table) for table in tables]
    errors = [one for one in found if isinstance(one, ScaraIsoError)]
    if errors:
        errors = [one for one in errors if isinstance(one, NoInputError)] or errors
        error = together(errors, "", f"{len(errors)} {of} cannot be used")
        if 2 * len(errors) < len(tables):
            error.remedy += also
        raise error
    return [one for one in found if not isinstance(one, ScaraIsoError)]


def attempt(work: Callable[[One], Other], table: One) -> Other | ScaraIsoError:
    """Return what ``work`` makes of a table, or its error; that of an option is raised."""
    try:
        return work(table)
    except UsageError:
        raise
    except ScaraIsoError as error:
        return error


def one_of(kind: type[Word], name: str, word: str) -> Word:
    """Return the member of an enumeration that has this word; `UsageError` for another word."""
    words = [one.value for one in kind]
    if word not in words:
        raise UsageError(f"{name} {word!r} is not known", remedy=f"use {', '.join(words)}")
    return kind(word)


Size = TypeVar("Size", bound=iso9283.Limit)
Sizes: TypeAlias = float | str | Mapping[str, float | str]
"""One for all, or by figure or axis; a text has its unit: ``"20um"``."""


def sizes_of(
    name: str, given: Size | Mapping[str, Size] | None, *, pairs: bool = False
) -> dict[str, Size]:
    """Return the sizes by figure or axis; a single one stands under the empty name, for all.

    ``name`` is the keyword's; a text has a unit, and with ``pairs`` a size may be the smallest and
    the largest. Raises `UsageError` for what is no size.
    """
    found: dict[str, Size] = {}
    if given is not None:
        found.update(given if isinstance(given, Mapping) else {iso9283.EVERY_LENGTH: given})
    for figure, size in found.items():
        ends = size if pairs and isinstance(size, tuple) and len(size) == 2 else (size,)
        if not isinstance(figure, str) or not all(map(_is_size, ends)):
            raise UsageError(
                f"{name}={given!r} is not a size",
                remedy=f'write {name}=0.02, or {name}={{"X": "20um"}} for one of them',
            )
    return found


def _is_size(size: object) -> bool:
    if isinstance(size, str):
        return is_size(size)
    return isinstance(size, Real) and not isinstance(size, bool)


OwnEffects: TypeAlias = str | Path | Sequence["OwnEffect"]
"""Effects of the user's own, or the file that defines them."""


def load_model(model: Model | str | Path, own_effects: OwnEffects = ()) -> Model:
    """Return a model, read where its file is named, with the user's effects.

    Errors as in `read_model` and `read_effects`.
    """
    from scara_iso import robot

    own = load_effects(own_effects)
    if not isinstance(model, robot.Model):
        return robot.read_model(model, own)
    known = {one.name: one for one in (*own, *model.own)}
    return replace(model, own=tuple(known.values())) if own else model


def load_effects(own_effects: OwnEffects | None) -> tuple[OwnEffect, ...]:
    """Return effects, read where their file is named; errors as in `read_effects`."""
    from scara_iso.robot import read_effects

    if isinstance(own_effects, str | Path):
        return read_effects(own_effects)
    return tuple(own_effects or ())


def held_out_pose(run: Run, hold_out: Tables | None) -> str | None:
    """Return the pose of a run that ``hold_out`` names, None where it is a table."""
    labels = [label for label, _ in run.rows_by_pose() if label is not None]
    return hold_out if isinstance(hold_out, str) and hold_out in labels else None
