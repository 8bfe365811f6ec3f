"""The table of a push test: force_N and reading, one row for each step."""

from __future__ import annotations

import math

from scara_iso.errors import DataError, Fault, UsageError
from scara_iso.force_loop.loop import ForceLoop
from scara_iso.quantities import Dimension, Unit
from scara_iso.run import Run
from scara_iso.tables import (
    ColumnNames,
    NamedColumns,
    Source,
    read_columns,
    stated_size,
    stated_unit,
)

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
