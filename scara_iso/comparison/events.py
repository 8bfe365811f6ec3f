"""What was done to a robot, and when: a table with the columns date and what.

Moments as numbers of days, which can be computed with, and as text.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from datetime import date, datetime
from pathlib import Path

from scara_iso.base.errors import DataError, Fault
from scara_iso.base.files import read_file
from scara_iso.base.published import published
from scara_iso.iso9283 import parse_moment

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


_LARGEST = 1_000_000
_REMEDY = "two columns: date,what and lines such as 2026-05-12,belt of joint 2 renewed"
_LONGEST = 200


@dataclass(frozen=True, slots=True)
class ServiceEvent:
    """Something that was done to the robot; tests of that day count as behind it."""

    when: datetime = field(metadata=published("date", by=moment_said))
    """With the time of day where one is stated."""
    what: str
    """What was done."""


def read_events(path: str | Path) -> tuple[ServiceEvent, ...]:
    """Return the events of a table in time order; commas or semicolons, UTF-8.

    Raises `NoInputError` where there is none, `DataError` with every faulty line.
    """
    try:
        text = read_file(path, _LARGEST).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError("is not UTF-8", where=str(path), remedy="save it as UTF-8") from error
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip(" ;,\t")]
    lines = [(k, line) for k, line in lines if not line.lstrip().startswith("#")]
    if not lines:
        raise DataError("no event is there", where=str(path), remedy=_REMEDY)
    mark = ";" if ";" in lines[0][1] else ","
    header = [cell.strip().lower() for cell in lines[0][1].split(mark)]
    if header[:2] != ["date", "what"]:
        raise DataError(
            f"line {lines[0][0]}: no header date{mark}what", where=str(path), remedy=_REMEDY
        )
    events, faults = [], []
    for number, line in lines[1:]:
        cells = [cell.strip() for cell in next(csv.reader([line], delimiter=mark))]
        when = parse_moment(cells[0])
        if when is None or not is_plausible(when) or len(cells) < 2 or not cells[1]:
            faults.append(Fault(f"{line.strip()[:60]!r} is not a line 'date,what'", number))
        else:
            events.append(ServiceEvent(when, cells[1][:_LONGEST]))
    if faults:
        raise DataError(
            f"{len(faults)} lines cannot be read", where=str(path), remedy=_REMEDY, faults=faults
        )
    return tuple(sorted(events, key=lambda event: event.when))
