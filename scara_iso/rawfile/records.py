"""What the records of a raw file say together: where, when, how sure, and how large.

`Tour` numbers the visits, `Timeline` gives the time over all sessions, `LineDoubts` follows what a
recording cannot vouch for, and `sizes_of_axis` reads what its head states of an indicator.
"""

from __future__ import annotations

import re
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import datetime

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension
from scara_iso.rawfile.integrity import Record
from scara_iso.run import SEPARATOR

_SIZE_KEY = re.compile(r"indicator_uncertainty(_(x|y|z|theta))?|command_(x|y|z|theta)")
_NUMBER = re.compile(r"[+-]?[0-9]{1,6}(\.[0-9]{1,12})?")


def _sizes(metadata: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    """Return what states a size, by its plain key: the key and the text as they are."""
    plain = {key.lower().replace(" ", "_").replace("-", "_"): key for key in metadata}
    return {k: (key, str(metadata[key])) for k, key in plain.items() if _SIZE_KEY.fullmatch(k)}


def wrong_sizes(metadata: Mapping[str, str]) -> list[str]:
    """Return the keys whose size is not a plain number, or whose uncertainty is not positive."""
    return [
        key
        for plain, (key, text) in _sizes(metadata).items()
        if not _NUMBER.fullmatch(text) or (plain.startswith("indicator") and float(text) <= 0)
    ]


def sizes_of_axis(
    metadata: Mapping[str, str], axis: str, dimension: Dimension
) -> tuple[float | None, float | None]:
    """Return standard uncertainty and command pose of an axis [mm or deg], None where not stated.

    ``indicator_uncertainty`` without an axis is a length: that of every axis read in mm.
    """
    if wrong := wrong_sizes(metadata):
        raise DataError(f"{wrong[0]}: not a plain number")
    stated = {plain: float(text) for plain, (_, text) in _sizes(metadata).items()}
    general = stated.get("indicator_uncertainty") if dimension is Dimension.LENGTH else None
    name = axis.lower()
    return stated.get(f"indicator_uncertainty_{name}", general), stated.get(f"command_{name}")


@dataclass(frozen=True, slots=True)
class Tour:
    """``poses`` in the order in which every cycle visits them; none is one pose without a name.

    Visits are numbered from 1 through the whole test: those of cycle 1, of cycle 2, and so on.
    """

    poses: tuple[str, ...] = ()

    def __len__(self) -> int:
        return max(len(self.poses), 1)

    def place(self, visit: int) -> tuple[int, str | None]:
        """Return cycle (from 1) and pose of a visit."""
        turn, k = divmod(visit - 1, len(self))
        return turn + 1, self.poses[k] if self.poses else None

    def visit(self, cycle: int, pose: str | None) -> int:
        """Return the number of a visit; `ValueError` for a pose that is not visited."""
        poses: tuple[str | None, ...] = self.poses or (None,)
        if pose not in poses:
            raise ValueError(f"pose {pose} is not one of {', '.join(map(str, poses))}")
        return (cycle - 1) * len(poses) + poses.index(pose) + 1

    def name(self, visit: int) -> str:
        """Return ``cycle 3`` or ``cycle 3 at P2``."""
        cycle, pose = self.place(visit)
        return f"cycle {cycle}" if pose is None else f"cycle {cycle} at {pose}"

    def state(self, visit: int) -> dict[str, int | str]:
        """Return cycle, and pose where poses have names, as a raw file states them."""
        cycle, pose = self.place(visit)
        return {"cycle": cycle} if pose is None else {"cycle": cycle, "pose": pose}


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


LATE = "late, or not asked for"
UNASKED = "not asked for"
UNIT_ASKED = "the unit was asked for"
SECOND = "a second answer to one request"
TWICE = "sent twice"
"""Why a frame is refused that no request called for, and no visit."""

_SPARE = (LATE, UNASKED, UNIT_ASKED, SECOND, TWICE)
"""Ends of the reasons to refuse a frame that is one too many."""
_BEHIND = 2
"""As many frames later at most a frame comes that was sent twice."""
_BY_CHANCE = 2
"""Times as many repeats as at cycles far apart are no chance, by benchmarks/doubts.py."""


class LineDoubts:
    """Follows the records of a raw file: a unit that no gauge stated, a frame of another visit.

    Frames carry no number. Where a gauge has sent a frame twice, a reading that says what one of
    the two before it said may be that one again, in the place of a frame that was lost. A coarse
    dial repeats its readings by itself: nothing is named then.
    """

    def __init__(self) -> None:
        self._unstated: dict[str, str] = {}
        self._unconfirmed: dict[str, str] = {}
        self._poses = 1
        self._axes: dict[str, _Frames] = defaultdict(_Frames)

    def take(self, record: Record) -> None:
        """Take the next record."""
        match record:
            case {"event": "session", "gauges": dict(gauges)}:
                self._poses = max(1, len(record.get("poses", ())))
                self._unstated = {
                    str(axis): f"{axis}: {gauge['unit']} as {gauge['unit_from']} states"
                    for axis, gauge in gauges.items()
                    if gauge.get("unit_confirmed") is False
                }
            case {"event": "unit", "axis": str(axis)}:
                self._unstated.pop(axis, None)
            case {"event": "stored", "axis": str(axis), "text": str(text)}:
                if axis in self._unstated:
                    self._unconfirmed[axis] = self._unstated[axis]
                self._axes[axis].store(text, _visit(record), self._poses)
            case {"event": "void", "axes": [*axes]}:
                self._void(axes, _visit(record))
            case {"event": "refused", "axis": str(axis), "text": text, "reason": str(reason)}:
                self._axes[axis].refuse(str(text), reason)
            case {"event": "timeout", "axis": str(axis)}:
                self._axes[axis].owed = True

    def _void(self, axes: Iterable[object], visit: str) -> None:
        for axis in axes:
            self._axes[str(axis)].repeats.pop(visit, None)

    def metadata(self) -> Iterator[tuple[str, str]]:
        """Yield keys of the table's head, where there is a doubt."""
        if self._unconfirmed:
            said = (f"{line}, not confirmed by the gauge" for line in self._unconfirmed.values())
            yield "record_unit", SEPARATOR.join(said)
        found = {axis: ", ".join(frames.doubted()) for axis, frames in self._axes.items()}
        if doubted := [f"{axis}: {visits}" for axis, visits in found.items() if visits]:
            yield "record_doubted", SEPARATOR.join(doubted)


@dataclass(slots=True)
class _Frames:
    """What one gauge has sent; a frame sent twice comes behind the next at most."""

    stored: list[str] = field(default_factory=list)
    """The latest first."""
    heard: deque[str] = field(default_factory=lambda: deque(maxlen=_BEHIND))
    repeats: dict[str, None] = field(default_factory=dict)
    """The visits that say what one of the two before said."""
    chance: int = 0
    """How many say what one of two says that are too far back, at the same poses."""
    twice: bool = False
    owed: bool = False
    """Whether an answer was awaited in vain: the next frame may be that one."""

    def store(self, text: str, visit: str, poses: int) -> None:
        """Take a reading."""
        said, back = self.stored, _BEHIND * poses
        if text in said[:_BEHIND]:
            self.repeats[visit] = None
        self.chance += text in said[back : back + _BEHIND]
        self.stored = [text, *said[: back + _BEHIND - 1]]
        self._hear(text)

    def refuse(self, text: str, reason: str) -> None:
        """Take a frame that is no reading."""
        self.twice |= text in self.heard and not self.owed and reason.endswith(_SPARE)
        self._hear(text)

    def doubted(self) -> tuple[str, ...]:
        """Return the visits in doubt: none where the dial repeats its readings by itself."""
        rare = len(self.repeats) > _BY_CHANCE * self.chance
        return tuple(self.repeats) if self.twice and rare else ()

    def _hear(self, text: str) -> None:
        self.heard.append(text)
        self.owed = False


def _visit(record: Record) -> str:
    at = f" at {record['pose']}" if "pose" in record else ""
    return f"cycle {record['cycle']}{at}"
