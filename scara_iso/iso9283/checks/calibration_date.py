"""The indicator's calibration does not hold on the day of the test.

A figure is traceable as long as the indicator's calibration is in date. State ``# calibration_due``
and the ``# date`` of the test (or a column `timestamp`) as 2026-05-12; a calibration later than the
test says nothing of it either. No clock is asked: only dates in the table are compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import date

from scara_iso.iso9283.checks._stated import TEST_DATES, Stated, first, stated_in
from scara_iso.iso9283.results import Finding, Measured

CODE = "calibration-date"
_DONE = {"calibration_date", "calibrated"}
_DUE = {"calibration_due", "calibration_valid_until", "next_calibration"}
_RULE = "good practice (no clause verified): the indicator is in calibration during the test"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for a calibration that is out of date, or later than the test."""
    done, due, test = (first(measured.run, keys) for keys in (_DONE, _DUE, TEST_DATES))
    if done is None and due is None:
        return
    for line in (done, due, test):
        if line is not None and line.day() is None:
            yield Finding(
                CODE, "info", f"{line}: no date that can be compared", advice="write 2026-05-12"
            )
    if test is not None:
        yield from _against(test, done, due)
    elif due is not None:
        yield Finding(
            CODE,
            "info",
            f"{due} cannot be checked: the date of the test is not stated",
            advice="state '# date' of the test",
        )


def past_due(head: Mapping[str, str], day: date) -> list[str]:
    """Return a remark on each line of a table's head by which a calibration is past on a day."""
    return [
        f"{line} is past: calibrate the indicator, or use another"
        for line in stated_in(head, _DUE)
        if (due := line.day()) is not None and due < day
    ]


def _against(test: Stated, done: Stated | None, due: Stated | None) -> Iterator[Finding]:
    day, first_day, last_day = (None if line is None else line.day() for line in (test, done, due))
    if day and last_day and last_day < day:
        yield Finding(CODE, "warning", f"{due} is past on the day of the test, {test}", rule=_RULE)
    if day and first_day and day < first_day:
        yield Finding(CODE, "warning", f"{done} is later than the test, {test}", rule=_RULE)
