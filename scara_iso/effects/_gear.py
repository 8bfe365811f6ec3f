"""What an effect on the gear is: a change of the load deviation at a reversal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np

from scara_iso.effects._parameter import Parameter, Sizes, combinations
from scara_iso.run import FloatArray


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

    def deviation(self, sweep: Sweep, values: Sizes) -> FloatArray:
        """Return eq. 16's load deviation with the effect, in rad, shape (m,)."""
        return self.changed(sweep, **values).deviation
