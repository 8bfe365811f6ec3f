"""The reports of a test's conditions as one, with the tests beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from scara_iso.base.errors import UsageError
from scara_iso.library.beside import files_of, read_beside, tables_beside
from scara_iso.library.conditions import ConditionRun
from scara_iso.library.held import hold
from scara_iso.library.reports import TestReport
from scara_iso.reporting import Chapter, joined


def join_reports(
    measured: Sequence[ConditionRun], reports: Sequence[TestReport | None]
) -> TestReport:
    """Return one report of all conditions, of those that have one; the others are missing in it.

    With the tests beside them, where there are several (that of one condition has them itself).

    Raises `UsageError` where none has one, `DataError` where they have not the same axes.
    """
    pairs = list(zip(measured, reports, strict=True))
    found = [(one, report) for one, report in pairs if report is not None]
    if not found:
        raise UsageError("no part of the test is recorded", remedy="record one: `record FOLDER`")
    if len(pairs) == 1:
        return found[0][1]
    missing = [part for one, report in pairs if report is None for part in one.missing]
    folder = measured[0].folder
    tables = tuple(tables_beside(folder))
    held = [hold(role, path) for role, path in files_of(tables)]
    dossier = joined([_chapter(one, report) for one, report in found], missing)
    files = {name: data for _, report in found for name, data in report.files.items()}
    return replace(
        found[0][1],
        dossier=dossier.with_beside(read_beside(folder), [file for file, _ in held]),
        files=files | {Path(file.name).name: data for file, data in held},
        tables=(*(path for _, report in found for path in report.tables), *tables),
    )


def _chapter(measured: ConditionRun, report: TestReport) -> Chapter:
    condition = measured.condition
    columns = {"velocity": f"{condition.velocity:g} %", "load": f"{condition.load:g} %"}
    return Chapter(condition.name, columns, report.dossier)
