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
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from statistics import NormalDist
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np

from scara_iso.base.displayed import Plotted
from scara_iso.base.published import (
    INTERNAL,
    Count,
    Probability,
    Size,
    Unit,
    fill,
    publish,
    published,
    row_of,
)
from scara_iso.comparison.chance import DialSpread, ratio_range
from scara_iso.iso9283 import Analysis, Characteristic, Finding, LimitCheck
from scara_iso.run import FloatArray, frame_of

if TYPE_CHECKING:
    import pandas as pd


Ends = tuple[float | None, float | None]
"""Of an interval; None where nothing bounds it."""
Quantity: TypeAlias = Literal["mean", "RP", "three_sigma"]
FigureName: TypeAlias = Literal["X", "Y", "Z", "theta", "XY", "XYZ"]
LEVEL = 0.05


class ContrastVerdict(Enum):
    """What a figure's interval decides; the values are those of the JSON object."""

    LESS = "less"
    MORE = "more"
    NOT_SHOWN = "not-shown"
    """The difference is one that chance makes in so few cycles."""
    DIAL = "dial"
    """The difference is one that the two dials' rounding can make."""


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """One figure of one pose before and after, and what its difference decides.

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
class MeanContrast(Contrast):
    """The mean of an axis before and after."""

    quantity: Literal["mean"] = "mean"
    """What is compared."""


@dataclass(frozen=True, kw_only=True)
class SpreadContrast(Contrast):
    """The scatter of an axis, a plane or space before and after."""

    quantity: Literal["RP", "three_sigma"]
    """Repeatability, or 3 S of an angle."""
    ratio: Size | None
    """After over before; None where the figure was 0 before."""
    ratio_interval: Ends
    """Of the ratio; None where nothing bounds it."""


@dataclass(frozen=True, slots=True)
class CountedCycles:
    """How many cycles each pose has."""

    read: Count
    """Cycles in the table."""
    used: Count
    """Cycles that count."""


def _checks_or_none(found: tuple[LimitCheck, ...]) -> tuple[LimitCheck, ...] | None:
    return found or None


def _or_none(found: tuple[Characteristic, ...]) -> tuple[Characteristic, ...] | None:
    return found or None


@dataclass(frozen=True, slots=True)
class ComparedRun:
    """One of the runs."""

    source: str
    """The file."""
    read_as: str
    """How the file was understood."""
    notes: tuple[str, ...]
    """What was met and not used."""
    metadata: Mapping[str, str]
    """What the file states."""
    cycles: CountedCycles
    """For each pose."""
    limits: tuple[LimitCheck, ...] = field(
        default=(), metadata=published(by=_checks_or_none, always=False)
    )
    """One for each figure that was held against a limit."""


def compared_run(found: Analysis) -> ComparedRun:
    """Return what a comparison publishes of a run."""
    return publish(ComparedRun, found, cycles=publish(CountedCycles, found.cycles))


@dataclass(frozen=True, eq=False, slots=True)
class Pair:
    """A run against the first."""

    before: Analysis = field(metadata=INTERNAL)
    """The first run."""
    after: Analysis = field(metadata=published(by=compared_run))
    """The run that is compared."""
    spreads: tuple[SpreadContrast, ...]
    """One for each pose, axis and plane: RP, and 3 S of an angle."""
    means: tuple[MeanContrast, ...]
    """One for each pose and axis."""
    findings: tuple[Finding, ...]
    """What the comparison must be read with."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonTest:
    """How chance was judged."""

    method: str = "studentised permutation of centred cycles, single-step maximum"
    """In words."""
    level: Probability = LEVEL
    """Chance that any figure of a quantity is shown where nothing changed."""
    shuffles: Count
    """Number of permutations."""
    seed: int
    """Of the permutations."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Comparison(Plotted):
    """Every run against the first of them."""

    schema: Literal["scara-iso/compare/1"] = "scara-iso/compare/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    test: ComparisonTest
    """Of all figures together."""
    before: Analysis = field(init=False, metadata=published(by=compared_run))
    """The first run."""
    pairs: Annotated[tuple[Pair, ...], ("minItems", 1)]
    """One for each run after the first."""
    characteristics: tuple[Characteristic, ...] = field(
        default=(), metadata=published(by=_or_none, always=False)
    )
    """Exchangeability (7.7), where the runs are of several robots and it is asked for."""

    def __post_init__(self) -> None:
        fill(self, before=self.pairs[0].before)

    @property
    def runs(self) -> tuple[Analysis, ...]:
        """The first and every other."""
        return (self.before, *(pair.after for pair in self.pairs))

    @property
    def limits(self) -> tuple[LimitCheck, ...]:
        """Every figure that was held against a limit: of the tables, and of them together."""
        together = (one.limit for one in self.characteristics if one.limit)
        return (*(check for one in self.runs for check in one.limits), *together)

    def __repr__(self) -> str:
        shown = {ContrastVerdict.LESS, ContrastVerdict.MORE}
        found = [one for pair in self.pairs for one in (*pair.means, *pair.spreads)]
        changed = sum(one.verdict in shown for one in found)
        return f"<Comparison: {len(self.pairs)} pair(s), {changed} of {len(found)} changes shown>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: a row for each pair, pose, figure and quantity, NaN where none.

        Columns: ``table``, the run that is compared with the first, and what `SpreadContrast`
        publishes, the ends of its intervals with ``_low`` and ``_high``.
        """
        rows = [
            {"table": pair.after.source, **row_of(one), "pose": one.pose}
            for pair in self.pairs
            for one in (*pair.spreads, *pair.means)
        ]
        return frame_of(rows, {"before": self.before.source})


MOST_CYCLES = 100_000
_POWER = NormalDist().inv_cdf(0.8)  # 4 of 5 tests
_AS_FAR = 1 - 1e-9  # no tie hangs on the last bit of a sum: dials make many
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
        apart = _over(distance.beside_the_dial, distance.error) * _AS_FAR
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
    by_chance = abs(distance.observed) * _AS_FAR <= critical * distance.error
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
