"""What a recording cannot vouch for: a unit that no gauge stated, a frame that may be another's.

Frames carry no number. Where a gauge has sent a frame twice, a reading that says what one of
the two before it said may be that one again, in the place of a frame that was lost. A coarse dial
repeats its readings by itself: nothing is named then.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from scara_iso.iso9283 import SEPARATOR
from scara_iso.recorder.events import LATE, SECOND, TWICE, UNASKED, UNIT_ASKED
from scara_iso.recorder.tape import Record

_SPARE = (LATE, UNASKED, UNIT_ASKED, SECOND, TWICE)
"""Ends of the reasons to refuse a frame that is one too many."""
_BEHIND = 2
"""As many frames later at most a frame comes that was sent twice."""
_BY_CHANCE = 2
"""Times as many repeats as at cycles far apart are no chance, by benchmarks/doubts.py."""


class LineDoubts:
    """Follows the records of a raw file, and says what of them goes into the table's head."""

    def __init__(self) -> None:
        self._unstated: dict[str, str] = {}
        self._unconfirmed: dict[str, str] = {}
        self._poses = 1
        self._axes: dict[str, _Frames] = defaultdict(_Frames)

    def take(self, record: Record) -> None:
        """Take the next record."""
        match record:
            case {"event": "session", "gauges": dict(gauges)}:
                self._poses = len(record.get("poses", ())) or 1
                self._unstated = {
                    str(axis): f"{axis}: {gauge['unit']} as {gauge['unit_from']} states"
                    for axis, gauge in gauges.items()
                    if gauge.get("unit_confirmed") is False
                }
            case {"event": "unit", "axis": str(axis)}:
                self._unstated.pop(axis, None)
            case {"event": "stored", "axis": str(axis)} if axis in self._unstated:
                self._unconfirmed[axis] = self._unstated[axis]
        self._take_frame(record)

    def _take_frame(self, record: Record) -> None:
        match record:
            case {"event": "stored", "axis": str(axis), "text": str(text)}:
                self._axes[axis].store(text, _visit(record), self._poses)
            case {"event": "void", "axes": [*axes]}:
                for axis in axes:
                    self._axes[str(axis)].repeats.pop(_visit(record), None)
            case {"event": "refused", "axis": str(axis), "text": text, "reason": str(reason)}:
                self._axes[axis].refuse(str(text), reason)
            case {"event": "timeout", "axis": str(axis)}:
                self._axes[axis].owed = True

    def metadata(self) -> Iterator[tuple[str, str]]:
        """Yield keys of the table's head, where there is a doubt."""
        if self._unconfirmed:
            said = (f"{line}, not confirmed by the gauge" for line in self._unconfirmed.values())
            yield "record_unit", SEPARATOR.join(said)
        found = {axis: frames.doubted() for axis, frames in self._axes.items()}
        if any(found.values()):
            yield (
                "record_doubted",
                SEPARATOR.join(
                    f"{axis}: {', '.join(visits)}" for axis, visits in found.items() if visits
                ),
            )


@dataclass(slots=True)
class _Frames:
    """What one gauge has sent; a frame sent twice comes behind the next at most."""

    stored: deque[str] = field(default_factory=deque)
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
        said, back = list(self.stored)[::-1], _BEHIND * poses
        if text in said[:_BEHIND]:
            self.repeats[visit] = None
        self.chance += text in said[back : back + _BEHIND]
        self.stored = deque(self.stored, maxlen=back + _BEHIND)
        self.stored.append(text)
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
