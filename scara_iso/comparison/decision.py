"""What a difference decides against chance: interval, p-value, verdict, cycles needed.

A difference counts only as far as the dials' rounding does not explain it (`comparison.dial`), in
units of its standard error, against the largest such difference among all figures of each
permutation: the single-step maximum (Westfall and Young 1993). Interval and test use the same
permutations, so an interval leaves out "no difference" exactly where the test rejects it. Several
pairs share the level equally (Bonferroni).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from scara_iso.comparison.dial import DialSpread, ratio_range
from scara_iso.comparison.result import ContrastVerdict, Ends
from scara_iso.run import FloatArray

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
