"""A sweep of measured reversals, one row each, and what is found in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, TypeAlias

import numpy as np

from scara_iso.base.published import Probability
from scara_iso.diagnosis.verdict import Rival, Verdict
from scara_iso.effects import Sweep
from scara_iso.run import FloatArray
from scara_iso.tables import ColumnNames, Source, read_columns

Joint: TypeAlias = Annotated[int, ("enum", (1, 2))] | None
"""A joint's number; None for a sweep, which has one joint only."""

_NEEDED = ("Im", "IL", "arcmin", "deviation_rad")
_COLUMNS = ColumnNames(
    what="a sweep of reversals",
    needed=_NEEDED,
    optional=("ratio", "torque_Nm", "u_rad"),
    positive=frozenset({"Im", "IL", "arcmin", "ratio", "u_rad"}),
    remedy=f"give the columns {', '.join(_NEEDED)} in kg m2, arcmin and rad",
)


@dataclass(frozen=True, eq=False, slots=True)
class MeasuredSweep:
    """Reversals and the load deviations measured at them, in rad, shape (m,)."""

    sweep: Sweep
    deviation: FloatArray
    """With eq. 16's sign: not positive."""
    uncertainty: FloatArray | None
    """Standard uncertainties in rad, None where not given."""
    notes: tuple[str, ...] = ()


def read_sweep(source: Source, *, decimal: str | None = None) -> MeasuredSweep:
    """Return the sweep of a table with the columns Im, IL, arcmin and deviation_rad.

    Optional columns are ratio, torque_Nm and u_rad; others are left out. Text or .xlsx, in the
    spellings that `tables.read_table` takes, ``decimal`` as there; ``#`` begins a comment line.
    Raises `NoInputError` where it cannot be read, and `DataError` with every fault and its line.
    """
    columns = read_columns(source, _COLUMNS, decimal=decimal).values
    deviation = columns["deviation_rad"]
    sizes = bool(np.all(deviation >= 0))
    return MeasuredSweep(
        Sweep(
            I_m=columns["Im"],
            I_L=columns["IL"],
            gap=np.radians(columns["arcmin"] / 60),
            torque=columns.get("torque_Nm"),
            ratio=columns.get("ratio"),
        ),
        -deviation if sizes else deviation,
        columns.get("u_rad"),
        ("deviations are taken as sizes: eq. 16's sign is negative",) if sizes else (),
    )


@dataclass(frozen=True, eq=False, slots=True)
class GearFound:
    """An effect on the load deviation; intervals are 95 %, over all effects that were found."""

    effect: str
    """Name of the effect; `explain` takes it."""
    joint: Joint
    """Number of the joint; None for a sweep of one gear."""
    parameters: Mapping[str, float]
    """By name, in the units that the effect's page states."""
    intervals: Mapping[str, tuple[float, float]]
    """95 %, by the name of the parameter."""
    p_value: Probability
    """Chance of as much in scatter alone."""
    probability: Probability
    """Of the effects found, together."""
    rivals: tuple[Rival, ...]
    """Other effects that fit as well, likeliest first."""
    cause: str
    """What usually causes it."""
    confirm_by: str
    """The experiment that confirms it."""


@dataclass(frozen=True, eq=False, slots=True)
class GearDiagnosis:
    """What the two-inertia model leaves unexplained of reversals, shape (m,), in their unit."""

    verdict: Verdict
    """Whether something is left, and whether effects explain it."""
    p_value: float
    """Chance of as much left in scatter alone."""
    p_value_at_floor: bool
    """No simulation came as far: the chance is at most the p-value."""
    effects: tuple[GearFound, ...]
    """At most two."""
    candidates: tuple[Rival, ...]
    """Nearest effects where the verdict is that none fits."""
    rms_before: float
    """Root mean square of what eq. 16 leaves."""
    rms_after: float
    """Of what eq. 16 with the effects leaves."""
    held_out_before: float
    """Of groups that the fit did not see, by eq. 16."""
    held_out_after: float | None
    """Each group (a reversal; a payload) left out in turn; None where there is one only."""
    measured: FloatArray
    """Shape (m,)."""
    predicted_before: FloatArray
    """By eq. 16, shape (m,)."""
    predicted_after: FloatArray
    """With the effects, shape (m,)."""
    notes: tuple[str, ...] = ()
    """What could not be tried, one line each."""


def rms_of(values: FloatArray) -> float:
    """Return the root mean square."""
    return float(np.sqrt((values**2).mean()))
