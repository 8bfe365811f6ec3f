"""What a difference decides against chance: interval, p-value, verdict, cycles needed.

A difference counts only as far as the dials' rounding does not explain it (`comparison.dial`), in
units of its standard error, against the largest such difference among all figures of each
permutation, means and spreads alike: the single-step maximum (Westfall and Young 1993), so that in
5 % of unchanged pairs something is called changed. Interval and test use the same permutations, so
an interval leaves out "no difference" exactly where the test rejects it. Several pairs share the
level equally (Bonferroni).

What a comparison yields: frozen figures, their intervals, and what each one decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from statistics import NormalDist
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import numpy as np

from scara_iso.base.display import Plotted
from scara_iso.base.published import Count, Size, Unit
from scara_iso.comparison.chance import DialSpread, ratio_range
from scara_iso.iso9283 import Analysis, Characteristic, Finding
from scara_iso.run import FloatArray, frame_of, or_nan

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

    Intervals hold together: all those of one pair, of means and spreads, with 95 %.
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
    """Among all figures, of means and spreads, and all pairs."""
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


LEVEL = 0.05
MOST_CYCLES = 100_000
_POWER = NormalDist().inv_cdf(0.8)  # 4 of 5 tests
_LARGEST = 1e6  # errors; a permutation of equal readings has no error


@dataclass(frozen=True, slots=True)
class Distance:
    """A difference in the scale in which it is tested, what the dials leave open, its error."""

    observed: float
    lower: float
    upper: float
    error: float

    @property
    def beside_the_dial(self) -> float:
        """How much of the difference rounding does not explain."""
        return max(self.lower, -self.upper, 0.0)


@dataclass(frozen=True, slots=True)
class Decision:
    """The outcome of one figure; ``critical`` and ``shown_errors`` are in standard errors."""

    verdict: ContrastVerdict
    p_value: float
    p_value_at_floor: bool
    p_value_alone: float
    critical: float
    cycles_needed: int | None

    @property
    def shown_errors(self) -> float:
        """The difference that 4 of 5 tests show."""
        return self.critical + _POWER


@dataclass(frozen=True, eq=False, slots=True)
class PermutationTest:
    """What a difference decides, by the differences that chance makes."""

    permuted: FloatArray
    """Absolute studentised differences, shape (figures, permutations)."""
    pairs: int = 1
    """Number of pairs of runs that share the level."""

    def decide(self, distance: Distance, k: int, *, cycles: tuple[int, int]) -> Decision:
        """Return what the difference of figure ``k`` decides."""
        apart = _over(distance.beside_the_dial, distance.error)
        critical = self._critical()
        return Decision(
            verdict=_verdict(distance, apart, critical),
            p_value=min(_share(self.permuted.max(axis=0), apart) * self.pairs, 1.0),
            p_value_at_floor=bool(np.all(self.permuted < apart)),
            p_value_alone=_share(self.permuted[k], apart),
            critical=critical,
            cycles_needed=None if apart > critical else _cycles(apart, critical, cycles),
        )

    def _critical(self) -> float:
        """Return the distance that is passed exactly where the p-value is at most the level."""
        largest = np.sort(self.permuted.max(axis=0))[::-1]
        rank = math.floor(LEVEL * (len(largest) + 1) / self.pairs)
        return min(float(largest[rank - 1]), _LARGEST)


def log_ratio(before: DialSpread, after: DialSpread) -> Distance:
    """Return the distance of two spreads: the logarithm of after over before."""
    low, high = ratio_range(before, after)
    both = before.read > 0 and after.read > 0
    observed = math.log(after.read / before.read) if both else after.read - before.read
    return Distance(observed, _log(low), _log(high), math.hypot(before.error, after.error))


def ratio_interval(distance: Distance, critical: float) -> Ends:
    """Return the interval of the ratio itself; None for an upper end that nothing bounds."""
    reach = critical * distance.error
    return _exp(distance.lower - reach), _bounded(_exp(distance.upper + reach))


def smallest_ratio(distance: Distance, errors: float) -> float | None:
    """Return the ratio above 1 that lies ``errors`` standard errors beside the dials' part."""
    return _bounded(_exp(distance.upper - distance.lower + errors * distance.error))


def difference_interval(before: DialSpread, after: DialSpread, decision: Decision) -> Ends:
    """Return the interval of after minus before, from those of each (Zou and Donner 2008).

    It leaves out 0 where the ratio's interval leaves out 1: the ratio decides.
    """
    old, new = (_limits(found, decision.critical) for found in (before, after))
    difference = after.read - before.read
    lower = difference - math.hypot(after.read - new[0], old[1] - before.read)
    upper = difference + math.hypot(new[1] - after.read, before.read - old[0])
    match decision.verdict:
        case ContrastVerdict.LESS:
            upper = min(upper, 0.0)
        case ContrastVerdict.MORE:
            lower = max(lower, 0.0)
        case _:
            lower, upper = min(lower, 0.0), max(upper, 0.0)
    return _bounded(lower), _bounded(upper)


def _limits(found: DialSpread, critical: float) -> tuple[float, float]:
    reach = critical * found.error
    return found.lower * _exp(-reach), found.upper * _exp(reach)


def _verdict(distance: Distance, apart: float, critical: float) -> ContrastVerdict:
    if apart > critical:
        return ContrastVerdict.MORE if distance.lower > 0 else ContrastVerdict.LESS
    by_chance = abs(distance.observed) <= critical * distance.error
    return ContrastVerdict.NOT_SHOWN if by_chance else ContrastVerdict.DIAL


def _share(chance: FloatArray, apart: float) -> float:
    """Return the share of permutations as far apart, the one that was run among them."""
    return (1 + int(np.sum(chance >= apart))) / (1 + len(chance))


def _cycles(apart: float, critical: float, cycles: tuple[int, int]) -> int | None:
    """Return the cycles in each run that bring ``apart`` to what 4 of 5 tests show."""
    if apart == 0:
        return None
    each = 2 / (1 / cycles[0] + 1 / cycles[1])
    return math.ceil(min(each * ((critical + _POWER) / apart) ** 2, MOST_CYCLES))


def _over(distance: float, error: float) -> float:
    if error > 0:
        return distance / error
    return math.inf if distance > 0 else 0.0


def _log(value: float) -> float:
    return math.log(value) if value > 0 else -math.inf


def _exp(value: float) -> float:
    return math.exp(value) if value < 700 else math.inf


def _bounded(value: float) -> float | None:
    return value if math.isfinite(value) else None
