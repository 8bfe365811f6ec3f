"""Effects in which chance takes part: random courses, two states, scatter that changes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from scara_iso.effects._conditions import Conditions
from scara_iso.effects._effect import Effect, as_column
from scara_iso.effects._forms import Chain, Form, Process, Shape, Spread
from scara_iso.effects._parameter import Values, combinations
from scara_iso.run import FloatArray


def _normal(rng: np.random.Generator, n: int) -> FloatArray:
    return rng.normal(size=n)


def _nothing(**_: float | str) -> float:
    return 0.0


def _independent(innovations: FloatArray) -> FloatArray:
    return innovations


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class RandomCourse(Effect):
    """A course that is drawn anew in each test: a linear filter of independent innovations.

    ``filtered(innovations, **parameters)`` gives courses (n, m) of innovations (n, m); its response
    to unit innovations F makes the covariance F F' that the search compares, at the innovations'
    ``variances`` over the scatter's. Without variances it is simulated and not searched.
    ``stays(**parameters)`` is the share of its variance that is scatter still once it is cured.
    """

    filtered: Callable[..., FloatArray] = _independent
    innovations: Callable[[np.random.Generator, int], FloatArray] = _normal
    variances: tuple[float, ...] = ()
    stays: Callable[..., float] = _nothing

    def forms(self, conditions: Conditions) -> tuple[Form, ...]:
        """Return processes of every combination of parameters and variances."""
        found: list[Form] = []
        if not self.variances:
            return ()
        for values, weight in combinations(self.parameters, conditions):
            response = self.filtered(np.eye(len(conditions)), **values)
            together = response @ response.T
            stays = self.stays(**values)
            found += [
                Process(
                    together, values, weight, scale=variance**0.5, variance=variance, stays=stays
                )
                for variance in self.variances
            ]
        return tuple(found)

    def series(
        self, conditions: Conditions, values: Values, rng: np.random.Generator, /
    ) -> FloatArray:
        """Return one draw."""
        shape = {name: v for name, v in values.items() if name != self.size_name}
        drawn = self.innovations(rng, len(conditions))[:, np.newaxis]
        return float(values[self.size_name]) * self.filtered(drawn, **shape)[:, 0]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class TwoStates(Effect):
    """Two levels, ``size`` apart, between which a Markov chain switches.

    In a simulation either state is left with probability ``switching``; at 1 the upper level is
    that of odd cycles, a known course. The search compares that course and ``chains``.
    """

    chains: tuple[Chain, ...]

    def forms(self, conditions: Conditions) -> tuple[Form, ...]:
        """Return alternation, the one course that is known beforehand, and the chains."""
        return (Shape(_alternating(conditions), {"switching": 1.0}), *self.chains)

    def course(self, conditions: Conditions, parameters: Values, /) -> Shape | None:
        """Return alternation; None where the states are drawn by chance."""
        if self.is_random(parameters):
            return None
        return Shape(_alternating(conditions), parameters)

    def series(
        self, conditions: Conditions, values: Values, rng: np.random.Generator, /
    ) -> FloatArray:
        """Return one draw of the states, times their distance."""
        if not self.is_random(values):
            return float(values["size"]) * _alternating(conditions)[:, 0]
        switches = rng.random(len(conditions)) < float(values["switching"])
        switches[0] = rng.random() < 0.5
        states = np.cumsum(switches) % 2
        return np.asarray(float(values["size"]) * states, dtype=np.float64)

    def is_random(self, values: Values, /) -> bool:
        """Return whether the states do not simply alternate."""
        return float(values["switching"]) < 1


def _alternating(conditions: Conditions) -> FloatArray:
    return as_column(conditions.cycle % 2)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ScatterChange(Effect):
    """Scatter that differs from cycle to cycle while the mean stays.

    ``scale(conditions, **parameters)`` is how wide it is in each cycle, shape (n,), the narrowest
    1. The size is the standard deviation where it is narrowest; a simulation adds what makes the
    readings' own scatter, of that size, as wide as stated.
    """

    scale: Callable[..., FloatArray]

    def forms(self, conditions: Conditions) -> tuple[Form, ...]:
        """Return the scales, that of the first cycle 1, of every combination of the grids."""
        found = (
            (self.scale(conditions, **values), values, weight)
            for values, weight in combinations(self.parameters, conditions)
        )
        return tuple(Spread(scale / scale[0], values, weight) for scale, values, weight in found)

    def series(
        self, conditions: Conditions, values: Values, rng: np.random.Generator, /
    ) -> FloatArray:
        """Return scatter that is added where it is wider, independent of that of the readings."""
        shape = {name: v for name, v in values.items() if name != self.size_name}
        added = float(values[self.size_name]) * np.sqrt(self.scale(conditions, **shape) ** 2 - 1)
        return np.asarray(added * rng.normal(size=len(conditions)))
