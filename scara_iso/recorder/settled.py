"""When a dial came to rest at the pose: the rule of ``settled``, and the gauges that it looks at.

A visit is a movement and then a rest. The dial has moved when it showed more than ``away`` from
where it rested last (at the first visit: from where it stood when the session began). It rests when
all readings of the last ``rest`` seconds, three or more, lie within ``within`` divisions. A free
plunger stands still too: the first visit to a pose is not a rest within ``away`` of where the dial
stood when the session began, and each later one is within ``away`` of the visit to that pose
before. So the session begins while the arm is away from the dial.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

from scara_iso.base.quantities import parse_unit
from scara_iso.recorder.bench import Bench, Taken
from scara_iso.recorder.plan import Settled

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
        self._moved = self._moved or self._is_away(values, self._last or self._begun)
        if not self._moved:
            return False
        window = self._window
        window.append((time, values))
        while len(window) > FEWEST and time - window[1][0] >= self._rule.rest:
            window.popleft()
        while not self._is_still(divisions):
            window.popleft()
        if len(window) < FEWEST or time - window[0][0] < self._rule.rest - _SLACK:
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
        near = {axis: abs(values[axis] - place[axis]) for axis in values if axis in place}
        return any(distance > self._rule.away for distance in near.values())

    def _is_still(self, divisions: Mapping[str, float]) -> bool:
        for axis, division in divisions.items():
            shown = [values[axis] for _, values in self._window]
            if max(shown) - min(shown) > (self._rule.within + _SLACK) * division:
                return False
        return True


class Watch:
    """What the gauges show, and whether it is a visit; ``unread`` looks in a row had no answer."""

    def __init__(
        self, bench: Bench, rule: Settled, visits: Mapping[str | None, Mapping[str, float]]
    ) -> None:
        self._bench = bench
        self._at_rest = AtRest(rule, visits)
        self._values: dict[str, float] = {}
        self.unread = 0

    def look(self, visit: int, pose: str | None) -> Sequence[Taken]:
        """Return the readings of every gauge where they rest at the pose awaited, else none."""
        taken = self._bench.measure(1)
        self.unread = 0 if taken else self.unread + 1
        divisions = {}
        for one in taken or ():
            axis, text = one.gauge.axis, one.reading.text
            unit = parse_unit(one.reading.unit or one.gauge.unit or "mm")
            self._values[axis] = unit.read(text)
            divisions[axis] = unit.to_base(float(one.reading.resolution))
        if taken and self._at_rest.arrived(taken[0].time, dict(self._values), divisions, pose):
            return () if self._bench.doubt(taken, visit) else taken
        return ()

    def stored(self, pose: str | None) -> None:
        """Go on from the readings that were returned last: they are on the disk."""
        self._at_rest.stored(self._values, pose)
