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
    places: Mapping[str | None, Mapping[str, float]] = field(default_factory=dict)
    """The latest readings at each pose, by axis [mm or deg]; the last visit is the last."""

    @classmethod
    def after(cls, history: History) -> Position:
        """Return where a recording goes on."""
        shown = {axis: tuple(column.shown) for axis, column in history.columns.items()}
        return cls(
            history.visit,
            history.present(history.visit),
            tuple(history.latest),
            shown,
            _places(history),
        )


def _places(history: History) -> dict[str | None, dict[str, float]]:
    by_visit: dict[int, dict[str, float]] = {}
    for axis, readings in history.readings().items():
        for visit, value in readings.items():
            by_visit.setdefault(visit, {})[axis] = value
    found: dict[str | None, dict[str, float]] = {}
    for visit in sorted(by_visit):
        pose = history.tour.place(visit)[1]
        found[pose] = found.pop(pose, {}) | by_visit[visit]
    return found
