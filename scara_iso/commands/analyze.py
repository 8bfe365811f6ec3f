"""`analyze`: repeatability of a table of readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Unpack

import typer

from scara_iso import iso9283, render, reporting
from scara_iso.base.errors import ScaraIsoError
from scara_iso.commands.conditions import read_beside, read_conditions
from scara_iso.commands.folders import exit_by, say_condition, test_folder
from scara_iso.commands.inputs import (
    TableOptions,
    Tables,
    TablesOptions,
    parted,
    paths_of,
    sizes_of,
)
from scara_iso.commands.options import (
    NOT_WITHIN_LIMITS,
    AsJson,
    ConditionName,
    Full,
    LimitRule,
    Limits,
    TableNames,
    parse_limits,
    takes_tables,
)
from scara_iso.commands.output import (
    command_line,
    write_json,
    write_report,
    write_result,
)
from scara_iso.iso9283 import Analysis, Beside, Conformity, Counting, DecisionRule
from scara_iso.run import stacked

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas as pd

    from scara_iso.testfolder import Folder


def analyze(
    table: Tables,
    *,
    condition: str | None = None,
    limits: float | Mapping[str, float] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    other_definitions: bool = False,
    **options: Unpack[TablesOptions],
) -> Analysis:
    """Return RP of every pose, axis and plane of a table, with intervals and findings.

    Several tables (a sequence, or the path of a folder) are poses of one test. The folder of a
    test, with test.toml, gives its parts under ``condition`` (``v50-l100``; it may be left out
    where there is one only). Limits, decision and number of cycles are those of test.toml unless
    given, and parts that are missing are deviations; `NoInputError` where all are. Without
    ``condition`` the figures of its drift and push tests are with those of the poses.
    Paper eq. 2-6 and 23, ISO 9283 7.2.1 and 7.2.2. ``unit``, ``resolution`` (in it), ``decimal``,
    ``sheet`` and ``columns`` are as in `read_table`; ``first_cycle_discarded``, ``cycles``,
    ``all_count`` and ``allow_gaps`` say which cycles count. ``limits`` are in mm (degrees for an
    angle) for every length, or by figure (``{"XY": 0.02}``); ``decision`` is
    ``interval`` (a limit is kept or broken where the whole 95 % interval says so) or ``simple``
    (RP alone).
    ``other_definitions`` adds half range, 2 s, 3 s and ISO 230-2. Raises `DataError` for a table
    that cannot be read or breaks the cycle rule, `UsageError` for invalid options.
    """
    reading, counting = parted(**options)
    wanted: dict[str, Any] = {
        "counting": counting,
        "limits": sizes_of("limits", limits),
        "decision": decision,
        "other_definitions": other_definitions,
    }
    if (measured := reading.measured(table, condition)) is not None:
        analysis = iso9283.analyze(measured.readings, **measured.merged_with(wanted))
        return measured.beside.added_to(analysis)
    analysis = iso9283.analyze(reading.read(table), **wanted)
    return compared_with_its_manifest(analysis, table)


class Analyses(list[Analysis | ScaraIsoError]):
    """The analysis of each table, or the error of one that cannot be analysed."""

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: the rows of every analysis, its table in the column ``source``."""
        return stacked([one.to_frame() for one in self if isinstance(one, Analysis)])


def analyze_many(
    tables: Sequence[str | Path], *, executor: Executor | None = None, **options: Any
) -> Analyses:
    """Return the analysis of each of several unrelated tables, in their order; `to_frame` of all.

    One that cannot be analysed gives its error. ``executor`` shares the work, as of
    `concurrent.futures`, else processes of this machine; ``options`` are those of `analyze`.
    """
    from scara_iso.fleets import open_processes

    work = partial(_analyze_one, options=options)
    with nullcontext(executor) if executor is not None else open_processes() as pool:
        return Analyses(pool.map(work, map(str, tables)))


def _analyze_one(table: str, options: Mapping[str, Any]) -> Analysis | ScaraIsoError:
    try:
        return analyze(table, **options)
    except ScaraIsoError as error:
        return error


def compared_with_its_manifest(analysis: Analysis, table: Tables) -> Analysis:
    """Return the analysis with a finding for each file that changed since it was recorded."""
    paths = paths_of(table)
    if not paths:
        return analysis
    from scara_iso.iso9283 import Finding
    from scara_iso.rawfile import check_manifest

    said = {finding.said for finding in analysis.findings}
    found = dict.fromkeys(line for path in paths for line in check_manifest(path))
    changed = [Finding("edited", "warning", line) for line in found if line not in said]
    return replace(analysis, findings=(*analysis.findings, *changed))


@takes_tables
def analyze_command(
    table: TableNames,
    *,
    limit: Limits = None,
    decision: LimitRule = DecisionRule.INTERVAL,
    definitions: Annotated[
        bool, typer.Option("--definitions", help="Also half range, 2 s, 3 s and ISO 230-2.")
    ] = False,
    reading: TableOptions,
    counting: Counting,
    condition: ConditionName = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Repeatability of each pose, axis and plane, with intervals and findings.

    Example: scara-iso analyze run.csv --limit XY=0.02
    """
    options: dict[str, Any] = {
        "limits": parse_limits(limit or ()),
        "decision": decision.value,
        "other_definitions": definitions,
    }
    if (folder := test_folder(table, condition, reading)) is not None:
        options["counting"] = counting
        analyze_folder(folder, condition, options, as_json=json, full=full)
        return
    read = asdict(reading) | asdict(counting)
    analysis = analyze(table, **read, **options)
    if json:
        write_json(render.analysis_json(analysis))
    else:
        following = _next(analysis, table, read, limit, decision)
        write_report(reporting.analysis_report(analysis, following), full=full)
    if analysis.conformity not in (None, Conformity.PASS):
        raise typer.Exit(NOT_WITHIN_LIMITS)


def _next(
    analysis: Analysis,
    table: Sequence[str],
    read: Mapping[str, object],
    limit: Sequence[str] | None,
    decision: DecisionRule,
) -> reporting.NextStep:
    """Return what to do next, as a command line with the options of this one."""
    simple = decision is DecisionRule.SIMPLE
    held = {"limit": limit, "decision": decision.value if simple else None}
    again, whole = command_line(table, read), command_line(table, {**held, **read})
    axis = reporting.axis_of_loop(analysis)
    loop = command_line(table, {"axis": axis, **{k: read[k] for k in ("unit", "resolution")}})
    return reporting.after_analysis(analysis, whole, again, None if axis is None else loop)


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
            say_condition(one, found)
            again = command_line([folder], {"condition": one.condition.name})
            following = after_analysis(analysis, again, again)
            write_report(analysis_report(analysis, following), full=full)
        _write_beside(found[0].folder, beside, full=full)
    verdicts = [None if one is None else one.conformity for one in analyses]
    exit_by([*verdicts, beside.conformity])


def _write_beside(folder: Folder, beside: Beside, *, full: bool) -> None:
    """Write the tests beside the poses; those that are not recorded are named."""
    if (drift := beside.drift) is not None:
        again = command_line([drift.run.origin.source], {})
        following = reporting.after_analysis(drift, again, again)
        write_report(reporting.analysis_report(drift, following), full=full)
    for found in beside.pushes.values():
        following = reporting.NextStep(f"scara-iso report {folder.path}", "the report of all")
        write_report(reporting.push_report(found, following), full=full)
    if beside.missing:
        write_report(reporting.missing_report("Beside the poses", beside.missing))
