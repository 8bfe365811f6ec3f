"""What was done to a robot, and when: a table with the columns date and what.

Moments as numbers of days, which can be computed with, and as text.
"""

from dataclasses import dataclass, field
from datetime import date, datetime
from pathlib import Path

from scara_iso.base.published import published
from scara_iso.iso9283 import parse_moment
from scara_iso.tables import ColumnNames, read_columns

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


_COLUMNS = ColumnNames(
    what="service events",
    needed=("date", "what"),
    remedy="two columns: date,what and lines such as 2026-05-12,belt of joint 2 renewed",
    labels=frozenset({"date", "what"}),
    aliases={"datum": "date", "day": "date"}
    | dict.fromkeys(("was", "event", "service", "ereignis", "maßnahme"), "what"),
)
_LONGEST = 200


@dataclass(frozen=True, slots=True)
class ServiceEvent:
    """Something that was done to the robot; tests of that day count as behind it."""

    when: datetime = field(metadata=published("date", by=moment_said))
    """With the time of day where one is stated."""
    what: str
    """What was done."""


def read_events(path: str | Path) -> tuple[ServiceEvent, ...]:
    """Return the events of a table in time order; raises as `read_columns`."""
    table = read_columns(path, _COLUMNS)
    events = []
    for line, date_, what in zip(
        table.lines, *(table.labels[n] for n in _COLUMNS.needed), strict=True
    ):
        when = parse_moment(date_)
        if when is None or not is_plausible(when):
            table.faults.add(f"{date_[:60]!r} is not a date", line, 1, remedy=_COLUMNS.remedy)
        else:
            events.append(ServiceEvent(when, what[:_LONGEST]))
    table.faults.check()
    return tuple(sorted(events, key=lambda event: event.when))
