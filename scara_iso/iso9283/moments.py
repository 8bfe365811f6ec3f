"""When a test was made, as its table states it; no clock is asked."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import PurePath

from scara_iso.iso9283.checks._stated import first, parse_moment
from scara_iso.iso9283.checks.calibration_date import TEST_DATES
from scara_iso.run import Run

__all__ = ["moment_in_name", "moment_of_test", "parse_moment", "zoned_moment_of_test"]

_DAY_IN_NAME = re.compile(r"(?<![0-9])[0-9]{4}-[0-9]{2}-[0-9]{2}(?![0-9])")


def moment_of_test(run: Run) -> datetime | None:
    """Return date (and time, where it is stated) of a test.

    From ``# date`` and the like, or the first of a column `timestamp`; None where neither is there
    or it is no date.
    """
    line = first(run, TEST_DATES)
    return None if line is None else parse_moment(line.text)


def zoned_moment_of_test(run: Run) -> datetime | None:
    """Return the same with its time zone, None where none is stated."""
    line = first(run, TEST_DATES)
    try:
        found = None if line is None else datetime.fromisoformat(line.text.strip())
    except ValueError:
        return None
    return found if found is not None and found.tzinfo is not None else None


def moment_in_name(run: Run) -> datetime | None:
    """Return the one day that the name of a table's file spells, where the table states none."""
    found = set(_DAY_IN_NAME.findall(PurePath(run.origin.source).name))
    if first(run, TEST_DATES) is not None or len(found) != 1:
        return None
    return parse_moment(found.pop())
