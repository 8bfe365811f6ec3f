"""The time of a raw file's records over all its sessions: it never goes back."""

from __future__ import annotations

from datetime import datetime

from scara_iso.acquisition.tape import Record

_SET_S = 5.0
"""A clock that differs by more from the time that passed was set [s]."""


class Timeline:
    """Seconds since the first session began; between sessions the machine's date counts.

    A date that goes back lets the next session begin where the one before ended. `jumps` says
    where the clock cannot have been right.
    """

    def __init__(self) -> None:
        self.start = self._last = 0.0
        self._begun: tuple[str | None, float] = (None, 0.0)
        self._latest: tuple[str | None, float] = (None, 0.0)
        self._sessions = 0
        self._jumps: list[str] = []

    def at(self, record: Record) -> float:
        """Return the time of the next record [s]."""
        t, wall = float(record["t"]), record.get("wall")
        if record["event"] == "session":
            self._begin(wall, t)
        time = self.start + t
        self._last = max(self._last, time)
        self._latest = (wall, t)
        return time

    @property
    def jumps(self) -> tuple[str, ...]:
        """What is wrong with the dates, a sentence each."""
        return (*self._jumps, *self._set_within())

    def _begin(self, wall: str | None, t: float) -> None:
        self._jumps += self._set_within()
        gap = _seconds(self._latest[0], wall)
        self._sessions += 1
        if gap < 0:
            self._jumps.append(
                f"the clock went back {-gap:.0f} s before session {self._sessions}: its time_s "
                "begins where the session before ended"
            )
        self.start = self._last + max(0.0, gap) - (t if self._sessions > 1 else 0.0)
        self._begun = (wall, t)

    def _set_within(self) -> list[str]:
        (began, first), (ended, last) = self._begun, self._latest
        off = _seconds(began, ended) - (last - first)
        if None in (began, ended) or abs(off) < _SET_S:
            return []
        return [f"the clock was set by {off:+.0f} s during session {self._sessions}"]


def _seconds(start: str | None, now: str | None) -> float:
    if start is None or now is None:
        return 0.0
    return (datetime.fromisoformat(now) - datetime.fromisoformat(start)).total_seconds()
