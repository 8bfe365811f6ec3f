"""When a dial came to rest at the pose: the rule of ``settled``.

A visit is a movement and then a rest. The dial has moved when it showed more than ``away`` from
where it rested last (at the first visit: from where it stood when the session began). It rests when
all readings of the last ``rest`` seconds, three or more, lie within ``within`` divisions. A free
plunger stands still too: the first visit to a pose is no rest within ``away`` of where the dial
stood when the session began, and each later one is within ``away`` of the visit to that pose
before. So the session begins while the arm is away from the dial.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from scara_iso.acquisition.recorder.plan import Settled

FEWEST = 3
_SLACK = 1e-6
"""Of a division: what rounding in binary adds to a difference of decimals."""


class AtRest:
    """Follows all axes together; values in mm or degrees, times in seconds."""

    def __init__(self, rule: Settled, visits: Mapping[str | None, Mapping[str, float]]) -> None:
        """``visits`` are those before this session, the latest of each pose, the very last last."""
        self._rule = rule
        self._places = dict(visits)
        self._last = next(reversed(self._places.values()), {})
        self._begun: dict[str, float] = {}
        self._moved = False
        self._window: deque[tuple[float, Mapping[str, float]]] = deque()

    def arrived(
        self,
        time: float,
        values: Mapping[str, float],
        divisions: Mapping[str, float],
        pose: str | None = None,
    ) -> bool:
        """Take readings of every axis; return whether they are a visit to ``pose``."""
        self._begun = self._begun or dict(values)
        if self._is_away(values, self._last or self._begun):
            self._moved = True
        if not self._moved:
            return False
        self._window.append((time, values))
        self._shorten(time, divisions)
        if len(self._window) < FEWEST or time - self._window[0][0] < self._rule.rest - _SLACK:
            return False
        if pose in self._places:
            return not self._is_away(values, self._places[pose])
        return self._is_away(values, self._begun)

    def stored(self, values: Mapping[str, float], pose: str | None = None) -> None:
        """Go on from a visit that is on the disk: the next one needs a movement."""
        self._last = self._places[pose] = dict(values)
        self._moved = False
        self._window.clear()

    def _is_away(self, values: Mapping[str, float], place: Mapping[str, float]) -> bool:
        return any(
            abs(value - place[axis]) > self._rule.away
            for axis, value in values.items()
            if axis in place
        )

    def _shorten(self, time: float, divisions: Mapping[str, float]) -> None:
        """Leave the latest readings that lie within the divisions allowed, for one rest at most."""
        while len(self._window) > FEWEST and time - self._window[1][0] >= self._rule.rest:
            self._window.popleft()
        while not self._is_still(divisions):
            self._window.popleft()

    def _is_still(self, divisions: Mapping[str, float]) -> bool:
        for axis, division in divisions.items():
            shown = [values[axis] for _, values in self._window]
            if max(shown) - min(shown) > (self._rule.within + _SLACK) * division:
                return False
        return True
