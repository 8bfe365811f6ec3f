"""What an effect is: its parameters, its shape over the cycles, its cause and what confirms it.

Two kinds exist. An `Effect` acts on the readings of a test, cycle by cycle; a `GearEffect` changes
the load deviation that the two-inertia model gives at a reversal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from scara_iso.errors import DataError
from scara_iso.run import FloatArray, IntArray

Sizes = Mapping[str, float]
"""Parameter values by name."""


class Direction(Enum):
    """Where an effect may move the tool."""

    FREE = "free"
    JOINT = "joint"
    """Along a column of the Jacobian."""
    ARM = "along the arm"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that describes an effect; ``unit`` "reading" is the unit of the axis."""

    name: str
    symbol: str
    unit: str
    meaning: str
    above: float = -math.inf
    """The value is larger than this, and finite."""
    up_to: float = math.inf


@dataclass(frozen=True, eq=False, slots=True)
class Conditions:
    """What is known of each cycle beside its reading; every array has shape (n,).

    ``time`` is in cycles: the cycle number, or where ``time_s`` was recorded the same clock in
    units of its median interval.
    """

    cycle: IntArray
    covariates: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "covariates", MappingProxyType(dict(self.covariates)))

    @property
    def elapsed(self) -> FloatArray:
        """Cycles since the first one, shape (n,)."""
        return np.asarray(self.cycle - self.cycle[0], dtype=np.float64)

    @property
    def time(self) -> FloatArray:
        """Time since the first cycle in cycles, from ``time_s`` where it is there and increases."""
        seconds = self.covariates.get("time_s")
        if seconds is None or len(seconds) < 2 or np.any(np.diff(seconds) <= 0):
            return self.elapsed
        return np.asarray((seconds - seconds[0]) / np.median(np.diff(seconds)))

    def __len__(self) -> int:
        return len(self.cycle)


@dataclass(frozen=True, eq=False, slots=True)
class Shape:
    """One member of an effect's family: its columns (n, k) at unit size, and its parameters.

    ``weight`` is its prior probability within the effect, up to a common factor. A shape without
    columns (k = 0) moves no reading.
    """

    columns: FloatArray
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    weight: float = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class Process:
    """A random course: covariance (n, n) in units of the scatter's variance.

    ``scale`` is the standard deviation, in scatters, of what its size means (such as one step) at
    ``amplitude`` 1; the search tries larger amplitudes too.
    """

    covariance: FloatArray
    scale: float = 1.0
    amplitude: float = 1.0


@dataclass(frozen=True, slots=True)
class Chain:
    """A hidden two-state Markov chain: probabilities of leaving the lower and the upper state."""

    leave_lower: float
    leave_upper: float
    weight: float = 1.0
    """Prior probability within the effect, up to the factor that its shapes have too."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Scatter that is ``ratio`` times as wide from cycle number ``at_cycle`` on."""

    at_cycle: int
    ratio: float


def _no_shapes(_: Conditions) -> tuple[Shape, ...]:
    return ()


def _no_processes(_: Conditions) -> tuple[Process, ...]:
    return ()


def _no_spreads(_: Conditions) -> tuple[Spread, ...]:
    return ()


def _none_nearby(_: Conditions, __: Sizes) -> tuple[Shape, ...]:
    return ()


def first_size(coefficients: FloatArray) -> dict[str, float]:
    """Return ``{"size": c}`` of a single coefficient, shape (1,)."""
    return {"size": float(coefficients[0])}


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Effect:
    """Something that moves readings over the cycles of a test.

    ``series(conditions, values, rng)`` returns its contribution, shape (n,), for parameter values
    by name; only effects with a chance element use ``rng``. What the search tries: ``shapes`` of
    unit size, random ``processes``, hidden ``chains``, ``spreads``. ``nearby`` refines the chosen
    shape where ``shapes`` are a coarse grid. ``sizes`` turns the fitted
    coefficients (k,) of a shape into named sizes. ``weight`` is the effect's prior weight.
    """

    name: str
    parameters: tuple[Parameter, ...]
    cause: str
    confirm_by: str
    series: Callable[[Conditions, Sizes, np.random.Generator], FloatArray]
    direction: Direction = Direction.FREE
    weight: float = 1.0
    shapes: Callable[[Conditions], tuple[Shape, ...]] = _no_shapes
    nearby: Callable[[Conditions, Sizes], tuple[Shape, ...]] = _none_nearby
    """Shapes between that of these parameters and its neighbours in ``shapes``."""
    sizes: Callable[[FloatArray], dict[str, float]] = first_size
    processes: Callable[[Conditions], tuple[Process, ...]] = _no_processes
    spreads: Callable[[Conditions], tuple[Spread, ...]] = _no_spreads
    chains: tuple[Chain, ...] = ()
    ordered: bool = True
    """False where shuffling the cycles leaves the evidence for the effect as it is."""
    common: bool = True
    """Whether chance draws one course for all axes; else each axis has its own."""
    recurs: bool = True
    """False for an accident of one test: no model expects it in the next."""
    gain: float = 15.0
    """Prior variance of a shape's coefficient (unit norm) over that of the scatter: g-prior."""


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
    """A change of the two-inertia model: ``changed(sweep, values)`` is the sweep that eq. 16 sees.

    Values are numbers or columns of shape (k, 1), for k sweeps at once. ``candidates(sweep)`` are
    the parameter values to try, in order and equally likely beforehand; none where the sweep lacks
    what the effect acts through.
    """

    name: str
    parameters: tuple[Parameter, ...]
    cause: str
    confirm_by: str
    changed: Callable[[Sweep, Sizes], Sweep]
    candidates: Callable[[Sweep], tuple[Sizes, ...]]

    def deviation(self, sweep: Sweep, values: Sizes) -> FloatArray:
        """Return eq. 16's load deviation with the effect, in rad, shape (m,)."""
        return self.changed(sweep, values).deviation


def column(values: npt.ArrayLike) -> FloatArray:
    """Return values (n,) as one column (n, 1) of floats."""
    return np.asarray(values, dtype=np.float64)[:, np.newaxis]


def series_by_axis(
    effect: Effect,
    conditions: Conditions,
    parameters: Mapping[str, float | str | Sizes],
    rng: np.random.Generator,
) -> dict[str, FloatArray]:
    """Return what ``effect`` adds to each axis that ``parameters`` give a size, shape (n,) each.

    Parameters are as a diagnosis finds them: a number, one number for each axis, or (``column``)
    the covariate that acts. Raises `DataError` where that covariate was not recorded.
    """
    name = parameters.get("column")
    if isinstance(name, str):
        if name not in conditions.covariates:
            raise DataError(f"{effect.name}: no column {name!r} in this table")
        conditions = Conditions(conditions.cycle, {name: conditions.covariates[name]})
    per_axis = {k: v for k, v in parameters.items() if isinstance(v, Mapping)}
    common = {k: float(v) for k, v in parameters.items() if isinstance(v, int | float)}
    axes = dict.fromkeys(axis for sizes in per_axis.values() for axis in sizes)
    return {
        axis: effect.series(conditions, common | {k: v[axis] for k, v in per_axis.items()}, rng)
        for axis in axes
    }
