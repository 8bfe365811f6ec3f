"""Whether a command was given the folder of a test, and options that do not go with one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from scara_iso.base.errors import UsageError

if TYPE_CHECKING:
    from scara_iso.library import TableOptions


def test_folder(tables: Sequence[str], condition: str | None, reading: TableOptions) -> str | None:
    """Return the folder of a test where ``tables`` name one, else None.

    Raises `UsageError` for options of a table beside a folder, and for a condition beside a table.
    """
    from scara_iso.testfolder import is_test_folder

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
