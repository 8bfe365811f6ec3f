"""Measurement series: readings that are one result, of a table or of a test under one condition."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import Any, TypeAlias

from scara_iso import iso9283, rawfile, reporting, testfolder
from scara_iso.base.errors import NoInputError, UsageError
from scara_iso.iso9283 import AS_THE_TABLE_SAYS, Analysis, Counting, OtherTests
from scara_iso.run import Run

Readable: TypeAlias = Run | BytesIO
"""A run, or the bytes of a table with the ``name`` that it is from."""


def read_other_tests(folder: testfolder.Folder) -> OtherTests:
    """Return what is recorded beside the conditions, held against the limits of each.

    Raises `DataError` for a table that is of another robot, damaged, or there twice.
    """
    testfolder.refuse_faulty(folder, folder.other_tests)
    drift, pushes, test = None, {}, folder.test
    for state in folder.other_tests:
        if state.whole is None:
            continue
        if state.part.is_push:
            pushes[state.part.name] = testfolder.push_of(state.whole, test)
        elif test.drift is not None:
            drift = iso9283.analyze(
                testfolder.completed(state.whole.run, state.part, test),
                limits=test.drift.limits,
                decision=test.decision,
            )
    return OtherTests(
        drift, pushes, tuple(testfolder.lacking(one) for one in folder.other_tests if one.is_open)
    )


def whole_tables(states: Sequence[testfolder.PartState]) -> list[Path]:
    """Return the tables of the parts that are whole."""
    return [one.whole.table for one in states if one.whole]


def files_of(tables: Sequence[Path]) -> Iterator[FileBytes]:
    """Yield tables and their raw files."""
    yield from (with_bytes(f"table {table.name}", table) for table in tables)
    raws = [raw for raw in map(rawfile.raw_path, tables) if raw.exists()]
    yield from (with_bytes(f"raw file {raw.name}", raw) for raw in raws)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class MeasurementSeries:
    """Readings that are one result: those of a table, or of a test's folder under one condition.

    `analyze`, `diagnose`, `report` and `compare` take it in place of a table.
    """

    run: Run | None
    """None where no part of the condition is whole."""
    read: tuple[Readable, ...] = ()
    """Tables, with bytes that cannot change any more."""
    paths: tuple[Path, ...] = ()
    """Files among them, and of a folder the tables of its parts and of its other tests."""
    under: tuple[testfolder.Folder, testfolder.Condition] | None = None
    """The test and its condition; None of a table."""
    missing: tuple[str, ...] = ()
    """Parts that are not recorded."""
    other_tests: OtherTests = field(default_factory=OtherTests)
    """The tests beside the poses, where this is the test's only condition."""

    @property
    def name(self) -> str:
        """That of the condition; empty of a table."""
        return "" if self.under is None else self.condition.name

    @property
    def folder(self) -> testfolder.Folder:
        """That of the test; `TypeError` of a table."""
        return self._of_test()[0]

    @property
    def condition(self) -> testfolder.Condition:
        """Velocity and load of the test; `TypeError` of a table."""
        return self._of_test()[1]

    def _of_test(self) -> tuple[testfolder.Folder, testfolder.Condition]:
        if self.under is None:
            raise TypeError("a table is of no test's folder")
        return self.under

    @property
    def readings(self) -> Run:
        """The run; `NoInputError` with what is missing where there is none."""
        if self.run is None:
            folder = self.folder.path
            raise NoInputError(
                f"nothing is recorded under {self.condition}; missing: {', '.join(self.missing)}",
                where=str(folder),
                remedy=f"scara-iso record {folder}",
            )
        return self.run

    def files(self) -> tuple[FileBytes, ...]:
        """Return what the run is made of: tables; or test.toml, tables and raw files."""
        if self.under is None:
            return tuple(map(_bytes_of, self.read))
        test = with_bytes("test", self.folder.path / testfolder.FILE)
        return (test, *files_of(self.paths))

    def analysis(self, *, counting: Counting = AS_THE_TABLE_SAYS, **options: Any) -> Analysis:
        """Return the analysis; ``options`` stand for those of the test, a decision with limits."""
        if self.under is not None:
            given = {key: value for key, value in options.items() if value not in (None, {}, False)}
            if not given.get("limits"):
                given.pop("decision", None)
            test = self.folder.test
            options = {"limits": dict(test.limits), "decision": test.decision, **given}
        return iso9283.analyze(self.readings, self.counted(counting), **options)

    def counted(self, counting: Counting) -> Counting:
        """Return which cycles count: those of the test unless their number is stated."""
        if counting.cycles or self.under is None:
            return counting
        return replace(counting, cycles=self.folder.test.schedule.cycles_run)


def read_conditions(
    folder: str | Path, condition: str | None = None
) -> tuple[MeasurementSeries, ...]:
    """Return the readings of a test's folder by condition, or of the ``condition`` named.

    Raises `DataError` for a part that is of another robot, damaged, or there twice, and
    `UsageError` for no such condition.
    """
    found = testfolder.read_folder(Path(folder))
    conditions = {one.name: one for one in found.test.conditions()}
    if condition is not None and condition not in conditions:
        raise UsageError(
            f"no condition {condition!r} in {found.path}",
            remedy=f"it has {', '.join(conditions)}",
        )
    wanted = conditions.values() if condition is None else (conditions[condition],)
    alone = condition is None and len(wanted) == 1
    other_tests = read_other_tests(found) if alone else OtherTests()
    others = found.other_tests if other_tests else []
    return tuple(
        MeasurementSeries(
            run=testfolder.run_under(found, one),
            paths=tuple(whole_tables([*found.under(one), *others])),
            under=(found, one),
            missing=tuple(testfolder.lacking(state) for state in found.under(one) if state.is_open),
            other_tests=other_tests,
        )
        for one in wanted
    )


FileBytes: TypeAlias = tuple["reporting.InputFile", bytes]
"""A file that a result is made of, and the very bytes of it."""


def with_bytes(role: str, path: Path) -> FileBytes:
    """Return a file with its bytes."""
    return _file_bytes(role, str(path), path.read_bytes())


def _bytes_of(table: Readable) -> FileBytes:
    from scara_iso.tables import write_table

    if isinstance(table, BytesIO):
        return _file_bytes("table", str(getattr(table, "name", "")), table.getvalue())
    source = table.origin.source
    return _file_bytes("run, as write_table gives it", source, write_table(table).encode())


def _file_bytes(role: str, name: str, data: bytes) -> FileBytes:
    return reporting.InputFile.of(role, name, data), data
