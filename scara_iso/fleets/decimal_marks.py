"""Decimal commas in the text of a part: read as `read_table` does, or refused where unsure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from scara_iso.errors import DataError
from scara_iso.quantities import parse_unit
from scara_iso.tables import (
    WHICH_MARK,
    Mark,
    are_mixed,
    are_undecided,
    may_be_grouped,
    parse_cell,
)


def settle_marks(frame: Any, names: Iterable[str], decimal: str | None, where: str) -> None:
    """Put decimal points into the numbers of text columns of a pandas table.

    ``decimal`` says which mark is the decimal one. Raises `DataError` where nothing does and the
    commas of the whole part may group thousands, or stand beside points.
    """
    text = {name: list(map(str, frame[name])) for name in names}
    found = {
        name: [parse_cell(cell, decimal) for cell in cells]
        for name, cells in text.items()
        if decimal is not None or any("," in cell for cell in cells)
    }
    if decimal is None:
        _refuse_unsure(_marks(text), where)
    for name, numbers in found.items():
        frame[name] = [
            cell if number is None or number.unit else repr(number.value)
            for cell, number in zip(text[name], numbers, strict=True)
        ]


def _marks(text: Mapping[str, Sequence[str]]) -> dict[Mark, str]:
    """Return the decimal marks that occur, each with a cell that has it."""
    marks: dict[Mark, str] = {}
    for cell in (cell for cells in text.values() for cell in cells if "," in cell or "." in cell):
        number = parse_cell(cell)
        if number is not None and not number.unit:
            marks.setdefault(number.mark, cell)
    return marks


def _refuse_unsure(marks: Mapping[Mark, str], where: str) -> None:
    if are_mixed(marks):
        one = next(marks[mark] for mark in (Mark.BOTH, Mark.COMMA, Mark.EITHER) if mark in marks)
        raise DataError(f"{one!r}: commas and points both occur", where=where, remedy=WHICH_MARK)
    if are_undecided(marks):
        raise DataError(
            f"{marks[Mark.EITHER]!r} could have a decimal comma or group thousands",
            where=where,
            remedy=WHICH_MARK,
        )


def refuse_groups(frame: Any, axes: Mapping[str, Mapping[str, Any]], where: str) -> None:
    """Raise `DataError` for 1.512 um between semicolons, which may be 1512: as `read_table`."""
    for name, stated in axes.items():
        if parse_unit(stated["unit"]).name == "um" and stated["resolution"] is None:
            numbers = [number.value for cell in frame[name] if (number := parse_cell(str(cell)))]
            if numbers and may_be_grouped(np.abs(np.array(numbers))):
                raise DataError(
                    f"{name}: {frame[name].iloc[0]} um could have a decimal point or group "
                    "thousands",
                    where=where,
                    remedy=f"{WHICH_MARK}; or state the dial's resolution",
                )
