"""When each row was read: instants, or a clock's time of day, to seconds from the first row."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from scara_iso.run import FloatArray, IntArray, Run
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults
from scara_iso.tables.header import called
from scara_iso.tables.names import CLOCKS, DATES, Column, Kind, plain_key
from scara_iso.tables.numbers import BLANKS

_CLOCK = re.compile(
    r"([01]?[0-9]|2[0-3]):([0-5][0-9]):([0-5][0-9](?:[.,][0-9]{1,9})?)(?: ?([ap])\.?m\.?)?",
    re.IGNORECASE,
)
_DAY, _NOON = 86_400.0, 43_200.0
_STAMP = "write date and time as 2026-05-12T08:30:00 in a column timestamp"


def seconds_of_stamps(
    column: Column, columns: Columns, lines: IntArray, metadata: dict[str, str], faults: Faults
) -> FloatArray:
    """Return seconds from the first row's instant, which is kept as ``timestamp_start``."""
    stamps = [stamp for stamp in columns.stamps(column) if stamp is not None]
    start = stamps[0]
    for line, stamp in zip(lines.tolist(), stamps, strict=True):
        if (stamp.tzinfo is None) != (start.tzinfo is None):
            faults.add(
                "some times state their offset from UTC and some do not",
                line,
                column.position + 1,
                remedy="write all times with their offset, as +01:00, or all without",
            )
            return np.zeros(len(lines))
    metadata.setdefault("timestamp_start", start.isoformat())
    return np.array([(stamp - start).total_seconds() for stamp in stamps])


def with_clock(run: Run, columns: Columns) -> tuple[Run, dict[Column, str]]:
    """Return the run with the times of a clock's column as ``time_s``, where they are sure.

    They are where they go on from row to row, or within each pose, and pass midnight once at most.
    Beside the run is what to say of each clock, used or not.
    """
    layout = columns.layout
    clocks = [c for c in layout.of(Kind.COMMENT) if plain_key(c.name) in CLOCKS]
    said: dict[Column, str] = {}
    for column in clocks:
        found = (
            "there is another time" if "time_s" in run.covariates else _times(run, columns, column)
        )
        if isinstance(found, str):
            said[column] = f"{called(layout, column)} not used as the time: {found}"
            continue
        first = str(columns.labels(column)[0]).strip(BLANKS)
        said[column] = f"{called(layout, column)} is the time of each row, from {first} on"
        run = replace(run, covariates={**run.covariates, "time_s": found})
    return run, said


def _times(run: Run, columns: Columns, column: Column) -> FloatArray | str:
    """Return seconds from the first row, shape (rows,), or why the clock does not tell them."""
    read = [_seconds_of_day(str(cell)) for cell in columns.labels(column)]
    lines, row = columns.all_lines(), columns.faults.row
    wrong = next((k for k, seconds in enumerate(read) if seconds is None), None)
    if wrong is not None:
        return f"{row} {lines[wrong]} holds no time such as 14:03:22"
    day = np.array(read, dtype=np.float64)
    backward = np.flatnonzero(np.diff(day) < 0) + 1
    midnights = backward[np.diff(day)[backward - 1] < -_NOON]
    named = [c for c in columns.layout.of(Kind.COMMENT) if plain_key(c.name) in DATES]
    dates = [labels for labels in map(columns.labels, named) if all(labels)]
    changes = [np.flatnonzero(date[1:] != date[:-1]) + 1 for date in dates]
    if not all(np.array_equal(rows, midnights) for rows in changes):
        return f"the date changes at other rows than at midnight; {_STAMP}"
    if len(midnights) > 1:
        return f"it passes midnight {len(midnights)} times; {_STAMP}"
    in_turn = all(np.all(np.diff(day[rows]) >= 0) for _, rows in run.rows_by_pose())
    if len(backward) > len(midnights) and (len(midnights) or not in_turn):
        return f"it goes back in {row} {lines[backward[0]]}; {_STAMP}"
    if np.ptp(day) == 0:
        return "it stands still"
    passed = np.arange(len(day)) >= (midnights[0] if len(midnights) else len(day))
    return np.asarray(np.round(day + _DAY * passed - day[0], 9))


def _seconds_of_day(text: str) -> float | None:
    found = _CLOCK.fullmatch(text.strip(BLANKS))
    if found is None:
        return None
    hour, minute, second = int(found[1]), int(found[2]), float(found[3].replace(",", "."))
    if found[4]:
        hour = hour % 12 + 12 * (found[4].lower() == "p")
    return hour * 3600 + minute * 60 + second
