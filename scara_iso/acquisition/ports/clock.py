"""Time for a session: the system's, or one that recorded and simulated streams set.

A session whose ports are all recorded or simulated takes its time from them, so that it gives
the same table, times included, on every run.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Protocol

POLL_S = 0.005
"""Longest wait between two looks at the ports and the keyboard [s]."""


class Clock(Protocol):
    """What a session needs of time."""

    def now(self) -> float:
        """Return the seconds since the clock was made; never goes back."""

    def wall(self) -> str | None:
        """Return the date and time (ISO 8601, UTC), None where time is not the system's."""

    def idle(self, until: float) -> None:
        """Wait a moment, not beyond ``until`` [s]; the ports are read again after it."""


class SystemClock:
    """The machine's monotonic clock and its date."""

    def __init__(self) -> None:
        self._start = time.monotonic()

    def now(self) -> float:
        """Return the seconds since the clock was made."""
        return time.monotonic() - self._start

    def wall(self) -> str | None:
        """Return the date and time, to the microsecond."""
        return datetime.now(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z")

    def idle(self, until: float) -> None:
        """Sleep for `POLL_S`, or less where ``until`` is nearer."""
        time.sleep(max(0.0, min(POLL_S, until - self.now())))


class StreamClock:
    """A clock that jumps to the next byte of its sources; ``paced`` lets it pass in real time."""

    def __init__(self, *, paced: bool) -> None:
        self._now = 0.0
        self._paced = paced
        self._sources: list[Callable[[], float]] = []

    def watch(self, due: Callable[[], float]) -> None:
        """Stop at the time that ``due`` gives, whenever that lies ahead."""
        self._sources.append(due)

    def now(self) -> float:
        """Return the stream's time [s]."""
        return self._now

    def wall(self) -> str | None:
        """Return None: the date of a recorded or simulated stream is not today's."""
        return None

    def idle(self, until: float) -> None:
        """Go to ``until`` or to the next byte, whichever is earlier."""
        target = min([until, *(due() for due in self._sources)])
        if self._paced or math.isinf(target):
            target = min(target, self._now + POLL_S)
            time.sleep(max(0.0, target - self._now))
        self._now = max(self._now, target)
