"""The parameters of an effect, and the values of them that a search tries."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from scara_iso.run import FloatArray, IntArray

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
    def geometric(cls, low: float, high: float, count: int, *, finer: int) -> Grid:
        """Return ``count`` values in a constant ratio, ``finer`` between either neighbour."""
        values = np.geomspace(low, high, count)
        factors = np.geomspace(values[0] / values[1], values[1] / values[0], finer)
        return cls(values.tolist(), near=lambda value: value * factors)

    @classmethod
    def cycles(cls, cycle: IntArray, *, edge: int) -> Grid:
        """Return about twenty of the cycles, ``edge`` left out at either end; between them each."""
        n = len(cycle)
        stride = max(1, round(n / 20))
        between = np.arange(1.0 - stride, stride)
        return cls(cycle[edge : n - edge : stride].tolist(), near=lambda value: value + between)

    @classmethod
    def shares(cls, shares: Sequence[float], n: int) -> Grid:
        """Return lengths in cycles that are ``shares`` of a run of ``n``."""
        factors = np.geomspace(0.7, 1.4, 7)
        return cls([share * n for share in shares], near=lambda value: value * factors)

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
