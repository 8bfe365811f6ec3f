"""Figures of the readings that stand among them: a row of means is no reading.

How likely readings are such a figure by chance decides, in any language.
"""

from __future__ import annotations

import math
import re
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from scara_iso.run import FloatArray, IntArray, Run
from scara_iso.tables.columns import Columns
from scara_iso.tables.grid import NUMBER_CYCLES, Row, stripped
from scara_iso.tables.vocabulary.names import Kind
from scara_iso.tables.vocabulary.words import count_decimals, parse_cell, quoted

_FEWEST = 10
"""Rows from which a figure of them is no chance."""
_MOST = 500
"""Rows beyond which a table is a stream, that no mean was typed below."""
_BY_CHANCE, _UNDECIDED = 0.005, 0.05
_USUAL = 31
"""Rows of a test; readings of a longer table follow an order."""

_FIGURES: dict[str, Callable[[FloatArray], float]] = {
    "mean": lambda above: float(np.mean(above)),
    "median": lambda above: statistics.median(above.tolist()),
    "minimum": lambda above: float(np.min(above)),
    "maximum": lambda above: float(np.max(above)),
    "standard deviation": lambda above: float(np.std(above, ddof=1)),
    "range": lambda above: float(np.ptp(above)),
    "threefold standard deviation": lambda above: 3 * float(np.std(above, ddof=1)),
    "sixfold standard deviation": lambda above: 6 * float(np.std(above, ddof=1)),
    "sum": lambda above: float(np.sum(above)),
    "repeatability": lambda x: float(np.mean(d := np.abs(x - x.mean())) + 3 * np.std(d, ddof=1)),
}
_SPREADS = {*_FIGURES} - {"mean", "median", "minimum", "maximum"}
"""A reading near zero is as small."""
_SUMMED_UP = {*_FIGURES} - {"median", "minimum", "maximum"}  # as readings seldom are


def check_summaries(rows: Sequence[Row], columns: Columns) -> None:
    """Add each row of a word for a cycle's number, unless it holds a figure of the readings above.

    Such rows are a summary in any language; their figures may leave out the first cycle. Readings
    are so all together by chance in less than one table of two hundred; below all cycles of a
    test any figure after a word is enough.
    """
    if not rows:
        return
    (cycle, *_), axes = columns.layout.of(Kind.CYCLE), columns.layout.of(Kind.AXIS)
    above, chances = [columns.values(axis) for axis in axes], []
    for row in rows:
        read = (row.cells[c.position] for c in axes if c.position < len(row.cells))
        numbers = [one.value for cell in read if (one := parse_cell(cell, columns.decimal))]
        found = len(numbers) == len(above) and len(above[0]) >= _FEWEST
        pairs = [*zip(above, numbers, strict=found)] if found else []
        ways = [[np.append(x[k:], n) for x, n in pairs] for k in (0, 1) if pairs]
        likely = [c for way in ways for c in _figures(way).values()]
        chances.append(len(ways) * len(_FIGURES) * min(likely) if likely else 0.0)
    together = float(np.prod([chance for chance in chances if chance]))
    for row, chance in zip(rows, chances, strict=True):
        label = stripped(row.cells[cycle.position])
        below = len(above[0]) >= _USUAL and row.line > (columns.last_line or 0)
        worded = below and re.fullmatch(r"\D*", label) and re.search(r"[^\W_]{2}", label)
        if not chance or (together >= _BY_CHANCE and not worded):
            what = f"{quoted(label)} is not a cycle number"
            columns.fault(cycle, what, row.line, remedy=NUMBER_CYCLES)


def check_last_row(run: Run, columns: Columns) -> list[str]:
    """Add a last row that is a figure of the rows above it in every column: no reading.

    It is said where readings are so by chance in less than one table of two hundred;
    ``# last_row: counts`` states that it is one. So is a mean amid rows without numbers. Returned
    is a warning of a last row without a number that may be such a figure.
    """
    shown = {name: axis.shown for name, axis in run.axes.items()}
    found = _figures_in_last_row(run, shown)
    if figure := _likely(found, _BY_CHANCE):
        what = f"the last row is the {figure} of those above, in every column: no reading?"
        remedy = "if it is a reading, say '# last_row: counts' above the header"
        remedy = f"remove that {columns.faults.row}; {remedy}"
        columns.faults.add(what, columns.last_line, remedy=remedy)
    counted = columns.layout.of(Kind.CYCLE)
    numbered = counted or run.pose is not None or len(run) > _MOST
    rows = range(_FEWEST, 0 if numbered else len(run) - 1)
    written = list(map(_written, shown.values())) if rows else []
    for k in rows:
        chances = [_chance(x[: k + 1], n[: k + 1], _FIGURES["mean"]) for x, n in written]
        if 0 < np.prod(chances) * len(rows) < _BY_CHANCE:
            what = "a row is the mean of those above, in every column: no reading?"
            remedy = "remove it; if it is a reading, number the rows in a column cycle"
            columns.faults.add(what, int(columns.all_lines()[k]), remedy=remedy)
    figure = _likely(found, _UNDECIDED)
    if figure not in _SUMMED_UP or counted:
        return []
    last = f"{columns.faults.row} {columns.last_line}"
    return [f"{last} is the {figure} of the rows above: a reading?"]


def figure_in_last_row(run: Run, shown: Mapping[str, FloatArray]) -> str:
    """Return which figure of the rows above the last one seems to be, ``shown`` as in the file.

    Nothing where it is none, or the run says `last_row`.
    """
    return _likely(_figures_in_last_row(run, shown), _BY_CHANCE)


def _likely(figures: Mapping[str, float], most: float) -> str:
    return next((name for name, chance in figures.items() if chance < most), "")


def _figures_in_last_row(run: Run, shown: Mapping[str, FloatArray]) -> dict[str, float]:
    counts = run.metadata.get("last_row", "").strip().lower() == "counts"
    if counts or run.pose is not None or not _FEWEST < len(run) <= _MOST:
        return {}
    return _figures(shown.values(), run.covariates.values())


def _figures(axes: Iterable[FloatArray], others: Iterable[FloatArray] = ()) -> dict[str, float]:
    """Return of which figures of those above the last of every column is, and by which chance."""
    of_axes, of_others = (list(map(_written, columns)) for columns in (axes, others))
    found: dict[str, float] = {}
    for name, figure in _FIGURES.items():
        far = name in _SPREADS
        chance = float(np.prod([_chance(*one, figure, far=far) for one in of_axes]))
        if chance and all(_chance(*one, figure, far=far) for one in of_others):
            found[name] = chance
    return found


def _written(values: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return values and the decimals that each is written with."""
    return values, np.array([count_decimals(repr(value)) or 0 for value in values.tolist()])


def _chance(
    values: FloatArray,
    decimals: IntArray,
    figure: Callable[[FloatArray], float],
    *,
    far: bool = False,
) -> float:
    """Return by which chance the last value is the figure of those above, 0 where it is not.

    What is to be ``far`` from them is outside all of them.
    """
    above, last = values[:-1], float(values[-1])
    size = figure(above)
    inside = far and above.min() <= size <= above.max()
    if inside or not math.isclose(round(size, int(decimals.max())), last, rel_tol=1e-12):
        return 0.0
    finer = decimals[-1] > decimals[:-1].max()
    rows = min(len(values), _USUAL)
    return float(1 + np.sum(above == last)) / rows / (rows if finer else 1)
