"""`analyze`: repeatability of a table of readings."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from scara_iso import reporting
from scara_iso.base.errors import ScaraIsoError
from scara_iso.commands.shared import inputs, options as opt
from scara_iso.commands.shared.output import exit_by, say_condition, write_report, write_result
from scara_iso.commands.shared.series import MeasurementSeries, read_other_tests
from scara_iso.iso9283 import Analysis, DecisionRule, OtherTests
from scara_iso.run import stacked

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas as pd


def analyze(
    table: inputs.Tables,
    *,
    condition: str | None = None,
    limits: inputs.Sizes | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    other_definitions: bool = False,
    **options: Unpack[inputs.TablesOptions],
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
    angle), or with their unit (``"20um"``), for every length, or by figure
    (``{"XY": 0.02}``); ``decision`` is ``interval`` (a limit is kept or broken where the
    whole 95 % interval says so) or ``simple`` (RP alone).
    ``other_definitions`` adds half range, 2 s, 3 s and ISO 230-2. Raises `DataError` for a table
    that cannot be read or breaks the cycle rule, `UsageError` for invalid options.
    """
    reading, counting = inputs.reading_and_counting(analyze, options)
    found = inputs.read_series(table, reading, condition)
    analysis = found.analysis(
        counting=counting,
        limits=inputs.sizes_of("limits", limits),
        decision=decision,
        other_definitions=other_definitions,
    )
    return found.other_tests.added_to(analysis) if found.other_tests else analysis


class Analyses(list[Analysis | ScaraIsoError]):
    """The analysis of each table, or the error of one that cannot be analysed."""

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: the rows of every analysis, its table in the column ``source``."""
        return stacked([one.to_frame() for one in self if isinstance(one, Analysis)])


def analyze_many(
    tables: str | Path | Sequence[str | Path], *, executor: Executor | None = None, **options: Any
) -> Analyses:
    """Return the analysis of each of several unrelated tables, in their order; `to_frame` of all.

    A folder is its tables. One that cannot be analysed gives its error. ``executor`` shares the
    work, as of `concurrent.futures`, else processes of this machine; ``options`` are those of
    `analyze`.
    """
    work = partial(inputs.attempt, partial(analyze, **options))
    return Analyses(inputs.each_of(tables, work, executor))


@opt.takes_options_of(
    analyze,
    other_definitions=opt.option(
        "Other definitions: half range, 2 s, 3 s, ISO 230-2.", "--definitions"
    ),
)
def analyze_command(asked: opt.Asked[Analysis], *, full: bool = False, json: bool = False) -> None:
    """Compute the repeatability RP of each pose, axis and plane, with intervals.

    Example: scara-iso analyze run.csv --limit XY=0.02
    """
    table, condition = asked["table"], asked["condition"]
    found = inputs.each_series(table, asked.reading, condition)
    how = asked.options("table", "condition", *opt.READING, *opt.COUNTING)
    analyses = [
        None if one.run is None else one.analysis(counting=asked.counting, **how) for one in found
    ]
    folder = found[0].folder if found[0].under else None
    other_tests = read_other_tests(folder) if folder and condition is None else OtherTests()
    if json and folder:
        write_result(reporting.published_folder(table[0], found, analyses, other_tests))
    elif json:
        for made in filter(None, analyses):
            write_result(made)
    else:
        following: reporting.NextStep | None = _following(found, analyses, other_tests, asked)
        for one, analysis in zip(found, analyses, strict=True):
            if analysis is None:
                report = reporting.missing_report(str(one.condition), one.missing)
            else:
                say_condition(one, found)
                report, following = reporting.analysis_report(analysis, following), None
            write_report(report, full=full)
        _write_other_tests(other_tests, following, full=full)
    exit_by([*(one.conformity for one in analyses if one), other_tests.conformity])


def _following(
    found: Sequence[MeasurementSeries],
    analyses: Sequence[Analysis | None],
    other_tests: OtherTests,
    asked: opt.Asked[Analysis],
) -> reporting.NextStep:
    """Return the one step that follows: of a whole test what is open, else the report of all."""
    table, limits = asked["table"], asked.stated("limits", "decision")
    others = found[0].folder.other_tests if found[0].under else []
    if any(one.missing for one in found) or any(part.is_open for part in others):
        status = f"scara-iso test status {opt.command_line(table, {})}"
        return reporting.NextStep(status, "which parts are missing")
    steps = []
    for one, analysis in zip(found, analyses, strict=True):
        if analysis is not None:
            read = {} if one.under else asked.stated(*opt.READING, *opt.COUNTING)
            at = {"condition": one.name if len(found) > 1 else asked["condition"]}
            again = opt.command_line(table, read | at)
            whole = opt.command_line(table, limits | read)
            loop = None if one.under else _loop(analysis, asked)
            steps.append(reporting.after_analysis(analysis, whole, again, loop))
    if (drift := other_tests.drift) is not None:
        whole = opt.command_line(table, limits)
        steps.append(reporting.after_analysis(drift, whole, whole))
    return min(steps, key=lambda step: step.command.startswith("scara-iso report"))


def _loop(analysis: Analysis, asked: opt.Asked[Analysis]) -> str | None:
    axis, dial = reporting.axis_of_loop(analysis), asked.stated("unit", "resolution")
    return axis and opt.command_line(asked["table"], {"axis": axis, **dial})


def _write_other_tests(
    other_tests: OtherTests, following: reporting.NextStep | None, *, full: bool
) -> None:
    if (drift := other_tests.drift) is not None:
        write_report(reporting.analysis_report(drift, following), full=full)
        following = None
    for found in other_tests.pushes.values():
        write_report(reporting.push_report(found, following), full=full)
        following = None
    if other_tests.missing:
        write_report(reporting.missing_report("Beside the poses", other_tests.missing), full=full)
