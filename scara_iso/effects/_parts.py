"""What an effect is made of: conditions of a test, parameters with the values to try, forms.

The forms are how an effect may show in the readings, which a search compares.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from itertools import product
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from scara_iso.run import FloatArray, IntArray

CLOCK = "time_s"
_BEHIND_THE_FIRST = 2
"""Number of the cycle with which a test begins whose first cycle is discarded."""


@dataclass(frozen=True, eq=False, slots=True)
class Conditions:
    """Cycle numbers and recorded columns; every array has shape (n,).

    ``time`` is in cycles: the cycle number, or where ``time_s`` was recorded the same clock in
    units of its median interval. ``visits`` are the columns of which each pose has its own, by pose
    and name.
    """

    cycle: IntArray
    covariates: Mapping[str, FloatArray] = field(default_factory=dict)
    visits: Mapping[str, Mapping[str, FloatArray]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "covariates", MappingProxyType(dict(self.covariates)))

    def at(self, pose: str) -> Conditions:
        """Return those of the visits of one pose."""
        return Conditions(self.cycle, {**self.covariates, **self.visits.get(pose, {})})

    @property
    def elapsed(self) -> FloatArray:
        """Cycles since the first one, shape (n,)."""
        return np.asarray(self.cycle - self.cycle[0], dtype=np.float64)

    @property
    def time(self) -> FloatArray:
        """Time since the first cycle in cycles, from ``time_s`` where it is there and increases.

        The first is the cycle of number 1 also where that was discarded.
        """
        seconds, interval = self.seconds, self.interval
        if seconds is not None and interval is not None:
            return seconds / interval
        return self.elapsed + float(self.cycle[0] == _BEHIND_THE_FIRST)

    @property
    def seconds(self) -> FloatArray | None:
        """Time since the first cycle [s], shape (n,); None where no clock was recorded.

        The first is the cycle of number 1, discarded or not, where the clock shows it to be zero;
        else the first one here.
        """
        if CLOCK not in self.covariates:
            return None
        clock, interval = np.asarray(self.covariates[CLOCK]), self.interval
        since_one = 0.0 if interval is None else float(self.cycle[0] - 1) * interval
        from_one = interval is not None and abs(clock[0] - since_one) < interval / 2
        return clock if from_one else clock - clock[0]

    @property
    def interval(self) -> float | None:
        """Median time from cycle to cycle [s]; None where no clock was recorded, or none goes."""
        apart = np.diff(self.covariates.get(CLOCK, np.empty(0)))
        return float(np.median(apart)) if len(apart) and np.all(apart > 0) else None

    def named(self, pattern: str) -> tuple[str, ...]:
        """Return the columns whose name fits a pattern such as ``temperature*``.

        The clock fits its own name only.
        """
        names = (
            name for name in self.covariates if CLOCK not in (name, pattern) or name == pattern
        )
        return tuple(name for name in names if fits(name, pattern))

    def __len__(self) -> int:
        return len(self.cycle)


def fits(name: str, pattern: str) -> bool:
    """Return whether a column's name is ``pattern``, or fits it where it ends in ``*``."""
    return name == pattern or (is_open(pattern) and fnmatchcase(name.lower(), pattern))


def is_open(pattern: str) -> bool:
    """Return whether a pattern leaves open which column is meant."""
    return pattern.endswith("*")


Sizes = Mapping[str, float]
"""Parameter values by name."""

Values = Mapping[str, float | str]
"""The same where a value may be the name of a column."""


def _none_near(_: float) -> FloatArray:
    return np.empty(0)


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """Values of one parameter to try, and their prior weights (None: all the same).

    ``near(value)`` lies between a value and its neighbours: it refines the likeliest one where the
    grid is coarse.
    """

    values: Sequence[float | str]
    weights: Sequence[float] | None = None
    near: Callable[[float], FloatArray] = _none_near

    @classmethod
    def exact(cls, values: npt.ArrayLike) -> Grid:
        """Return a grid that is as fine as the parameter itself."""
        return cls(np.asarray(values).tolist())

    @classmethod
    def geometric(cls, low: float, high: float, count: int) -> Grid:
        """Return ``count`` values in a constant ratio; nine lie between either neighbour."""
        values = np.geomspace(low, high, count)
        factors = np.geomspace(values[0] / values[1], values[1] / values[0], 9)
        return cls(values.tolist(), near=lambda value: value * factors)

    @classmethod
    def cycles(cls, edge: int, conditions: Conditions) -> Grid:
        """Return about twenty of the cycles, ``edge`` left out at either end; between them each."""
        n = len(conditions)
        stride = max(1, round(n / 20))
        between = np.arange(1.0 - stride, stride)
        kept = conditions.cycle[edge : n - edge : stride]
        return cls(kept.tolist(), near=lambda value: value + between)

    @classmethod
    def shares(cls, shares: Sequence[float], conditions: Conditions) -> Grid:
        """Return lengths in cycles that are ``shares`` of a run; none between them is longer."""
        factors, values = np.geomspace(0.7, 1.4, 7), [share * len(conditions) for share in shares]
        return cls(values, near=lambda value: np.unique(np.minimum(value * factors, max(values))))

    def __iter__(self) -> Iterator[tuple[float | str, float]]:
        weights = [1.0] * len(self.values) if self.weights is None else self.weights
        return iter(zip(self.values, weights, strict=True))


@dataclass(frozen=True, eq=False, slots=True)
class Parameter:
    """A number that describes an effect; ``unit`` "reading" is the unit of the axis.

    ``grid`` gives the values to try under the conditions of a test (of an `Effect`) or a sweep (of
    a `GearEffect`). None for a parameter that is estimated: the effect is linear in it.
    """

    name: str
    symbol: str
    unit: str
    meaning: str
    above: float = -math.inf
    """The value is larger than this, and finite."""
    up_to: float = math.inf
    grid: Callable[[Any], Grid] | None = None
    text: bool = False
    """Whether the value is the name of a recorded column, and no number."""
    timed: bool = False
    """Whether it is a time, in cycles; where time was recorded it is known in seconds too."""

    @property
    def in_seconds(self) -> str:
        """Name of the same time in seconds."""
        return f"{self.name}_s"

    @property
    def per_axis(self) -> bool:
        """Whether each axis has a value of its own: one in the unit of its readings."""
        return self.unit.startswith("reading")


def combinations(
    parameters: Sequence[Parameter], conditions: object
) -> Iterator[tuple[dict[str, float | str], float]]:
    """Yield every combination of the values to try under conditions or of a sweep, with weight."""
    searched = [(p.name, p.grid(conditions)) for p in parameters if p.grid is not None]
    for chosen in product(*(grid for _, grid in searched)):
        values = {name: value for (name, _), (value, _) in zip(searched, chosen, strict=True)}
        yield values, math.prod(weight for _, weight in chosen)


@dataclass(frozen=True, eq=False, slots=True)
class Shape:
    """A known course: its columns (n, k) at unit size, and the parameters that give it.

    ``weight`` is its prior probability within the effect, up to a factor common to its forms; so
    it is for the other forms. A shape without columns (k = 0) moves no reading. Where each axis
    follows one of the columns alone, ``of`` says which.
    """

    columns: FloatArray
    parameters: Values = field(default_factory=dict)
    weight: float = 1.0
    of: IntArray | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Process:
    """A random course: covariance ``variance`` times ``unit`` (n, n), beside scatter of variance 1.

    The root of the variance is the standard deviation, in scatters, of what its size means (such as
    one step). Forms that differ in their variance alone hold the same ``unit``, so that what
    belongs to it is computed once. ``stays`` is the share of its variance that is scatter still
    where its cause is cured.
    """

    unit: FloatArray
    parameters: Values = field(default_factory=dict)
    weight: float = 1.0
    variance: float = 1.0
    stays: float = 0.0
    of: ClassVar[None] = None

    @property
    def columns(self) -> FloatArray:
        """None that is known, shape (n, 0); likewise of the other forms."""
        return self.unit[:, :0]

    @property
    def covariance(self) -> FloatArray:
        """The covariance (n, n)."""
        return self.variance * self.unit


@dataclass(frozen=True, eq=False, slots=True)
class Spread:
    """Scatter that is ``scale`` (n,) times as wide in each cycle as in the first; no mean moves."""

    scale: FloatArray
    parameters: Values = field(default_factory=dict)
    weight: float = 1.0
    of: ClassVar[None] = None

    @property
    def columns(self) -> FloatArray:
        """None."""
        return self.scale[:, np.newaxis][:, :0]


@dataclass(frozen=True, slots=True)
class Chain:
    """A two-state Markov chain: probabilities of leaving the lower and the upper state."""

    leave_lower: float
    leave_upper: float
    weight: float = 1.0
    of: ClassVar[None] = None

    @property
    def columns(self) -> FloatArray:
        """None."""
        return np.empty((1, 0))


Form = Shape | Process | Spread | Chain


@dataclass(frozen=True, slots=True)
class Linear:
    """The parameters in which a course is linear, and its coefficients (k,)."""

    names: tuple[str, ...]
    sizes: Callable[[FloatArray], dict[str, float]]
    coefficients: Callable[[Sizes], FloatArray]


def _polar(coefficients: FloatArray) -> dict[str, float]:
    sine, cosine = float(coefficients[0]), float(coefficients[1])
    return {"size": math.hypot(sine, cosine), "phase": math.atan2(cosine, sine)}


SIZE = Linear(("size",), lambda c: {"size": float(c[0])}, lambda v: np.array([v["size"]]))
"""One column, times ``size``."""

AMPLITUDE_AND_PHASE = Linear(
    ("size", "phase"),
    _polar,
    lambda v: v["size"] * np.array([math.cos(v["phase"]), math.sin(v["phase"])]),
)
"""A sine and a cosine: size sin(angle + phase)."""
