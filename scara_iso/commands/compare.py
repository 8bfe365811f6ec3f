"""`compare`: what a repair changed."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias, Unpack

from scara_iso import comparison, iso9283, reporting
from scara_iso.base.errors import UsageError
from scara_iso.commands.shared import inputs, options as opt, output as out
from scara_iso.commands.shared.series import MeasurementSeries
from scara_iso.comparison import SEED, Comparison
from scara_iso.testfolder import is_test_folder

_Set: TypeAlias = inputs.Tables | iso9283.Analysis


def compare(
    *tables: _Set | Sequence[_Set],
    condition: str | None = None,
    exchangeability: bool = False,
    limits: inputs.Sizes | None = None,
    seed: int = SEED,
    **options: Unpack[inputs.TablesOptions],
) -> Comparison:
    """Return every table against the first: means, RP and +/- 3 s of angles, with intervals.

    ``compare(before, after)`` or ``compare([before, after, later])``; each may be the tables of
    several poses (a folder, or a sequence), which are compared pose by pose; of a test's folder
    those under ``condition``, which may be left out where it has one only. An `Analysis` is taken
    as it is. Options are those of `analyze`, for every table, ``cycles`` for those that have so
    many; ``seed`` is that of the permutations.
    ``limits`` are held against the figures of each table, as in `analyze`. With
    ``exchangeability`` the tables are of several robots (7.7), and ``limits`` may hold that too.
    The method is that of docs/compare.md. Raises one error with the faults of all tables (of
    those that are not there, where there are such), and `UsageError` for fewer than two.
    """
    reading, counting = inputs.reading_and_counting(compare, options)

    def figures(table: _Set) -> iso9283.Analysis:
        if isinstance(table, iso9283.Analysis):
            return iso9283.hold_to(table, of_tables) if of_tables else table
        found = inputs.read_series(table, reading, condition if inputs.is_test(table) else None)
        run = found.readings
        as_asked = counting.cycles in (None, int(run.cycle.max()))  # of those that have so many
        counted = found.counted(counting if as_asked else replace(counting, cycles=None))
        return iso9283.analyze(run, counted, limits=of_tables)

    wanted = inputs.sizes_of("limits", limits)
    of_all = {
        name: one
        for name, one in wanted.items()
        if exchangeability and name.startswith("exchangeability")
    }
    of_tables = {name: one for name, one in wanted.items() if name not in of_all}
    one = tables[0] if len(tables) == 1 else None
    sets: list[Any] = list(one if isinstance(one, list | tuple) else tables)
    if condition is not None and not any(map(inputs.is_test, sets)):
        raise UsageError("`condition=` is for the folders of tests", remedy="leave it out")
    analyses = inputs.collect_all(sets, figures, f"of {len(sets)} tables")
    found = comparison.compare(analyses, seed=seed)
    if not exchangeability:
        return found
    return replace(found, characteristics=comparison.exchangeability(analyses, of_all))


@opt.takes_options_of(
    compare,
    tables=opt.argument(
        "Tables of readings (a folder or workbook has several poses); the first is compared "
        "with each of the others; - is standard input.",
        "BEFORE AFTER [MORE]...",
        list[str],
    ),
    exchangeability=opt.option("The tables are of several robots (7.7)."),
    limits=opt.option(
        "Limit of each table, as for analyze: XY=20um; or exchangeability=0.05.",
        "--limit",
        read=opt.parse_limits,
        metavar="[FIGURE=]SIZE",
    ),
    seed=opt.option("Seed of the permutations.", min=0),
    plot=opt.option("Picture, .svg or .png."),
)
def compare_command(
    asked: opt.Asked[Comparison],
    *,
    plot: Path | None = None,
    full: bool = False,
    json: bool = False,
) -> None:
    """Compare runs with the first: changes of mean and RP, with intervals.

    Exit code 1 where a limit is not proven in each table.

    Example: scara-iso compare examples/before_repair.csv examples/after_repair.csv
    """
    tables: list[str] = asked["tables"]
    if tables.count("-") > 1:
        raise UsageError("standard input is read once", remedy="write - for one table only")
    out.check_outputs([], tables, pictures=[plot])
    tests = {
        name: {one.name: one for one in inputs.each_series(name, asked.reading, asked["condition"])}
        for name in tables
        if is_test_folder(name)
    }
    exchangeable: bool = asked["exchangeability"]
    shared = _shared(tests, tables) if tests else [""]
    pictures = {name: out.path_under(plot, name, shared) for name in shared}
    out.check_outputs([*pictures.values()], [])
    options = asked.options("tables", *(("condition", *opt.READING) if tests else ()))
    compared: list[MeasurementSeries] = []
    found: list[Comparison] = []
    for name in shared:
        at = {test: series[name] for test, series in tests.items()}
        if len(out.recorded_among([*at.values()])) < len(at):
            continue
        one = compare([at.get(table, table) for table in tables], **options)
        out.write_picture(one, pictures[name])
        found.append(one)
        for first in list(at.values())[:1]:
            missing = (part for series in at.values() for part in series.missing)
            compared.append(replace(first, missing=tuple(missing)))
        if not json:
            if tests:
                sys.stdout.write(f"{compared[-1].condition}:\n")
            read = {"condition": name} if tests else asked.stated(*opt.READING, *opt.COUNTING)
            again = [opt.command_line([table], read) for table in tables]
            limits = opt.command_line([], {} if exchangeable else asked.stated("limits"))
            out.write_report(reporting.comparison_report(one, again, limits), full=full)
    if json:
        out.write_results(compared, found, of=len(shared))
    out.exit_by(check.verdict for one in found for check in one.limits)


def _shared(
    tests: Mapping[str, Mapping[str, MeasurementSeries]], tables: Sequence[str]
) -> list[str]:
    """Return the conditions that all tables have, in the order of the first, and say the others."""
    every = list(tests.values())
    shared = [name for name in every[0] if all(name in one for one in every)]
    if not shared or (len(shared) > 1 and len(tests) < len(set(tables))):
        what = "no condition is in all of them" if not shared else "a table is of one condition"
        raise UsageError(what, remedy=f"`condition=` is one of {', '.join(every[0])}")
    for table, found in tests.items():
        if left := [name for name in found if name not in shared]:
            out.say(f"scara-iso: {table}: {', '.join(left)} is not in every test: not compared")
    return shared
