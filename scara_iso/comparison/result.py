"""What a comparison yields: frozen figures, their intervals, and what each one decides."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal

from scara_iso.iso9283 import Analysis, Characteristic, Finding

Ends = tuple[float | None, float | None]
"""Of an interval; None where nothing bounds it."""
Quantity = Literal["mean", "RP", "three_sigma"]


class ContrastVerdict(Enum):
    """What a figure's interval decides; the values are those of the JSON object."""

    LESS = "less"
    MORE = "more"
    NOT_SHOWN = "not-shown"
    """The difference is one that chance makes in so few cycles."""
    DIAL = "dial"
    """The difference is one that the two dials' rounding can make."""


@dataclass(frozen=True, slots=True)
class Contrast:
    """One figure of one pose before and after; values in ``unit``.

    Intervals hold together: all those of one quantity and one pair with 95 %.
    """

    figure: str
    """``X``, ``XY`` and so on."""
    pose: str | None
    quantity: Quantity
    unit: str
    before: float
    after: float
    interval: Ends
    """Of the difference, after minus before."""
    ratio_interval: Ends | None
    """Of after over before; None for a mean."""
    p_value: float
    """Among all figures of this quantity and all pairs."""
    p_value_at_floor: bool
    """No deal came as far apart: the chance is at most the p-value."""
    p_value_alone: float
    """As if no other figure had been looked at."""
    verdict: ContrastVerdict
    cycles_needed: int | None
    """Cycles in each run that would show the observed difference in 4 of 5 tests."""
    smallest_shown: float | None
    """What these cycles show in 4 of 5 tests: a distance of means, or a ratio above 1."""
    doubts: tuple[str, ...] = ()
    """Codes of findings of either run that this figure must be read with."""

    @property
    def difference(self) -> float:
        """After minus before."""
        return self.after - self.before

    @property
    def ratio(self) -> float | None:
        """After over before; None for a mean, and where the figure was 0 before."""
        return None if self.quantity == "mean" or self.before == 0 else self.after / self.before


@dataclass(frozen=True, eq=False, slots=True)
class Pair:
    """One run against the first."""

    before: Analysis
    after: Analysis
    means: tuple[Contrast, ...]
    spreads: tuple[Contrast, ...]
    findings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Comparison:
    """Every run against the first of them."""

    pairs: tuple[Pair, ...]
    shuffles: int
    seed: int
    characteristics: tuple[Characteristic, ...] = ()
    """Exchangeability (7.7), where the runs are of several robots and it was asked for."""

    def __repr__(self) -> str:
        shown = {ContrastVerdict.LESS, ContrastVerdict.MORE}
        found = [one for pair in self.pairs for one in (*pair.means, *pair.spreads)]
        changed = sum(one.verdict in shown for one in found)
        return f"<Comparison: {len(self.pairs)} pair(s), {changed} of {len(found)} changes shown>"
