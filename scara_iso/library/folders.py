"""The folder of a test: `new_test`, its status, and its conditions as runs and analyses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scara_iso import iso9283
from scara_iso.acceptance import (
    FILE,
    Condition,
    Folder,
    lacking,
    merge,
    plan_test,
    read_folder,
    toml_of,
)
from scara_iso.acquisition import raw_path, sha256
from scara_iso.disk import write_file
from scara_iso.errors import CannotCreateError, UsageError
from scara_iso.iso9283 import Analysis
from scara_iso.library.models import plan
from scara_iso.library.reports import TestReport, report
from scara_iso.reporting import InputFile
from scara_iso.robot import read_model
from scara_iso.run import Run


@dataclass(frozen=True, eq=False, slots=True)
class ConditionRun:
    """The readings under one condition; ``run`` is None where no part of it is whole.

    ``options`` are what test.toml states for `analyze`: limits, decision, number of cycles.
    """

    condition: Condition
    run: Run | None
    missing: tuple[str, ...]
    options: Mapping[str, Any]

    def analysis(self, **options: Any) -> Analysis | None:
        """Return the analysis, None without a run; ``options`` stand for those of the test."""
        if self.run is None:
            return None
        return iso9283.analyze(self.run, **self.merged_with(options))

    def merged_with(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """Return the options of the test with those given; a decision goes with its limits."""
        given = {key: value for key, value in options.items() if value not in (None, {}, False)}
        if not given.get("limits"):
            given.pop("decision", None)
        return {**self.options, **given}


def new_test(
    folder: str | Path,
    model: str | Path,
    *,
    velocities: Sequence[float] = (100.0,),
    loads: Sequence[float] = (100.0,),
    **planned: Any,
) -> Path:
    """Make the folder of a test with the test.toml that `plan` gives for a model; return that file.

    ``velocities`` and ``loads`` are in per cent of the rated ones; ``planned`` are options of
    `plan`. Raises as `plan`, and `CannotCreateError` where a test is there already.
    """
    folder, model = Path(folder), Path(model)
    file = folder / FILE
    if file.exists():
        raise CannotCreateError(
            "is there already", where=str(file), remedy="edit it, or name another folder"
        )
    _check_percents({"velocities": velocities, "loads": loads})
    described = read_model(model)
    test = plan_test(
        plan(described, **planned), described, model_path=model, folder=folder,
        velocities=velocities, loads=loads,
    )  # fmt: skip
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotCreateError(
            f"cannot be created ({error.strerror})", where=str(folder), remedy="name another folder"
        ) from error
    write_file(file, toml_of(test).encode())
    return file


def _check_percents(given: Mapping[str, Sequence[float]]) -> None:
    for name, values in given.items():
        wrong = [value for value in values if not 0 <= value <= 100]
        if wrong or not values or len(set(values)) < len(values):
            raise UsageError(
                f"{name} {', '.join(f'{value:g}' for value in values)}: no such test",
                remedy=f"give per cent of the rated ones, each once: `{name}=100,50,10`",
            )


def read_conditions(
    folder: str | Path | Folder, condition: str | None = None
) -> tuple[ConditionRun, ...]:
    """Return the readings of a test's folder by condition, or of the ``condition`` named.

    Raises `DataError` for a part that is of another robot, damaged, or there twice, and
    `UsageError` for no such condition.
    """
    found = folder if isinstance(folder, Folder) else read_folder(Path(folder))
    conditions = {one.name: one for one in found.test.conditions()}
    if condition is not None and condition not in conditions:
        raise UsageError(
            f"no condition {condition!r} in {found.path}",
            remedy=f"it has {', '.join(conditions)}",
        )
    wanted = conditions.values() if condition is None else (conditions[condition],)
    options = {
        "limits": dict(found.test.limits),
        "decision": found.test.decision,
        "cycles": found.test.schedule.cycles_run,
    }
    return tuple(
        ConditionRun(
            one,
            merge(found, one),
            tuple(lacking(s) for s in found.parts if s.part.condition == one and s.is_open),
            options,
        )
        for one in wanted
    )


def report_condition(
    folder: str | Path, measured: ConditionRun, run: Run, options: Mapping[str, Any]
) -> TestReport:
    """Return the report of a condition, made of the folder's files; errors as in `report`."""
    found = report(run, **measured.merged_with(options))
    made = found.dossier.provenance
    files = (*folder_provenance(folder, measured), *made.files[1:])  # the first is the merged run
    dossier = replace(found.dossier, provenance=replace(made, files=files))
    held = {Path(file.name).name: Path(file.name).read_bytes() for file in files}
    tables = tuple(Path(file.name) for file in files if file.role.startswith("table "))
    return replace(found, dossier=dossier, files=held, tables=tables)


def folder_provenance(folder: str | Path, measured: ConditionRun) -> tuple[InputFile, ...]:
    """Return the files that the report of a condition is made of, with their hashes."""
    found = read_folder(Path(folder))
    tables = [
        state.recording.table
        for state in found.parts
        if state.part.condition == measured.condition and state.is_whole and state.recording
    ]
    raws = [raw_path(table) for table in tables]
    return (
        InputFile("test", str(found.path / FILE), sha256(found.path / FILE)),
        *(InputFile(f"table {t.name}", str(t), sha256(t)) for t in tables),
        *(InputFile(f"raw file {r.name}", str(r), sha256(r)) for r in raws if r.exists()),
    )
