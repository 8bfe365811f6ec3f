"""A test's folder in place of a table: what its commands say of each condition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import typer

from scara_iso import reporting
from scara_iso.base.errors import UsageError
from scara_iso.commands.conditions import ConditionRun
from scara_iso.commands.options import NOT_WITHIN_LIMITS
from scara_iso.commands.output import (
    write_result,
)
from scara_iso.iso9283 import Beside, Conformity
from scara_iso.testfolder import is_test_folder

if TYPE_CHECKING:
    from scara_iso.commands.inputs import TableOptions


def test_folder(tables: Sequence[str], condition: str | None, reading: TableOptions) -> str | None:
    """Return the folder of a test where ``tables`` name one, else None.

    Raises `UsageError` for options of a table beside a folder, and for a condition beside a table.
    """
    table = tables[0] if len(tables) == 1 else ""
    if not is_test_folder(table):
        if condition is not None:
            raise UsageError(
                "--condition is for the folder of a test",
                where=table,
                remedy="leave --condition out",
            )
        return None
    given = [name for name, value in asdict(reading).items() if value is not None]
    if given:
        raise UsageError(
            f"`{given[0]}=` is for a table, and each part of a test states its own",
            where=table,
            remedy="leave it out",
        )
    return table


Write: TypeAlias = "Callable[[reporting.OfTable], None]"


def path_under(path: Path | None, condition: str, *, several: bool) -> Path | None:
    """Return the file of one of several conditions: each has its own."""
    if path is None or not several:
        return path
    return path.with_name(f"{path.stem}-{condition}{path.suffix}")


def write_conditions(
    conditions: Sequence[reporting.ConditionResult], beside: Beside | None = None
) -> None:
    """Write the JSON objects of several conditions as one."""
    write_result(reporting.published_conditions(conditions, beside))


def say_condition(one: ConditionRun, found: Sequence[object]) -> None:
    """Write the condition that follows, where a test has several."""
    if len(found) > 1:
        typer.echo(f"{one.condition}:")


def say_missing(one: ConditionRun) -> None:
    """Say on standard error what of a condition is not recorded."""
    said = "nothing is recorded; " if one.run is None else ""
    said += f"missing: {', '.join(one.missing)}" if one.missing else "every part is recorded"
    typer.echo(reporting.printable(f"{one.folder.path}, {one.condition}: {said}"), err=True)


def exit_by(verdicts: Sequence[Conformity | None]) -> None:
    """Exit with 1 where a limit is not kept."""
    if set(verdicts) - {None, Conformity.PASS}:
        raise typer.Exit(NOT_WITHIN_LIMITS)
