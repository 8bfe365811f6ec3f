"""The unit of a named column, and the sizes that a table's ``# key: value`` lines state in it."""

from __future__ import annotations

import math

from scara_iso.errors import Fault
from scara_iso.quantities import Unit, parse_unit
from scara_iso.tables.faults import quoted
from scara_iso.tables.named_columns import NamedColumns
from scara_iso.tables.names import read_unit
from scara_iso.tables.numbers import Mark, parse_cell


def stated_unit(
    table: NamedColumns, column: str, option: str | None, faults: list[Fault]
) -> Unit | None:
    """Return the unit of a column: of its header, of ``# unit``, or ``option``, None for none.

    ``# unit_theta`` holds for that column in place of ``# unit``. A unit that is not known, or is
    stated in two ways, is a fault. Raises `UsageError` for an option that is no unit.
    """
    own = f"unit_{column.lower()}"
    key = own if own in table.statements else "unit"
    stated = {
        "the header": table.units.get(column),
        f"# {key}": table.statements.get(key),
    }
    found = {} if option is None else {"`unit=`": parse_unit(option)}
    before = len(faults)
    for place, text in stated.items():
        if text is not None:
            unit = read_unit(text)
            if unit is None:
                faults.append(Fault(f"{place}: unknown unit {text[:30]!r}", table.header_line))
            else:
                found[place] = unit
    if not found and len(faults) == before:
        faults.append(Fault(f"no unit stated for {column}", table.header_line))
    if len({unit.name for unit in found.values()}) > 1:
        said = ", ".join(f"{place} {unit.name}" for place, unit in found.items())
        faults.append(Fault(f"the unit is stated in two ways: {said}", table.header_line))
    return next(iter(found.values()), None)


def stated_size(
    table: NamedColumns,
    key: str,
    unit: Unit | None,
    faults: list[Fault],
    *,
    above_zero: bool = True,
) -> float | None:
    """Return what a statement gives [mm, deg], in ``unit`` or in its own; None for none.

    What is no number, can be read two ways, or is not above zero where it must be, is a fault.
    """
    text = table.statements.get(key)
    if text is None or unit is None:
        return None
    number = parse_cell(text, table.decimal)
    own = read_unit(number.unit) if number and number.unit else unit
    sure = table.decimal is not None
    doubtful = not sure and number is not None and number.mark in (Mark.EITHER, Mark.BOTH)
    if number is None or own is None or own.dimension is not unit.dimension or doubtful:
        faults.append(Fault(f"{key}: {quoted(text)} is not a size in {unit.name}"))
        return None
    if above_zero and not 0 < number.value < math.inf:
        faults.append(Fault(f"{key}: {quoted(text)} is not a size above zero"))
        return None
    return own.to_base(number.value)
