"""Where a session begins: at its first visit, or behind what was recorded before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from scara_iso.acquisition.recorder.history import History


@dataclass(frozen=True, slots=True)
class Position:
    """Where a session begins: the visit, the axes that have it, and what may be voided."""

    visit: int = 1
    present: frozenset[str] = frozenset()
    latest: tuple[tuple[int, str], ...] = ()
    shown: Mapping[str, Sequence[tuple[int, str]]] = field(default_factory=dict)
    """The latest readings of each axis, by visit, as they were shown."""
    values: Mapping[str, float] = field(default_factory=dict)
    """The last reading of each axis [mm or deg]."""

    @classmethod
    def after(cls, history: History) -> Position:
        """Return where a recording goes on."""
        shown = {axis: tuple(column.shown) for axis, column in history.columns.items()}
        last = {axis: readings[max(readings)] for axis, readings in history.readings().items()
                if readings}  # fmt: skip
        return cls(
            history.visit, history.present(history.visit), tuple(history.latest), shown, last
        )
