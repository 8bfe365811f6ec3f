"""What an effect on readings is. Its formula stands once, in its own file.

An effect is one of four kinds, by how chance takes part in it: a `KnownCourse` is known once its
parameters are, a `RandomCourse` is drawn anew in each test, `TwoStates` are drawn by a Markov
chain, a `ScatterChange` moves no mean. Each kind derives from the one formula what the search
compares (`forms`, `near`), what a simulation and a model add to readings (`series`), and the course
of known parameters under other conditions (`course`). Those that chance draws stand in `_chance`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from scara_iso.effects._conditions import Conditions, fits, is_open
from scara_iso.effects._forms import Form, Shape
from scara_iso.effects._linear import SIZE, Linear
from scara_iso.effects._parameter import Parameter, Values, combinations
from scara_iso.run import FloatArray


class Direction(Enum):
    """Where an effect may move the tool."""

    FREE = "free"
    JOINT = "joint"
    """Along a column of the Jacobian."""
    ARM = "along the arm"


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
    direction: Direction = Direction.FREE
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
