"""A sweep of measured reversals, one row each, and what is found in it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from scara_iso.base.published import MERGED
from scara_iso.diagnosis.result import GearDiagnosis
from scara_iso.effects import Sweep
from scara_iso.iso9283 import PoseResult
from scara_iso.robot import Backlash
from scara_iso.run import FloatArray
from scara_iso.tables import ColumnNames, Source, read_columns

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
class BacklashResult:
    """``backlash``: the paper's two-inertia model, beside it what was measured."""

    model: Backlash = field(metadata=MERGED)
    actual: PoseResult | None = None
    """The measured pose beside the model, as in `analyze`."""
    sweep: GearDiagnosis | None = field(default=None, metadata=MERGED)
    """With a measured sweep: what the model leaves of it, in rad."""


def rms_of(values: FloatArray) -> float:
    """Return the root mean square."""
    return float(np.sqrt((values**2).mean()))
