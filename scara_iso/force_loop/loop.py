"""Forces to and fro, and the readings at each: the turns, the loops, and the force that arrives.

The table of a push test: force_N and reading, one row for each step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scara_iso.base.errors import DataError, Fault, UsageError
from scara_iso.base.quantities import Dimension, Unit
from scara_iso.run import FloatArray, IntArray, Run
from scara_iso.tables import (
    ColumnNames,
    NamedColumns,
    Source,
    read_columns,
    stated_size,
    stated_unit,
)

FEWEST_LOOPS = 2
_FEWEST_READINGS = 12
_FAR = 0.8
"""Share of the largest force from which a turn is an end of the loop."""


@dataclass(frozen=True, eq=False, slots=True)
class ForceLoop:
    """Forces [N] and the readings at them [mm], shape (n,), in the order in which they were."""

    force: FloatArray
    """Force of each step [N], shape (steps,)."""
    reading: FloatArray
    """Reading at each step [mm], shape (steps,)."""
    resolution: float | None = None
    """The dial's division [mm]; None where not stated."""
    uncertainty: float | None = None
    """Standard uncertainty of the indicator."""
    source: str = ""
    """File that it was read from."""
    notes: tuple[str, ...] = ()
    """How it was read, one line each."""


def turns(force: FloatArray) -> IntArray:
    """Return where the force turns at an end of the loop: alternately high and low."""
    ends: list[int] = []
    for k in np.flatnonzero(np.abs(force) >= _FAR * _reach(force)).tolist():
        if ends and np.sign(force[k]) == np.sign(force[ends[-1]]):
            if abs(force[k]) > abs(force[ends[-1]]):
                ends[-1] = k
        else:
            ends.append(k)
    return np.array(ends, dtype=np.int64)


def _reach(force: FloatArray) -> float:
    return float(min(force.max(), -force.min()))


def is_loop(force: FloatArray) -> bool:
    """Return whether forces go to both sides in two loops or more."""
    if len(force) < _FEWEST_READINGS or _reach(force) <= 0:
        return False
    return len(turns(force)) >= 2 * FEWEST_LOOPS


def loop_numbers(force: FloatArray, first: int, ends: IntArray) -> IntArray:
    """Return the loop of each reading from ``first`` on, shape (n - first,), counted from 0.

    A loop begins at every second end; one that is left unfinished belongs to the one before.
    """
    begins = ends[::2]
    number = np.searchsorted(begins, np.arange(first, len(force)), side="right") - 1
    whole = max((len(ends) - 1) // 2, 1)
    return np.minimum(number, whole - 1)


def transmitted(force: FloatArray, friction: FloatArray) -> FloatArray:
    """Return what Coulomb friction lets through of a force, shape (frictions, n).

    The play operator: it follows the force at a distance of ``friction``, shape (frictions,), and
    stands still after a turn until the force has come back by twice that. ``force`` begins at an
    end of the loop, so that the state there is known.
    """
    through = np.empty((len(friction), len(force)))
    state = force[0] - np.sign(force[0]) * friction
    for k, value in enumerate(force.tolist()):
        state = np.minimum(np.maximum(state, value - friction), value + friction)
        through[:, k] = state
    return through


def flank(through: FloatArray) -> FloatArray:
    """Return the flank that is in contact, shape of ``through``: its sign, or the one before."""
    sign = np.sign(through)
    for k in range(1, sign.shape[-1]):
        rests = sign[..., k] == 0
        if np.any(rests):
            sign[..., k] = np.where(rests, sign[..., k - 1], sign[..., k])
    return sign


_REMEDY = "give the columns force_N and reading, with '# unit: mm' above them"
_COLUMNS = ColumnNames(
    what="a force loop",
    needed=("force_N", "reading"),
    remedy=_REMEDY,
    with_unit=frozenset({"reading"}),
)
_SIZES = ("resolution", "indicator_uncertainty")


def read_loop(
    source: Source,
    *,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
) -> ForceLoop:
    """Return the loop of a table with the columns force_N [N] and reading, and its unit stated.

    ``unit`` and ``resolution`` (in it) stand for the file's statements, ``decimal`` as in
    `read_columns`. Raises as that, and `DataError` where the unit is missing, no length, or
    stated in two ways.
    """
    if resolution is not None and not 0 < resolution < math.inf:
        raise UsageError(f"resolution {resolution!r}", remedy="give a number above zero")
    table = read_columns(source, _COLUMNS, decimal=decimal)
    faults: list[Fault] = []
    found = _length(table, unit, faults)
    sizes = {key: stated_size(table, key, found, faults) for key in _SIZES}
    if faults or found is None:
        count = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        raise DataError(
            f"cannot be read as a force loop: {count}",
            where=table.source,
            remedy=_REMEDY,
            faults=faults,
        )
    stated = sizes["resolution"]
    return ForceLoop(
        force=table.values["force_N"],
        reading=found.to_base(table.values["reading"]),
        resolution=stated if resolution is None else found.to_base(resolution),
        uncertainty=sizes["indicator_uncertainty"],
        source=table.source,
        notes=tuple(f"column {name!r} not used" for name in table.left_out),
    )


def loop_of(run: Run, axis: str) -> ForceLoop:
    """Return the loop of an axis and the column force_N of a table of readings, every row of it.

    Raises `DataError` where there is no such length, no force, or more than one pose.
    """
    force, found = run.covariates.get("force_N"), run.axes.get(axis)
    poses = [*run.rows_by_pose()]
    if force is None or found is None or found.dimension is not Dimension.LENGTH:
        lengths = [n for n, one in run.axes.items() if one.dimension is Dimension.LENGTH]
        has = ["force_N"] * (force is not None) + lengths
        raise DataError(
            f"no force_N, or no length {axis}, is in it",
            where=run.origin.source,
            remedy=f"it has {', '.join(has) or 'neither'}",
        )
    if len(poses) > 1:
        raise DataError(
            f"{len(poses)} poses are in it, and a loop is of one",
            where=run.origin.source,
            remedy="leave the rows of one pose",
        )
    return ForceLoop(
        force=force,
        reading=found.readings,
        resolution=found.resolution,
        uncertainty=found.uncertainty,
        source=run.origin.source,
    )


def _length(table: NamedColumns, unit: str | None, faults: list[Fault]) -> Unit | None:
    found = stated_unit(table, "reading", unit, faults)
    if found is not None and found.dimension is not Dimension.LENGTH:
        said = f"a dial reads lengths, not {found.name}; state `arm=`"
        faults.append(Fault(said, table.header_line))
    return found
