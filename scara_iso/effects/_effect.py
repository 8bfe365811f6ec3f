"""What an effect on readings, or on a gear, is. Its formula stands once, in its own file.

An effect on readings is one of four kinds, by how chance takes part in it: a `KnownCourse` is known
once its parameters are, a `RandomCourse` is drawn anew in each test, `TwoStates` are drawn by a
Markov chain, a `ScatterChange` moves no mean. Each kind derives from the one formula what the
search compares (`forms`, `near`), what a simulation and a model add to readings (`series`), and the
course of known parameters under other conditions (`course`). A `GearEffect` changes the load
deviation at a reversal.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import cast

import numpy as np

from scara_iso.effects._parts import (
    SIZE,
    Chain,
    Conditions,
    Form,
    Grid,
    Linear,
    Parameter,
    Process,
    Shape,
    Sizes,
    Spread,
    Values,
    combinations,
    fits,
    is_open,
)
from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Effect(ABC):
    """Something that moves or widens readings over the cycles of a test.

    Of its ``parameters`` those with a grid are searched and those in the unit of a reading are
    estimated, one for each axis.
    """

    name: str
    parameters: tuple[Parameter, ...]
    cause: str
    confirm_by: str
    at_once: str = "look at robot, fixture and indicator"
    """What to do about it while the recording still runs."""
    needs: tuple[str, ...] = ()
    """Recorded columns through which it acts; one that ends in ``*`` leaves open which."""
    hidden_by: tuple[str, ...] = ()
    """Recorded columns that, where they vary, move the readings in ways it cannot be told from."""
    weight: float = 1.0
    """Prior weight among all effects in the choice of a name."""
    test_weight: float = 1.0
    """Weight in the test over that in naming. The test asks whether there is anything, so a course
    that other effects' forms see as well needs less weight of its own."""
    common: bool = True
    """Whether chance draws one course for all axes; else each axis has its own."""
    recurs: bool = True
    """False for an accident of one test: no model expects it in the next."""
    by_flank: bool = False
    """Whether it is the flank of a gear's gap on which the load rests: a reversal in readings."""
    smooth: bool = False
    """Whether its course is a smooth one, which no machine follows to the last digit."""
    gain: float = 15.0
    """Prior variance of a shape's coefficient (unit norm) over that of the scatter: g-prior."""
    unsettled: Mapping[str, str] = field(default_factory=dict)
    """By the name of a rival: what the data then leave open, and what would settle it."""
    linear: Linear = SIZE

    @abstractmethod
    def forms(self, conditions: Conditions) -> tuple[Form, ...]:
        """Return what the search compares under ``conditions``."""

    @abstractmethod
    def series(
        self, conditions: Conditions, values: Values, rng: np.random.Generator, /
    ) -> FloatArray:
        """Return what the effect adds to the readings of one axis, shape (n,).

        ``values`` are those of all its parameters; only where `is_random` says so ``rng`` is used.
        """

    def is_random(self, _values: Values, /) -> bool:
        """Return whether chance draws the course of parameter ``values`` anew in every test."""
        return True

    def near(self, _conditions: Conditions, _parameters: Values, /) -> tuple[Form, ...]:
        """Return forms between that of these parameters and its neighbours in `forms`."""
        return ()

    def course(self, _conditions: Conditions, _parameters: Values, /) -> Shape | None:
        """Return the shape of searched parameters; None where no test foretells it."""
        return None

    def in_new_tests(
        self, shape: Shape, _seen: IntArray, _count: int, _rng: np.random.Generator, /
    ) -> FloatArray:
        """Return the columns (count, n, k) of a found ``shape`` in new tests of as many cycles.

        ``seen`` are the rows from which it is known. A course that follows the cycles repeats as it
        is, once for all of them: (1, n, k).
        """
        return shape.columns[np.newaxis]

    def columns_needed(self, values: Values) -> tuple[str, ...]:
        """Return the recorded columns without which the course of ``values`` is not known."""
        named = [values.get(p.name) for p in self.parameters if p.text]
        fixed = [name for name in self.needs if not is_open(name)]
        return (*fixed, *(str(name) for name in named if name is not None))

    def timed(self, conditions: Conditions, values: Values) -> dict[str, float]:
        """Return the times among ``values`` in seconds; none where no clock was recorded."""
        times = [p for p in self.parameters if p.timed and p.name in values and conditions.interval]
        return {p.in_seconds: float(values[p.name]) * (conditions.interval or 0) for p in times}

    def at_pace(self, conditions: Conditions, values: Values) -> dict[str, float | str]:
        """Return ``values`` with times given in seconds in cycles, as far as there is a clock."""
        seconds = {p.in_seconds: p.name for p in self.parameters if p.timed}
        kept = {name: value for name, value in values.items() if name not in seconds}
        if conditions.interval is None:
            return kept
        given = {name: float(values[s]) for s, name in seconds.items() if s in values}
        return kept | {name: value / conditions.interval for name, value in given.items()}

    def takes(self, column: str) -> bool:
        """Return whether the effect may act through a column of this name."""
        return any(fits(column, pattern) for pattern in self.needs)

    @property
    def may_be_growth(self) -> bool:
        """Whether links that warm may move so: smoothly, or with a recorded temperature."""
        return self.smooth or any(need.startswith("temperature") for need in self.needs)

    @property
    def size_name(self) -> str:
        """Name of the parameter that each axis has for itself."""
        return next(p.name for p in self.parameters if p.per_axis)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class KnownCourse(Effect):
    """A course that is known once its parameters are.

    ``columns(conditions, **parameters)`` gives it at unit size, shape (n, k), for values of the
    parameters in which it is not ``linear``.
    """

    columns: Callable[..., FloatArray]

    def forms(self, conditions: Conditions) -> tuple[Form, ...]:
        """Return the shapes of every combination of the parameters' grids."""
        if not all(conditions.named(pattern) for pattern in self.needs):
            return ()
        if any(np.ptp(conditions.covariates.get(name, 0.0)) > 0 for name in self.hidden_by):
            return ()
        shapes = (
            Shape(self.columns(conditions, **values), values, weight)
            for values, weight in combinations(self.parameters, conditions)
        )
        return tuple(shape for shape in shapes if np.isfinite(shape.columns).all())

    def near(self, conditions: Conditions, parameters: Values, /) -> tuple[Form, ...]:
        """Return the shapes near one, along each parameter whose grid is coarse."""
        shapes = (
            Shape(self.columns(conditions, **changed), changed)
            for parameter in self.parameters
            if parameter.grid is not None and not parameter.text
            for value in parameter.grid(conditions).near(float(parameters[parameter.name])).tolist()
            for changed in [{**parameters, parameter.name: value}]
        )
        return tuple(shape for shape in shapes if np.isfinite(shape.columns).all())

    def course(self, conditions: Conditions, parameters: Values, /) -> Shape | None:
        """Return the shape of searched parameters; None for an accident of one test."""
        if not self.recurs:
            return None
        return Shape(self.columns(conditions, **parameters), parameters)

    def in_new_tests(
        self, shape: Shape, seen: IntArray, count: int, rng: np.random.Generator, /
    ) -> FloatArray:
        """Return the course as it is; of accidents, a column each, when they come anew.

        One accident does not come again. Several do, each cycle with the probability that the seen
        cycles show under Jeffreys' prior, and one of them is as likely as another.
        """
        n, k = shape.columns.shape
        if self.recurs or k < 2:
            return shape.columns[np.newaxis] * float(self.recurs)
        often = rng.beta(0.5 + k, 0.5 + max(len(seen) - k, 0), (count, 1))
        which = np.where(rng.random((count, n)) < often, rng.integers(k, size=(count, n)), k)
        return np.eye(k + 1)[which][..., :k]

    def series(
        self, conditions: Conditions, values: Values, _rng: np.random.Generator, /
    ) -> FloatArray:
        """Return the columns times the coefficients of ``values``."""
        shape = {name: v for name, v in values.items() if name not in self.linear.names}
        sizes = {name: float(values[name]) for name in self.linear.names}
        columns = self.columns(conditions, **shape)
        return np.asarray(columns @ self.linear.coefficients(sizes), dtype=np.float64)

    def is_random(self, _values: Values, /) -> bool:
        """Return that it does not."""
        return False


def as_column(values: object) -> FloatArray:
    """Return values (n,) as one column (n, 1) of floats."""
    return np.asarray(values, dtype=np.float64)[:, np.newaxis]


def centred(values: FloatArray) -> FloatArray:
    """Return recorded values less their mean, so that the pose stays that of the whole test."""
    return np.asarray(values - values.mean())


def proportional(  # noqa: PLR0913 - what the contract asks of an effect
    *,
    name: str,
    of: str,
    size: Parameter,
    cause: str,
    confirm_by: str,
    recorded: str = "",
    by: Callable[[FloatArray], FloatArray] = centred,
    by_flank: bool = False,
    weight: float = 1.0,
) -> KnownCourse:
    """Return the effect of a column: the readings move by ``size`` times ``by`` of its values.

    ``of`` names the column; a pattern such as ``temperature*`` leaves it to the parameter
    ``column``, whose symbol and meaning ``recorded`` gives as ``T: the recorded temperature``.
    """
    symbol, _, meaning = recorded.partition(": ")
    which = Parameter(
        "column", symbol, "", meaning, text=True, grid=lambda conditions: Grid(conditions.named(of))
    )
    return KnownCourse(
        name=name,
        parameters=(which, size) if is_open(of) else (size,),
        needs=(of,),
        cause=cause,
        confirm_by=confirm_by,
        by_flank=by_flank,
        weight=weight,
        columns=partial(_followed, by) if is_open(of) else partial(_followed, by, column=of),
    )


def _followed(
    by: Callable[[FloatArray], FloatArray], conditions: Conditions, *, column: str
) -> FloatArray:
    return as_column(by(conditions.covariates[column]))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class RandomCourse(Effect):
    """A course that is drawn anew in each test: a linear filter of independent innovations.

    ``filtered(innovations, **parameters)`` gives courses (n, m) of innovations (n, m); its response
    to unit innovations F makes the covariance F F' that the search compares, at the innovations'
    ``variances`` over the scatter's. Without variances it is simulated and not searched.
    ``stays(**parameters)`` is the share of its variance that is scatter still once it is cured.
    """

    filtered: Callable[..., FloatArray] = lambda innovations: innovations
    innovations: Callable[..., FloatArray] = lambda rng, n: rng.normal(size=n)
    variances: tuple[float, ...] = ()
    stays: Callable[..., float] = lambda **_: 0.0

    def forms(self, conditions: Conditions) -> tuple[Form, ...]:
        """Return processes of every combination of parameters and variances."""
        found: list[Form] = []
        if not self.variances:
            return ()
        for values, weight in combinations(self.parameters, conditions):
            response = self.filtered(np.eye(len(conditions)), **values)
            together = response @ response.T
            stays = self.stays(**values)
            found += [Process(together, values, weight, v, stays) for v in self.variances]
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

    def in_new_tests(
        self, shape: Shape, seen: IntArray, count: int, rng: np.random.Generator, /
    ) -> FloatArray:
        """Return alternation as it is, and else states drawn anew by the chain that was seen.

        The probabilities of leaving either state have the posterior of the changes between seen
        cycles, under Jeffreys' prior; so the share of a state has its sampling error.
        """
        if not self.is_random(shape.parameters):
            return shape.columns[np.newaxis]
        states = shape.columns[seen, 0] > 0.5
        before, changed = states[:-1], states[1:] != states[:-1]
        leaves = [
            rng.beta(0.5 + changed[at].sum(), 0.5 + (~changed[at]).sum(), count)
            for at in (~before, before)
        ]
        n, apart = len(shape.columns), round(float(np.diff(seen).mean()))
        chance = rng.random((-(-n // apart), count))
        drawn = np.empty(chance.shape, dtype=bool)
        drawn[0] = chance[0] < leaves[0] / (leaves[0] + leaves[1])
        for j in range(1, len(drawn)):
            drawn[j] = drawn[j - 1] ^ (chance[j] < np.where(drawn[j - 1], leaves[1], leaves[0]))
        return np.repeat(drawn, apart, axis=0)[:n].T[:, :, np.newaxis].astype(np.float64)

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


@dataclass(frozen=True, eq=False, slots=True)
class Sweep:
    """Measured reversals: one entry for each, all of shape (m,).

    Inertias in kg m2, full gap 2D in rad, ``torque`` in N m and ``ratio`` None where not given.
    """

    I_m: FloatArray
    I_L: FloatArray
    gap: FloatArray
    torque: FloatArray | None = None
    ratio: FloatArray | None = None

    @property
    def deviation(self) -> FloatArray:
        """Load deviation in rad, shape (m,): -2D / (1 + I_L / I_m), paper eq. 16.

        An infinite ``I_m`` is a motor that is held.
        """
        return np.asarray(-self.gap / (1 + self.I_L / self.I_m))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class GearEffect:
    """A change of the two-inertia model: ``changed(sweep, **parameters)`` is what eq. 16 sees.

    Values are numbers or columns of shape (k, 1), for k sweeps at once. The parameters' grids, in
    order and equally likely beforehand, are what a fit tries; they are empty where the sweep lacks
    what the effect acts through.
    """

    name: str
    parameters: tuple[Parameter, ...]
    cause: str
    confirm_by: str
    changed: Callable[..., Sweep]

    def candidates(self, sweep: Sweep) -> tuple[Sizes, ...]:
        """Return the parameter values to try."""
        # no parameter of a gear is a text
        return tuple(cast(Sizes, values) for values, _ in combinations(self.parameters, sweep))
