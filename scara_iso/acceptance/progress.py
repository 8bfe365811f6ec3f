"""How far a test is, and how long is left, from the pace of the parts recorded."""

from __future__ import annotations

import math
from statistics import median

from scara_iso.acceptance.folder import UNFINISHED, Folder, PartState

TIME = "time_s"
_MINUTE_S, _HOUR_S = 60.0, 3600.0


def seconds_a_cycle(folder: Folder) -> float | None:
    """Return the pace: the median over the parts that have times, None where none has."""
    paces = [pace for state in folder.parts if (pace := _pace(state)) is not None]
    return median(paces) if paces else None


def _pace(state: PartState) -> float | None:
    if not state.is_whole or state.recording is None or state.part.beside:
        return None
    times = state.recording.run.covariates.get(TIME)
    if times is None or len(times) < 2:
        return None
    return float(times[-1] - times[0]) / (len(times) - 1)


def cycles_left(folder: Folder) -> int:
    """Return how many cycles are still to be recorded at the poses."""
    left = (one for one in folder.parts if one.is_open and not one.part.beside)
    return sum(_cycles_of(state, folder) for state in left)


def _cycles_of(state: PartState, folder: Folder) -> int:
    if state.state != UNFINISHED or state.recording is None:
        return folder.test.schedule.cycles
    done, wanted = state.recording.cycles
    return max(0, wanted - done)


def seconds_left(folder: Folder) -> float | None:
    """Return how long the poses that lack will take, None where no pace is known.

    A drift test has a pace of its own: None too where nothing but the tests beside them lack.
    """
    pace, left = seconds_a_cycle(folder), cycles_left(folder)
    beside_alone = not left and folder.next is not None
    return None if pace is None or beside_alone else pace * left


def about(seconds: float) -> str:
    """Return a time as it is said: ``about 40 minutes``."""
    if seconds < _MINUTE_S:
        return "less than a minute"
    if seconds < 2 * _HOUR_S:
        minutes = math.ceil(seconds / _MINUTE_S)
        return f"about {minutes} minute{'s' if minutes > 1 else ''}"
    return f"about {seconds / _HOUR_S:.1f} hours"
