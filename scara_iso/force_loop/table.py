"""The table of a push test: force_N and reading, one row for each step."""

from __future__ import annotations

import math

from scara_iso.errors import DataError, Fault, UsageError
from scara_iso.force_loop.loop import ForceLoop
from scara_iso.quantities import Dimension, Unit, parse_unit
from scara_iso.tables import (
    ColumnNames,
    Mark,
    NamedColumns,
    Source,
    parse_cell,
    read_columns,
    read_unit,
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
    source: Source, *, unit: str | None = None, resolution: float | None = None
) -> ForceLoop:
    """Return the loop of a table with the columns force_N [N] and reading, and its unit stated.

    ``unit`` and ``resolution`` (in it) stand for the file's statements. Raises as `read_columns`,
    and `DataError` where the unit is missing, no length, or stated in two ways.
    """
    if resolution is not None and not 0 < resolution < math.inf:
        raise UsageError(f"resolution {resolution!r}", remedy="give a number above zero")
    table = read_columns(source, _COLUMNS)
    faults: list[Fault] = []
    found = _unit(table, unit, faults)
    sizes = {key: _size(table, key, found, faults) for key in _SIZES}
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


def _unit(table: NamedColumns, option: str | None, faults: list[Fault]) -> Unit | None:
    stated = {
        "the header": table.units.get("reading"),
        "# unit": table.statements.get("unit"),
    }
    found = {} if option is None else {"`unit=`": parse_unit(option)}
    for place, text in stated.items():
        if text is not None:
            unit = read_unit(text)
            if unit is None:
                faults.append(Fault(f"{place}: unknown unit {text[:30]!r}", table.header_line))
            else:
                found[place] = unit
    if not found and not faults:
        faults.append(Fault("no unit stated for reading", table.header_line))
    names = {unit.name for unit in found.values()}
    if len(names) > 1:
        said = ", ".join(f"{place} {unit.name}" for place, unit in found.items())
        faults.append(Fault(f"the unit is stated in two ways: {said}", table.header_line))
    for unit in found.values():
        if unit.dimension is not Dimension.LENGTH:
            faults.append(
                Fault(f"a dial reads lengths, not {unit.name}; state `arm=`", table.header_line)
            )
            break
    return next(iter(found.values()), None)


def _size(table: NamedColumns, key: str, unit: Unit | None, faults: list[Fault]) -> float | None:
    """Return what a statement of a size gives [mm], in the table's unit or in its own."""
    text = table.statements.get(key)
    if text is None or unit is None:
        return None
    number = parse_cell(text)
    own = read_unit(number.unit) if number and number.unit else unit
    doubtful = number is not None and number.mark in (Mark.EITHER, Mark.BOTH)
    if number is None or own is None or doubtful or not 0 < number.value < math.inf:
        faults.append(Fault(f"{key}: {text[:30]!r} is not a size above zero"))
        return None
    return own.to_base(number.value)
