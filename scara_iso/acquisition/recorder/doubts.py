"""What a recording cannot vouch for: a unit that no gauge stated, a frame that may be another's.

Frames carry no number. Where a gauge has sent a frame twice, a reading that says what one of
the two before it said may be that one again, in the place of a frame that was lost.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator

from scara_iso.acquisition.tape import Record
from scara_iso.iso9283 import SEPARATOR

_BOUNCED = "came within"
"""The line heard the key twice, not the frame."""


class LineDoubts:
    """Follows the records of a raw file, and says what of them goes into the table's head."""

    def __init__(self) -> None:
        self._unstated: dict[str, str] = {}
        self._unconfirmed: dict[str, str] = {}
        self._said: dict[str, deque[str]] = defaultdict(_latest)
        self._heard: dict[str, deque[str]] = defaultdict(_latest)
        self._twice: set[str] = set()
        self._repeats: dict[str, dict[str, None]] = {}

    def take(self, record: Record) -> None:
        """Take the next record."""
        match record:
            case {"event": "session", "gauges": dict(gauges)}:
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
                if text in self._said[axis]:
                    self._repeats.setdefault(axis, {})[_visit(record)] = None
                self._said[axis].append(text)
                self._heard[axis].append(text)
            case {"event": "void", "axes": [*axes]}:
                for axis in axes:
                    self._repeats.get(str(axis), {}).pop(_visit(record), None)
            case {"event": "refused", "axis": str(axis), "text": text, "reason": str(reason)}:
                if text in self._heard[axis] and not reason.startswith(_BOUNCED):
                    self._twice.add(axis)
                self._heard[axis].append(str(text))

    def metadata(self) -> Iterator[tuple[str, str]]:
        """Yield keys of the table's head, where there is a doubt."""
        if self._unconfirmed:
            said = (f"{line}, not confirmed by the gauge" for line in self._unconfirmed.values())
            yield "record_unit", SEPARATOR.join(said)
        found = {axis: visits for axis, visits in self._repeats.items() if axis in self._twice}
        if any(found.values()):
            yield (
                "record_doubted",
                SEPARATOR.join(
                    f"{axis}: {', '.join(visits)}" for axis, visits in found.items() if visits
                ),
            )


def _latest() -> deque[str]:
    """Return the last two frames of a gauge: one sent twice comes behind the next at most."""
    return deque(maxlen=2)


def _visit(record: Record) -> str:
    at = f" at {record['pose']}" if "pose" in record else ""
    return f"cycle {record['cycle']}{at}"
