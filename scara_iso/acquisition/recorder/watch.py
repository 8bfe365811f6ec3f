"""Gauges looked at again and again, until a dial rests at the pose: the trigger ``settled``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from scara_iso.acquisition.recorder.at_rest import AtRest
from scara_iso.acquisition.recorder.bench import Bench, Taken
from scara_iso.acquisition.recorder.plan import Settled
from scara_iso.quantities import parse_unit


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
        if taken is None:
            self.unread += 1
            return ()
        self.unread = 0
        divisions = {}
        for one in taken:
            axis, text = one.gauge.axis, one.reading.text
            unit = parse_unit(one.reading.unit or one.gauge.unit or "mm")
            self._values[axis] = unit.read(text)
            divisions[axis] = unit.to_base(10.0 ** -len(text.partition(".")[2]))
        if not self._at_rest.arrived(taken[0].time, dict(self._values), divisions, pose):
            return ()
        return () if self._bench.doubt(taken, visit) else taken

    def stored(self, pose: str | None) -> None:
        """Go on from the readings that were returned last: they are on the disk."""
        self._at_rest.stored(self._values, pose)
