"""Whether points and commas can be decimal marks or group thousands: refused where both can be."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scara_iso.quantities import Dimension
from scara_iso.run import FloatArray
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.names import Kind
from scara_iso.tables.numbers import Mark
from scara_iso.tables.statements import Scale

_WHICH_MARK = "say which mark is the decimal one: `decimal=,` or `decimal=.`"


def check_marks(columns: Columns, decimal: str | None, faults: Faults) -> None:
    """Refuse commas that may group thousands, and commas beside points."""
    marks = columns.marks
    if decimal is not None:
        return
    comma = marks.get(Mark.COMMA) or marks.get(Mark.EITHER)
    if Mark.BOTH in marks or (comma and Mark.POINT in marks):
        for mark, (line, column, text) in marks.items():
            faults.add(
                f"{quoted(text)} with {mark.value}: commas and points "
                "both occur, `decimal=` says which is decimal",
                line,
                column,
                remedy=_WHICH_MARK,
            )
    elif Mark.EITHER in marks and Mark.COMMA not in marks:
        line, column, text = marks[Mark.EITHER]
        faults.add(
            f"{quoted(text)} could have a decimal comma or group "
            "thousands: `decimal=,` or `decimal=.` says which",
            line,
            column,
            remedy=_WHICH_MARK,
        )


def check_groups(
    columns: Columns, scales: Mapping[str, Scale], decimal: str | None, faults: Faults
) -> None:
    """Refuse 1.512 um, which may be 1512: no dial shows a thousandth of a micrometre."""
    if decimal is not None or Mark.POINT not in columns.marks:
        return
    for column in columns.layout.of(Kind.AXIS):
        scale, values = scales[column.name], np.abs(columns.numbers(column))
        if _is_small(scale) and _may_be_grouped(values):
            faults.add(
                f"{values[values != np.round(values)][0]:.3f} {scale.unit.name} could have a "
                "decimal point or group thousands: `decimal=.` or `decimal=,` says which",
                int(columns.all_lines()[0]),
                column.position + 1,
                remedy=_WHICH_MARK,
            )


def _is_small(scale: Scale) -> bool:
    """Say whether the unit is so small that a dial would not part it, by its resolution or any."""
    size = scale.unit.to_base(1.0)
    small = scale.unit.dimension is Dimension.LENGTH and size <= 0.001  # mm
    return small and (scale.resolution is None or scale.resolution >= size)


def _may_be_grouped(values: FloatArray) -> bool:
    """Say whether all that are no whole numbers are spelt as 1.512 or 23.040 is."""
    parted = values[values != np.round(values)]
    thousandths = np.isclose(parted * 1000, np.round(parted * 1000), rtol=0, atol=1e-6)
    fine = np.round(parted, 2) != parted
    return bool(fine.any() and thousandths.all() and parted.min() >= 1 and parted.max() < 1000)
