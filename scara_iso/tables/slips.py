"""Numbers of an axis that no dial gives: a counter, metres that were micrometres, and factors."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from scara_iso.run import FloatArray, Run
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.names import Kind, clean
from scara_iso.tables.numbers import count_decimals, parse_cell
from scara_iso.tables.preamble import Statement
from scara_iso.tables.text import Row

_FACTORS = {
    "factor",
    "scale_factor",
    "multiplier",
    "faktor",
    "skalenfaktor",
    "umrechnungsfaktor",
    "multiplikator",
}
_POWER = re.compile(
    r"(?:(?:all |alle )?(?:mess)?(?:werte?|readings?|values|data|daten) ?)?"
    r"(?:mal|times|[x×·*]) ?10 ?(?:\^ ?[({]?|\*\* ?|e)?[-\u2212+⁻]?[0-9⁰¹²³⁴⁵⁶⁷⁸⁹]{1,2}[)}]?",
    re.IGNORECASE,
)
"""A line that is a factor of all values: ``Werte x 10^-3``."""
_FEWEST = 10
"""Rows from which 1, 2, 3 .. is a count and no chance."""
_MOST = 500
"""Rows beyond which a table is a stream, that no mean was typed below."""
_MEAN_BY_CHANCE = 0.01
_WIDEST_M = 20.0
"""No robot that is tested moves its dial by as much [m]."""


def check_counts(columns: Columns, faults: Faults) -> None:
    """Add each axis that counts the rows beside others, where no column numbers the cycles."""
    axes = columns.layout.of(Kind.AXIS)
    if len(axes) < 2 or columns.layout.of(Kind.CYCLE):
        return
    for column in axes:
        if _counts(columns.numbers(column)):
            faults.add(
                f"{column.name} counts the rows: is it the number of the cycle?",
                columns.layout.header_line,
                column.position + 1,
                remedy="call the column cycle; if these are readings, add a column cycle",
            )


def check_factors(
    rows: Sequence[Row], statements: Mapping[str, Statement], header_line: int, faults: Faults
) -> None:
    """Add each factor that is stated above the header: readings are multiplied by none."""
    stated = [
        (f"{key}: {quoted(statements[key].value)}", statements[key].line)
        for key in _FACTORS & statements.keys()
        if (number := parse_cell(statements[key].value)) and number.value != 1
    ]
    alone = [
        (quoted(row.text), row.line)
        for row in rows
        if row.line < header_line
        if _POWER.fullmatch(clean(row.text).strip("#,;\t :()[]"))
    ]
    for text, line in (*stated, *alone):
        faults.add(
            f"{text}, and readings are multiplied by no factor",
            line,
            remedy="state it in the unit, as '# unit: 0.01 mm', and leave this line out",
        )


def check_metres(readings: FloatArray, name: str, place: tuple[int, int], faults: Faults) -> None:
    """Add an axis whose readings [m] are whole or far apart: an export lost the µ of µm.

    ``place`` is line and field of its heading.
    """
    whole = bool(np.all(readings == np.round(readings)))
    if np.ptp(readings) > _WIDEST_M or (whole and np.ptp(readings) > 0):
        faults.add(
            f"{name} moves by {np.ptp(readings):g} m: was its unit µm?",
            *place,
            remedy="write um where the µ was lost; if these are metres, state them in mm",
        )


def _counts(values: FloatArray) -> bool:
    rows = np.arange(len(values))
    return (
        len(values) >= _FEWEST and bool(np.all(values - values[0] == rows)) and values[0] in (0, 1)
    )


def ends_in_mean(run: Run) -> bool:
    """Say whether the last row is the rounded mean of those above, on every axis.

    It is said where readings are so by chance in less than one table of a hundred.
    """
    if not _FEWEST < len(run) <= _MOST:
        return False
    chance = 1.0
    for axis in run.axes.values():
        *above, last = axis.shown.tolist()
        places = max((count_decimals(repr(x)) or 0 for x in (*above, last)), default=0)
        if round(sum(above) / len(above), places) != last:
            return False
        chance *= (1 + above.count(last)) / (1 + len(above))
    return chance < _MEAN_BY_CHANCE
