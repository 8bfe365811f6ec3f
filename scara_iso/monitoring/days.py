"""Moments as numbers of days, which can be computed with, and as text."""

from __future__ import annotations

from datetime import date, datetime

_SECONDS = 86400
_FIRST, _LAST = 1950, 2150  # years


def is_plausible(when: datetime) -> bool:
    """Return whether a robot can have been tested then: a slip of the pen is no date."""
    return _FIRST <= when.year <= _LAST


def day_of(when: datetime) -> float:
    """Return days since 1970-01-01, as local time reads them."""
    midnight = when.replace(hour=0, minute=0, second=0, microsecond=0)
    start = date(1970, 1, 1).toordinal()
    return when.toordinal() - start + (when - midnight).total_seconds() / _SECONDS


def date_on(day: float) -> str:
    """Return the date of a day since 1970-01-01: ``2026-05-12``."""
    return date.fromordinal(date(1970, 1, 1).toordinal() + int(day // 1)).isoformat()


def moment_said(when: datetime) -> str:
    """Return ``2026-05-12``, with the time of day where there is one: ``2026-05-12T14:30``."""
    day, time = when.date().isoformat(), when.time()
    if not any((time.hour, time.minute, time.second, time.microsecond)):
        return day
    return when.isoformat(timespec="seconds" if time.second or time.microsecond else "minutes")
