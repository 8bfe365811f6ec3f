"""Columns that are no condition of the test: they number the rows, or are made of the readings."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from scara_iso.run import CONDITIONS, FloatArray, Run
from scara_iso.tables.columns import Columns
from scara_iso.tables.doubts import declared_conditions
from scara_iso.tables.faults import NAME_CONDITION, Faults, quoted
from scara_iso.tables.names import Kind

_FEWEST, _MOST = 8, 10_000
_WITH_GAPS = 1.5
"""Numbers of rows reach so many times as far as there are rows."""
_COMPUTED, _SAME_SIZE = 0.998, 0.03
"""Correlation and size that rounding leaves to a figure of the readings beside it."""


def check_made_columns(run: Run, columns: Columns, faults: Faults) -> None:
    """Add each covariate that numbers the rows in another order, or is computed of the readings.

    As a condition the one would hide the true order of the cycles, the other explain the readings
    by themselves.
    """
    known = {c.name for c in columns.layout.of(Kind.COVARIATE) if c.condition} | CONDITIONS
    declared = declared_conditions(run.metadata.get("covariates", ""))
    for name, values in run.covariates.items() if _FEWEST <= len(run) <= _MOST else ():
        if name in known or name.lower() in declared:
            continue
        what, remedy = "", "call it cycle"
        if not columns.layout.of(Kind.CYCLE) and _numbers_rows(run, values):
            what = "numbers the rows, and they do not follow each other"
        elif figure := next(_figures_in(run, values), ""):
            what, remedy = f"is {figure} of the readings beside it", "remove the column"
        if what:
            remedy += NAME_CONDITION.format(name)
            faults.add(f"column {quoted(name)} {what}", columns.layout.header_line, remedy=remedy)


def _numbers_rows(run: Run, values: FloatArray) -> bool:
    """Say whether whole numbers from 0, 1 or 2 on stand once each, and not one after another."""
    parts = [values[rows] for _, rows in run.rows_by_pose()]
    whole = np.array_equal(values, np.round(values))
    once = whole and all(len(np.unique(part)) == len(part) >= _FEWEST for part in parts)
    if not once or any(part.min() not in (0, 1, 2) for part in parts):
        return False
    near = all(np.ptp(part) <= _WITH_GAPS * len(part) for part in parts)
    return near and not all(np.all(np.diff(part) == 1) for part in parts)


def _figures_in(run: Run, values: FloatArray) -> Iterator[str]:
    """Yield which figure of the readings of each row a column holds, in any unit of length."""
    readings = np.stack([axis.shown for axis in run.axes.values()])
    count, middle = len(readings), readings.mean(axis=0)
    figures = [
        ("the mean", middle),
        ("the sum", readings.sum(axis=0)),
        ("the range", np.ptp(readings, axis=0)),
        ("the distance", np.linalg.norm(readings, axis=0)),
        ("the distance from the mean", np.linalg.norm((readings.T - readings.mean(1)).T, axis=0)),
        ("the scatter", readings.std(axis=0)),
        ("the scatter", readings.std(axis=0) * np.sqrt(count / max(count - 1, 1))),
    ]
    pairs = combinations(run.axes, 2)
    figures += [
        (f"the difference of {a} and {b}", run.axes[a].shown - run.axes[b].shown) for a, b in pairs
    ]
    for name, figure in figures if count > 1 and np.ptp(values) > 0 else ():
        if np.ptp(figure) > 0 and abs(np.corrcoef(figure, values)[0, 1]) > _COMPUTED:
            size = float(np.std(values) / np.std(figure))
            if any(abs(size / unit - 1) < _SAME_SIZE for unit in (1e-3, 1.0, 1e3)):
                yield name
