"""What a comparison yields: frozen figures, their intervals, and what each one decides."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from scara_iso.display import Plotted
from scara_iso.frames import frame_of, or_nan
from scara_iso.iso9283 import Analysis, Characteristic, Finding
from scara_iso.published import Count, Size, Unit

if TYPE_CHECKING:
    import pandas as pd

Ends = tuple[float | None, float | None]
"""Of an interval; None where nothing bounds it."""
Quantity: TypeAlias = Literal["mean", "RP", "three_sigma"]
FigureName: TypeAlias = Literal["X", "Y", "Z", "theta", "XY", "XYZ"]
Probability: TypeAlias = Annotated[float, ("minimum", 0), ("maximum", 1)]


class ContrastVerdict(Enum):
    """What a figure's interval decides; the values are those of the JSON object."""

    LESS = "less"
    MORE = "more"
    NOT_SHOWN = "not-shown"
    """The difference is one that chance makes in so few cycles."""
    DIAL = "dial"
    """The difference is one that the two dials' rounding can make."""


@dataclass(frozen=True, kw_only=True)
class Difference:
    """One figure of one pose before and after, in its unit.

    Intervals hold together: all those of one quantity and one pair with 95 %.
    """

    pose: str | None
    """Label; null for runs of one pose."""
    figure: FigureName
    """The axis, or the plane or space."""
    quantity: Quantity
    """What is compared."""
    unit: Unit
    """Of both values and the difference."""
    before: float
    """Value of the first run."""
    after: float
    """Value of the other run."""
    difference: float
    """After minus before."""
    difference_interval: Ends
    """Null where nothing bounds it."""


@dataclass(frozen=True, kw_only=True)
class Ratio:
    """After over before."""

    ratio: Size | None
    """After over before; null for a mean, and where the figure was 0 before."""
    ratio_interval: Ends | None
    """Null for a mean; its ends where nothing bounds them."""


@dataclass(frozen=True, kw_only=True)
class Significance:
    """What a difference decides."""

    p_value: Probability
    """Among all figures of this quantity and all pairs."""
    p_value_at_floor: bool
    """No permutation came as far apart: the chance is at most the p-value."""
    p_value_alone: Probability
    """As if no other figure had been looked at."""
    verdict: ContrastVerdict
    """Whether the difference is shown, and which way."""
    cycles_needed: Count | None
    """In each run, to show the observed difference in 4 of 5 tests; null where it is shown, 0, or
    the dial's; 100000: that many or more."""
    smallest_shown: Size | None
    """What these cycles show in 4 of 5 tests: a distance of means, or a ratio above 1."""
    doubts: tuple[str, ...]
    """Codes of findings of either run that this figure must be read with."""


@dataclass(frozen=True, kw_only=True)
class Contrast(Significance, Ratio, Difference):
    """One figure of one pose before and after, and what its difference decides."""


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
    low, high = one.difference_interval
    ratio_low, ratio_high = one.ratio_interval or (None, None)
    numbers = {
        "before": one.before,
        "after": one.after,
        "difference": one.difference,
        "low": low,
        "high": high,
        "ratio": one.ratio,
        "ratio_low": ratio_low,
        "ratio_high": ratio_high,
        "p_value": one.p_value,
        "p_value_alone": one.p_value_alone,
        "cycles_needed": one.cycles_needed,
        "smallest_shown": one.smallest_shown,
    }
    return {
        "table": table,
        "pose": one.pose,
        "figure": one.figure,
        "quantity": one.quantity,
        "unit": one.unit,
        **{name: or_nan(value) for name, value in numbers.items()},
        "verdict": one.verdict.value,
    }
