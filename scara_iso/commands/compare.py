"""`compare`: what a repair changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, Unpack

import typer

from scara_iso import comparison, iso9283, reporting
from scara_iso.base.errors import UsageError
from scara_iso.base.published import to_json
from scara_iso.commands.conditions import ConditionRun, read_conditions
from scara_iso.commands.folders import path_under, say_missing, write_conditions
from scara_iso.commands.inputs import TableOptions, Tables, TablesOptions, every, parted, sizes_of
from scara_iso.commands.options import (
    NOT_WITHIN_LIMITS,
    AsJson,
    ConditionName,
    Full,
    parse_limits,
    takes_tables,
)
from scara_iso.commands.output import (
    check_outputs,
    command_line,
    write_json,
    write_picture,
    write_report,
    write_result,
)
from scara_iso.comparison import SEED, Comparison, published_comparison
from scara_iso.iso9283 import Analysis, Conformity, Counting
from scara_iso.testfolder import is_test_folder

if TYPE_CHECKING:
    pass

_Set: TypeAlias = Tables | Analysis


def compare(
    *tables: _Set | Sequence[_Set],
    condition: str | None = None,
    exchangeability: bool = False,
    limits: float | Mapping[str, float] | None = None,
    seed: int = SEED,
    **options: Unpack[TablesOptions],
) -> Comparison:
    """Return every table against the first: means, RP and +/- 3 s of angles, with intervals.

    ``compare(before, after)`` or ``compare([before, after, later])``; each may be the tables of
    several poses (a folder, or a sequence), which are compared pose by pose; of a test's folder
    those under ``condition``, which may be left out where it has one only. An `Analysis` is taken
    as it is. Options are those of `analyze`, for every table; ``seed`` is that of the permutations.
    With ``exchangeability`` the tables are of several robots (7.7), and ``limits`` may hold
    ``exchangeability``, in mm. The method is that of docs/compare.md. Raises one error with the
    faults of all tables, and `UsageError` for fewer than two.
    """
    reading, counting = parted(**options)

    def figures(table: _Set) -> Analysis:
        if isinstance(table, Analysis):
            return table
        named = condition if _is_test(table) else None
        if (measured := reading.measured(table, named)) is not None:
            return iso9283.analyze(measured.readings, measured.counted(counting))
        return iso9283.analyze(reading.read(table), counting)

    wanted = sizes_of("limits", limits)
    if not exchangeability:
        comparison.refuse_limits(wanted)
    sets = _sets(tables)
    if condition is not None and not any(map(_is_test, sets)):
        raise UsageError("`condition=` is for the folders of tests", remedy="leave it out")
    analyses = every(sets, figures, f"of {len(sets)} tables")
    found = comparison.compare(analyses, seed=seed)
    if not exchangeability:
        return found
    return replace(found, characteristics=comparison.exchangeability(analyses, wanted))


def _is_test(table: _Set) -> bool:
    return isinstance(table, ConditionRun) or is_test_folder(table)


def _sets(tables: Sequence[_Set | Sequence[_Set]]) -> list[_Set]:
    """Return the runs to compare: a single sequence holds them, else each argument is one."""
    one = tables[0] if len(tables) == 1 else None
    return list(one if isinstance(one, list | tuple) else tables)


def show_comparison(comparison: Comparison, again: Sequence[str], *, full: bool) -> None:
    """Write a comparison; ``again`` are the command lines of its tables, without the command."""
    write_report(reporting.comparison_report(comparison, again), full=full)


ComparedTables = Annotated[
    list[str],
    typer.Argument(
        metavar="BEFORE AFTER [MORE]...",
        help="Tables of readings (a folder or workbook: of several poses), the first against "
        "each other one; - is standard input.",
    ),
]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="The picture, as .svg or .png.")]
Seed = Annotated[int, typer.Option(help="Seed of the permutations.", min=0)]


@takes_tables
def compare_command(
    tables: ComparedTables,
    *,
    plot: Plot = None,
    reading: TableOptions,
    counting: Counting,
    exchangeability: Annotated[
        bool, typer.Option("--exchangeability", help="The tables are of several robots (7.7).")
    ] = False,
    limit: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=LIMIT", help="exchangeability=0.05, in mm; decided as analyze."),
    ] = None,
    seed: Seed = 9283,
    condition: ConditionName = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Compare runs with the first: means and RP, with intervals, a test, and its power.

    Example: scara-iso compare examples/before_repair.csv examples/after_repair.csv
    """
    if tables.count("-") > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")
    check_outputs([], tables, pictures=[plot])
    read = asdict(reading) | asdict(counting)
    options: dict[str, Any] = {
        **read,
        "exchangeability": exchangeability,
        "limits": parse_limits(limit or ()),
        "seed": seed,
    }
    if any(map(is_test_folder, tables)):
        found = compare_folders(tables, condition, plot, options, as_json=json, full=full)
    else:
        found = [compare(*tables, condition=condition, **options)]
        write_picture(found[0], plot)
        if json:
            from scara_iso.comparison import published_comparison

            write_json(to_json(published_comparison(found[0])))
        else:
            again = [command_line([table], read) for table in tables]
            show_comparison(found[0], again, full=full)
    held = [o.limit.verdict for one in found for o in one.characteristics if o.limit is not None]
    if any(verdict is not Conformity.PASS for verdict in held):
        raise typer.Exit(NOT_WITHIN_LIMITS)


def compare_folders(
    tables: Sequence[str],
    condition: str | None,
    plot: Path | None,
    options: Mapping[str, Any],
    *,
    as_json: bool,
    full: bool,
) -> list[Comparison]:
    """Write what differs between tests under each condition that all of them have; return it.

    A table beside folders goes with one condition only.
    """
    asked = list(_compared(tables, condition, plot, options))
    several = len(asked) > 1
    found = [(one, result) for one, result in asked if result is not None]
    for one, result in found:
        write_picture(result, path_under(plot, one.condition.name, several=several))
        if not as_json:
            typer.echo(f"{one.condition}:")
            again = [command_line([table], {"condition": one.condition.name}) for table in tables]
            show_comparison(result, again, full=full)
    published = [(one, published_comparison(result)) for one, result in found]
    if as_json and several:
        write_conditions([reporting.published_condition(*one) for one in published])
    elif as_json and published:
        write_result(published[0][1])
    return [result for _, result in found]


def _compared(
    tables: Sequence[str],
    condition: str | None,
    plot: Path | None,
    options: Mapping[str, Any],
) -> Iterator[tuple[ConditionRun, Comparison | None]]:
    """Yield each condition, with what is missing of it in any test, and its comparison.

    Where nothing is recorded under it in one of the tests, that is said, and there is none.
    """
    tests = {
        one: {found.condition.name: found for found in read_conditions(one, condition)}
        for one in tables
        if is_test_folder(one)
    }
    shared = _shared(tests, tables)
    check_outputs([path_under(plot, name, several=len(shared) > 1) for name in shared], [])
    for name in shared:
        of_test = [found[name] for found in tests.values()]
        if any(one.run is None for one in of_test):
            for one in of_test:
                say_missing(one)
            yield of_test[0], None
            continue
        sets = [tests[one][name] if one in tests else one for one in tables]
        missing = tuple(part for one in of_test for part in one.missing)
        yield replace(of_test[0], missing=missing), compare(sets, **options)


def _shared(tests: Mapping[str, Mapping[str, ConditionRun]], tables: Sequence[str]) -> list[str]:
    """Return the conditions that all tests have, in the order of the first, and say the others."""
    every = list(tests.values())
    shared = [name for name in every[0] if all(name in one for one in every)]
    if not shared or (len(shared) > 1 and len(tests) < len(set(tables))):
        what = "no condition is in all of them" if not shared else "a table is of one condition"
        raise UsageError(what, remedy=f"`condition=` is one of {', '.join(every[0])}")
    for table, found in tests.items():
        if left := [name for name in found if name not in shared]:
            said = f"scara-iso: {table}: {', '.join(left)} is not in every test: not compared"
            typer.echo(reporting.printable(said), err=True)
    return shared
