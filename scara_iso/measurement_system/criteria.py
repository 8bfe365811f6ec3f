"""What a guideline asks of a figure, and whether it is met.

The guidelines hold the figure itself against their limit, which has room for its chance in it:
that is the rule unless another is chosen. By the rule `interval` a criterion is met where the
whole 95 % interval is on its side, and neither proven nor refuted where the limit is within.
"""

from __future__ import annotations

from dataclasses import dataclass

from scara_iso.iso9283 import Conformity, DecisionRule
from scara_iso.published import Interval


@dataclass(frozen=True, slots=True)
class Criterion:
    """One figure against the limit of a guideline."""

    name: str
    """``Cg``, ``Cgk``, ``resolution/T``, ``Q_MS``, ``R&R/T``, ``ndc`` and the like."""
    of: str
    """The guideline."""
    axis: str
    """Whose dial."""
    value: float | None
    """None where the readings give none."""
    interval: Interval | None
    """95 %; None where it has none."""
    limit: float
    """What the guideline asks for."""
    at_least: bool
    """Whether the figure must be at least the limit; else at most."""
    decision: DecisionRule
    """Whether the figure itself decides, or its interval."""

    @property
    def verdict(self) -> Conformity:
        """What the rule makes of it; without a figure nothing is provable."""
        if self.value is None:
            return Conformity.NOT_PROVABLE
        ends = self.interval if self.decision is DecisionRule.INTERVAL else None
        met = {self._met(end) for end in ends or (self.value,)}
        if len(met) > 1:
            return Conformity.NOT_PROVABLE
        return Conformity.PASS if met == {True} else Conformity.FAIL

    def _met(self, value: float) -> bool:
        return value >= self.limit if self.at_least else value <= self.limit


def worst(criteria: tuple[Criterion, ...]) -> Conformity | None:
    """Return the gravest verdict, None of none."""
    found = {one.verdict for one in criteria}
    for verdict in (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS):
        if verdict in found:
            return verdict
    return None
