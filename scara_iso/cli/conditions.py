"""A test's folder in place of a table: each of its conditions is an analysis of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import typer

from scara_iso import reporting
from scara_iso.base.errors import UsageError
from scara_iso.cli.options import NOT_WITHIN_LIMITS
from scara_iso.cli.output import (
    check_outputs,
    command_line,
    say_limits,
    write_picture,
    write_report,
    write_result,
)
from scara_iso.cli.show_comparison import show_comparison
from scara_iso.comparison import published_comparison
from scara_iso.iso9283 import Beside, Conformity
from scara_iso.library import (
    ConditionRun,
    check_format,
    compare,
    join_reports,
    read_beside,
    read_conditions,
    report,
)
from scara_iso.testfolder import is_test_folder

if TYPE_CHECKING:
    from scara_iso.comparison import Comparison
    from scara_iso.library import TestReport
    from scara_iso.reporting import Dossier
    from scara_iso.run import Run
    from scara_iso.testfolder import Folder

Write: TypeAlias = "Callable[[reporting.OfTable], None]"


def analyze_folder(
    folder: str,
    condition: str | None,
    options: Mapping[str, Any],
    *,
    as_json: bool,
    full: bool,
) -> None:
    """Write the analysis of each condition of a test; exit with 1 where a limit is not kept."""
    found = read_conditions(folder, condition)
    beside = read_beside(found[0].folder) if condition is None else Beside()
    analyses = [one.analysis(**options) for one in found]
    if as_json:
        published = reporting.published_folder(folder, found, analyses, beside)
        write_result(published)
    else:
        from scara_iso.reporting import (
            after_analysis,
            analysis_report,
            missing_report,
        )

        for one, analysis in zip(found, analyses, strict=True):
            if analysis is None:
                write_report(missing_report(str(one.condition), one.missing))
                continue
            _say_condition(one, found)
            again = command_line([folder], {"condition": one.condition.name})
            following = after_analysis(analysis, again, again)
            write_report(analysis_report(analysis, following), full=full)
        _write_beside(found[0].folder, beside, full=full)
    verdicts = [None if one is None else one.conformity for one in analyses]
    _exit_by([*verdicts, beside.conformity])


def _write_beside(folder: Folder, beside: Beside, *, full: bool) -> None:
    """Write the tests beside the poses; those that are not recorded are named."""
    if (drift := beside.drift) is not None:
        again = command_line([drift.run.origin.source], {})
        following = reporting.after_analysis(drift, again, again)
        write_report(reporting.analysis_report(drift, following), full=full)
    for found in beside.pushes.values():
        following = reporting.NextStep(f"scara-iso report {folder.path}", "the report of all")
        brief = reporting.push_brief(found, following)
        write_report(reporting.push_report(found) if full else brief)
    if beside.missing:
        write_report(reporting.missing_report("Beside the poses", beside.missing))


def diagnose_folder(
    folder: str,
    condition: str | None,
    diagnose: Callable[[ConditionRun, Run, Write], None],
    *,
    check: Callable[[str], object],
    as_json: bool,
) -> None:
    """Diagnose each condition of a test that has readings; say of the others what is missing.

    ``check`` gets the name of each before the first begins. The JSON objects of several conditions
    go into one.
    """
    found = read_conditions(folder, condition)
    for one in found:
        check(one.condition.name)
    documents: list[reporting.ConditionResult] = []
    for one in found:
        if one.run is None:
            _say_missing(one)
            continue

        def write(result: reporting.OfTable, one: ConditionRun = one) -> None:
            documents.append(reporting.published_condition(one, result))

        if not as_json:
            _say_condition(one, found)
        diagnose(one, one.run, write if len(found) > 1 else write_result)
    if documents:
        _write_conditions(documents)


def report_folder(
    folder: str,
    condition: str | None,
    output: Path | None,
    archive: Path | None,
    options: Mapping[str, Any],
    *,
    as_json: bool,
) -> None:
    """Write one report of a test under all of its conditions, or under the one that is named."""
    given = dict(options)
    excel_locale = given.pop("excel_locale")
    found = read_conditions(folder, condition)
    place = output or (None if as_json else Path(f"{Path(folder).resolve().name}.html"))
    if place is not None:
        check_format(place, excel_locale)
    check_outputs([place, archive], [])
    reports = [None if one.run is None else report(one, **given) for one in found]
    made = [one for one in reports if one is not None]
    _say_not_reported(found, [place, archive])
    if made:
        written = _write_report(join_reports(found, reports), place, archive, excel_locale)
        missing = [
            f"missing: {', '.join(one.missing)}"
            for one in found
            if one.run is not None and one.missing
        ]
        for line in (*written, *(missing if place else ())):
            typer.echo(reporting.printable(line), err=as_json)
    beside = read_beside(found[0].folder) if condition is None else Beside()
    for one, of_it in zip(found, reports, strict=True):
        if of_it is not None:
            say_limits(of_it.analysis, f"{one.condition}: " if len(found) > 1 else "")
    if as_json:
        _write_dossiers(found, [one.dossier for one in made], beside)
    _exit_by([*(one.analysis.conformity for one in made), beside.conformity])


def _say_not_reported(found: Sequence[ConditionRun], files: Sequence[Path | None]) -> None:
    """Say which conditions have no readings and, where none has, which files are not written."""
    silent = [one for one in found if one.run is None]
    for one in silent:
        _say_missing(one)
    for path in files if len(silent) == len(found) else ():
        if path is not None:
            said = f"{path} is not written: nothing is recorded"
            typer.echo(reporting.printable(said), err=True)


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
    found = [(one, comparison) for one, comparison in asked if comparison is not None]
    for one, comparison in found:
        write_picture(comparison, _path(plot, one.condition.name, several=several))
        if not as_json:
            typer.echo(f"{one.condition}:")
            again = [command_line([table], {"condition": one.condition.name}) for table in tables]
            show_comparison(comparison, again, full=full)
    published = [(one, published_comparison(comparison)) for one, comparison in found]
    if as_json and several:
        _write_conditions([reporting.published_condition(*one) for one in published])
    elif as_json and published:
        write_result(published[0][1])
    return [comparison for _, comparison in found]


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
    check_outputs([_path(plot, name, several=len(shared) > 1) for name in shared], [])
    for name in shared:
        of_test = [found[name] for found in tests.values()]
        if any(one.run is None for one in of_test):
            for one in of_test:
                _say_missing(one)
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


def _path(path: Path | None, condition: str, *, several: bool) -> Path | None:
    if path is None or not several:
        return path
    return path.with_name(f"{path.stem}-{condition}{path.suffix}")


def _write_report(
    made: TestReport, place: Path | None, packed: Path | None, excel_locale: str | None
) -> Iterator[str]:
    """Write a report, and its evidence, where wanted; yield what is written."""
    if place is not None:
        yield f"{made.write(place, excel_locale=excel_locale)} is written"
    if packed is not None:
        name = "report.html" if place is None else place.name
        yield f"{made.archive(packed, name=name, excel_locale=excel_locale)} is written"


def _write_dossiers(
    found: Sequence[ConditionRun], dossiers: Sequence[Dossier], beside: Beside
) -> None:
    documents = [reporting.published_report(dossier) for dossier in dossiers]
    if len(found) == 1 and documents:
        write_result(documents[0])
        return
    measured = [one for one in found if one.run is not None]
    _write_conditions(list(map(reporting.published_condition, measured, documents)), beside)


def _write_conditions(
    conditions: Sequence[reporting.ConditionResult], beside: Beside | None = None
) -> None:
    write_result(reporting.published_conditions(conditions, beside))


def _say_condition(one: ConditionRun, found: Sequence[object]) -> None:
    """Write the condition that follows, where a test has several."""
    if len(found) > 1:
        typer.echo(f"{one.condition}:")


def _say_missing(one: ConditionRun) -> None:
    said = "nothing is recorded; " if one.run is None else ""
    said += f"missing: {', '.join(one.missing)}" if one.missing else "every part is recorded"
    typer.echo(reporting.printable(f"{one.folder.path}, {one.condition}: {said}"), err=True)


def _exit_by(verdicts: Sequence[Conformity | None]) -> None:
    if set(verdicts) - {None, Conformity.PASS}:
        raise typer.Exit(NOT_WITHIN_LIMITS)
