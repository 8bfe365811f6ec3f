"""The readings of a test's folder, condition by condition, with what test.toml states for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scara_iso import iso9283
from scara_iso.base.errors import NoInputError, UsageError
from scara_iso.iso9283 import AS_THE_TABLE_SAYS, Analysis, Beside, Counting
from scara_iso.run import Run

if TYPE_CHECKING:
    from scara_iso.testfolder import Condition, Folder


def read_beside(folder: Folder) -> Beside:
    """Return what is recorded beside the conditions, held against the limits of each.

    Raises `DataError` for a table that is of another robot, damaged, or there twice.
    """
    from scara_iso.testfolder import drift_of, lacking, push_of, refuse_faulty

    refuse_faulty(folder, folder.beside)
    drift, pushes, test = None, {}, folder.test
    for state in folder.beside:
        if not state.is_whole or state.recording is None:
            continue
        if state.part.is_push:
            pushes[state.part.name] = push_of(state.recording, test)
        elif test.drift is not None:
            drift = iso9283.analyze(
                drift_of(state.recording, test), limits=test.drift.limits, decision=test.decision
            )
    return Beside(drift, pushes, tuple(lacking(one) for one in folder.beside if one.is_open))


def tables_beside(folder: Folder) -> Iterator[Path]:
    """Yield the tables that `read_beside` reads."""
    for state in folder.beside:
        if state.is_whole and state.recording is not None:
            yield state.recording.table


def files_of(tables: Sequence[Path]) -> Iterator[tuple[str, Path]]:
    """Yield tables and their raw files, each with what it is."""
    from scara_iso.rawfile import raw_path

    yield from ((f"table {table.name}", table) for table in tables)
    raws = [raw for raw in map(raw_path, tables) if raw.exists()]
    yield from ((f"raw file {raw.name}", raw) for raw in raws)


@dataclass(frozen=True, eq=False, slots=True)
class ConditionRun:
    """The readings under one condition; ``run`` is None where no part of it is whole.

    `analyze`, `diagnose`, `report` and `compare` take it in place of a table. ``options`` are what
    test.toml states for `analyze`: limits and decision.
    """

    folder: Folder
    condition: Condition
    run: Run | None
    missing: tuple[str, ...]
    options: Mapping[str, Any]
    beside: Beside = field(default_factory=Beside)
    """The tests beside the poses, where this is the test's only condition."""

    @property
    def readings(self) -> Run:
        """The run; `NoInputError` with what is missing where there is none."""
        if self.run is None:
            raise NoInputError(
                f"nothing is recorded under {self.condition}; missing: {', '.join(self.missing)}",
                where=str(self.folder.path),
                remedy=f"scara-iso record {self.folder.path}",
            )
        return self.run

    @property
    def cycles(self) -> int | None:
        """How many were run by the test, None where the cycle rule knows it."""
        return self.folder.test.schedule.cycles_run

    @property
    def tables(self) -> tuple[Path, ...]:
        """The tables of the parts that the run, and what is beside it, are made of."""
        found = [
            state.recording.table
            for state in self.folder.under(self.condition)
            if state.is_whole and state.recording
        ]
        return (*found, *(tables_beside(self.folder) if self.beside else ()))

    def files(self) -> Iterator[tuple[str, Path]]:
        """Yield what the run is made of: test.toml, tables, raw files."""
        from scara_iso.testfolder import FILE

        yield "test", self.folder.path / FILE
        yield from files_of(self.tables)

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
        given["counting"] = self.counted(given.get("counting", AS_THE_TABLE_SAYS))
        return {**self.options, **given}

    def counted(self, counting: Counting) -> Counting:
        """Return which cycles count: those of the test unless their number is stated."""
        return counting if counting.cycles else replace(counting, cycles=self.cycles)


def read_conditions(
    folder: str | Path | Folder, condition: str | None = None
) -> tuple[ConditionRun, ...]:
    """Return the readings of a test's folder by condition, or of the ``condition`` named.

    Raises `DataError` for a part that is of another robot, damaged, or there twice, and
    `UsageError` for no such condition.
    """
    from scara_iso.testfolder import lacking, read_folder, run_under  # and with it all of recording

    found = read_folder(Path(folder)) if isinstance(folder, str | Path) else folder
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
    }
    return tuple(
        ConditionRun(
            found,
            one,
            run_under(found, one),
            tuple(lacking(state) for state in found.under(one) if state.is_open),
            options,
            read_beside(found) if condition is None and len(wanted) == 1 else Beside(),
        )
        for one in wanted
    )


def read_condition(folder: str | Path, condition: str | None) -> ConditionRun:
    """Return the readings under ``condition``, or the only one; errors as `read_conditions`.

    `UsageError` where there are several and none is named: they are never mixed.
    """
    from scara_iso.testfolder import read_folder

    found = read_folder(Path(folder))
    names = [one.name for one in found.test.conditions()]
    if condition is None and len(names) > 1:
        raise UsageError(
            f"{folder} holds {len(names)} conditions, and each is a result of its own",
            remedy=f"name one: `condition={names[0]}`, or {', '.join(names[1:10])}",
        )
    return read_conditions(found, condition)[0]
