"""What a comparison yields: frozen figures, their intervals, and what each one decides."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, Literal

from scara_iso.display import Plotted
from scara_iso.frames import frame_of, or_nan
from scara_iso.iso9283 import Analysis, Characteristic, Finding

if TYPE_CHECKING:
    import pandas as pd

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
    """Label; None for runs of one pose."""
    quantity: Quantity
    """What is compared."""
    unit: str
    before: float
    """Value of the first run, in `unit`."""
    after: float
    """Value of the other run, in `unit`."""
    interval: Ends
    """Of the difference, after minus before."""
    ratio_interval: Ends | None
    """Of after over before; None for a mean."""
    p_value: float
    """Among all figures of this quantity and all pairs."""
    p_value_at_floor: bool
    """No permutation came as far apart: the chance is at most the p-value."""
    p_value_alone: float
    """As if no other figure had been looked at."""
    verdict: ContrastVerdict
    """Whether the difference is shown, and which way."""
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
    """The first run."""
    after: Analysis
    """The run that is compared with it."""
    means: tuple[Contrast, ...]
    """One for each pose and axis."""
    spreads: tuple[Contrast, ...]
    """One for each pose, axis and plane: RP, and 3 S of an angle."""
    findings: tuple[Finding, ...]
    """What the comparison must be read with."""


@dataclass(frozen=True, eq=False, slots=True)
class Comparison(Plotted):
    """Every run against the first of them."""

    pairs: tuple[Pair, ...]
    """One for each run after the first."""
    shuffles: int
    """Number of permutations."""
    seed: int
    """Seed of the permutations."""
    characteristics: tuple[Characteristic, ...] = ()
    """Exchangeability (7.7), where the runs are of several robots and it was asked for."""

    def __repr__(self) -> str:
        shown = {ContrastVerdict.LESS, ContrastVerdict.MORE}
        found = [one for pair in self.pairs for one in (*pair.means, *pair.spreads)]
        changed = sum(one.verdict in shown for one in found)
        return f"<Comparison: {len(self.pairs)} pair(s), {changed} of {len(found)} changes shown>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: a row for each pair, pose, figure and quantity, NaN where none.

        Columns: before and after (values, in ``unit``), difference with low and high, ratio with
        ratio_low and ratio_high, p_value, p_value_alone, verdict, cycles_needed, smallest_shown;
        ``table`` names the run that is compared with the first.
        """
        rows = [
            _row(pair.after.run.origin.source, one)
            for pair in self.pairs
            for one in (*pair.spreads, *pair.means)
        ]
        return frame_of(rows, {"before": self.pairs[0].before.run.origin.source})


def _row(table: str, one: Contrast) -> dict[str, Any]:
    low, high = one.interval
    ratio_low, ratio_high = one.ratio_interval or (None, None)
    numbers = {
        "before": one.before, "after": one.after, "difference": one.difference, "low": low,
        "high": high, "ratio": one.ratio, "ratio_low": ratio_low, "ratio_high": ratio_high,
        "p_value": one.p_value, "p_value_alone": one.p_value_alone,
        "cycles_needed": one.cycles_needed, "smallest_shown": one.smallest_shown,
    }  # fmt: skip
    return {
        "table": table,
        "pose": one.pose,
        "figure": one.figure,
        "quantity": one.quantity,
        "unit": one.unit,
        **{name: or_nan(value) for name, value in numbers.items()},
        "verdict": one.verdict.value,
    }
