"""When a test was made, as its table states it; no clock is asked."""

from __future__ import annotations

from datetime import datetime

from scara_iso.iso9283.checks._stated import first, parse_moment
from scara_iso.iso9283.checks.calibration_date import TEST_DATES
from scara_iso.run import Run

__all__ = ["moment_of_test", "parse_moment"]


def moment_of_test(run: Run) -> datetime | None:
    """Return date (and time, where it is stated) of a test.

    From ``# date`` and the like, or the first of a column `timestamp`; None where neither is there
    or it is no date.
    """
    line = first(run, TEST_DATES)
    return None if line is None else parse_moment(line.text)
