"""Whether points and commas can be decimal marks or group thousands: refused where both can be."""

from __future__ import annotations

from collections.abc import Container, Iterable

import numpy as np

from scara_iso.errors import UsageError
from scara_iso.run import FloatArray, Run
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.names import Kind
from scara_iso.tables.numbers import Mark, parse_cell

WHICH_MARK = "say which mark is the decimal one: `decimal=,` or `decimal=.`"


def refuse_other_marks(decimal: str | None) -> None:
    """Raise `UsageError` for what is given as the decimal mark and is none."""
    if decimal not in (None, ",", "."):
        raise UsageError(f"decimal mark {decimal!r}", remedy="use ',' or '.'")


def check_marks(
    columns: Columns, decimal: str | None, faults: Faults, sizes: Iterable[str]
) -> None:
    """Refuse commas that may group thousands, and commas beside points.

    A decimal comma in one of the ``sizes`` that the file states, as 0,001, says what commas are.
    """
    marks = columns.marks
    if decimal is not None:
        return
    if are_mixed(marks):
        for mark, (line, column, text) in marks.items():
            faults.add(
                f"{quoted(text)} with {mark.value}: commas and points "
                "both occur, `decimal=` says which is decimal",
                line,
                column,
                remedy=WHICH_MARK,
            )
    elif are_undecided(marks) and not any(map(_has_decimal_comma, sizes)):
        line, column, text = marks[Mark.EITHER]
        faults.add(
            f"{quoted(text)} could have a decimal comma or group "
            "thousands: `decimal=,` or `decimal=.` says which",
            line,
            column,
            remedy=WHICH_MARK,
        )


def _has_decimal_comma(size: str) -> bool:
    number = parse_cell(size)
    return number is not None and number.mark is Mark.COMMA


def are_mixed(marks: Container[Mark]) -> bool:
    """Say whether commas and points both occur."""
    comma = Mark.COMMA in marks or Mark.EITHER in marks
    return Mark.BOTH in marks or (comma and Mark.POINT in marks)


def are_undecided(marks: Container[Mark]) -> bool:
    """Say whether every comma may group thousands."""
    return Mark.EITHER in marks and Mark.COMMA not in marks


def check_groups(columns: Columns, run: Run, faults: Faults) -> None:
    """Refuse 1.512 um between semicolons, which may be 1512: few dials show such a small step."""
    for column in columns.layout.of(Kind.AXIS) if Mark.POINT in columns.marks else ():
        values, unit = np.abs(columns.numbers(column)), run.origin.units[column.name]
        if unit == "um" and not _on_divisions(run, column.name) and may_be_grouped(values):
            faults.add(
                f"{values[values != np.round(values)][0]:.3f} um could have a decimal point or "
                "group thousands: `decimal=.` or `decimal=,` says which",
                int(columns.all_lines()[0]),
                column.position + 1,
                remedy=f"{WHICH_MARK}; or state the dial's resolution",
            )
    faults.check()


def _on_divisions(run: Run, name: str) -> bool:
    """Say whether the readings are multiples of a resolution that is stated."""
    axis = run.axes[name]
    if axis.resolution is None:
        return False
    divisions = axis.shown / axis.resolution
    return bool(np.allclose(divisions, np.round(divisions), rtol=0, atol=1e-3))


def may_be_grouped(values: FloatArray) -> bool:
    """Say whether all that are no whole numbers are spelt as 1.512 or 23.040 is."""
    parted = values[values != np.round(values)]
    thousandths = np.isclose(parted * 1000, np.round(parted * 1000), rtol=0, atol=1e-6)
    fine = np.round(parted, 2) != parted
    return bool(fine.any() and thousandths.all() and parted.min() >= 1 and parted.max() < 1000)
