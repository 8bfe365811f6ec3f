"""What was struck out and noted in a recording, in words for the head of its table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scara_iso.acquisition.tape import Record

_MOST = 99


class Remarks:
    """Collects struck readings with their reasons, notes, and why recording stopped, in order."""

    def __init__(self) -> None:
        self._said: list[tuple[str, str]] = []

    def take(self, record: Record, shown: Mapping[str, str]) -> None:
        """Take a record; ``shown`` holds the readings that a ``void`` strikes out, by axis."""
        match record:
            case {"event": "void", "cycle": int(cycle), "reason": str(reason)}:
                values = ", ".join(f"{axis} {text}" for axis, text in sorted(shown.items()))
                at = f" at {record['pose']}" if "pose" in record else ""
                self._said.append(("struck", f"cycle {cycle}{at}, {values}: {reason}"))
            case {"event": "note", "text": str(text)}:
                self._said.append(("note", text))
            case {"event": "changed", "axis": str(axis), "message": str(message)}:
                self._said.append(("changed", f"{axis}: {message}"))

    def metadata(self) -> Iterator[tuple[str, str]]:
        """Yield a key and its text for each remark; beyond the first 99 only their number."""
        for number, (kind, text) in enumerate(self._said[:_MOST], 1):
            yield f"record_{number:02d}_{kind}", text
        if len(self._said) > _MOST:
            yield "record_more_remarks", str(len(self._said) - _MOST)
