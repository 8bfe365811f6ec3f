"""`analyze`: repeatability of a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from scara_iso import iso9283
from scara_iso.base.errors import ScaraIsoError
from scara_iso.iso9283 import Analysis, DecisionRule
from scara_iso.library.inputs import Tables, TablesOptions, parted, paths_of
from scara_iso.library.sizes import sizes_of
from scara_iso.run import stacked

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas as pd


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
    from scara_iso.recorder import check_manifest

    said = {finding.said for finding in analysis.findings}
    found = dict.fromkeys(line for path in paths for line in check_manifest(path))
    changed = [Finding("edited", "warning", line) for line in found if line not in said]
    return replace(analysis, findings=(*analysis.findings, *changed))
