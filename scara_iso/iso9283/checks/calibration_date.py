"""The indicator's calibration does not hold on the day of the test.

State ``# calibration_due`` and the ``# date`` of the test (or a column `timestamp`) as 2026-05-12;
a calibration after the test does not cover it. Only the dates in the table are compared.
"""

from collections.abc import Mapping
from datetime import date

from scara_iso.iso9283.checks._stated import TEST_DATES, first, stated
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "calibration-date"
_DONE = {"calibration_date", "calibrated"}
_DUE = {"calibration_due", "calibration_valid_until", "next_calibration"}
_RULE = "good practice (no clause verified): the indicator is in calibration during the test"


def check(measured: Measured) -> Findings:
    """Yield a warning for a calibration that is out of date, or later than the test."""
    lines = [first(measured.run, keys) for keys in (_DONE, _DUE, TEST_DATES)]
    done, due, test = lines
    days = [None if line is None else line.day() for line in lines]
    for line, day in zip(lines, days, strict=True):
        if line is not None and day is None:
            yield line.unclear(CODE, "date", "2026-05-12")
    if test is None and due is not None:
        what = f"{due} cannot be checked: the date of the test is not stated"
        yield Finding(CODE, "info", what, advice="state '# date' of the test")
    first_day, last_day, day = days
    if day and last_day and last_day < day:
        yield Finding(CODE, "warning", f"{due} is past on the day of the test, {test}", rule=_RULE)
    if day and first_day and day < first_day:
        yield Finding(CODE, "warning", f"{done} is later than the test, {test}", rule=_RULE)


def past_due(head: Mapping[str, str], day: date) -> list[str]:
    """Return a remark on each line of a table's head by which a calibration is past on a day."""
    return [
        f"{line} is past: calibrate the indicator, or use another"
        for line in stated(head, _DUE)
        if (due := line.day()) is not None and due < day
    ]
