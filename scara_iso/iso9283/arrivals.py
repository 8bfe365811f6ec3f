"""Figures of arrivals from the columns of a table that was made of a stream."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from scara_iso.base.quantities import Estimate
from scara_iso.iso9283.results import Characteristic, Measured
from scara_iso.run import Axis, FloatArray, IntArray, Run

FEWEST = 3
"""Arrivals that the clauses ask for."""
ColumnOf = Callable[[Axis], tuple[str, str, float | None]]
"""An axis' column, its unit, and the standard uncertainty of one of its values."""


def counted(test: Measured) -> Iterator[tuple[str | None, IntArray]]:
    """Yield the rows that count of each pose."""
    yield from ((pose.label, pose.rows) for pose in test.poses)


def of_column(
    run: Run, poses: Iterator[tuple[str | None, IntArray]], column: ColumnOf, code: str, clause: str
) -> Iterator[Characteristic]:
    """Yield the mean of a column of each axis at each pose that has enough arrivals."""
    for label, rows in poses:
        for axis in run.axes.values():
            name, unit, reading_u = column(axis)
            if name in run.covariates and len(rows) >= FEWEST:
                estimate = _mean(run.covariates[name][rows], unit, reading_u, clause)
                yield Characteristic(
                    code, label, axis.name, estimate, (code,), reading_u, counted="arrivals"
                )


def _mean(values: FloatArray, unit: str, reading_u: float | None, clause: str) -> Estimate:
    """Return the mean with Student's interval, its reach combined with 2 ``reading_u``."""
    from scipy.special import stdtrit  # noqa: PLC0415 - only for streams

    n, value = len(values), float(values.mean())
    parts = {"sampling": float(values.std(ddof=1)) / math.sqrt(n)}
    parts |= {} if reading_u is None else {"reading": reading_u}
    reach = math.hypot(float(stdtrit(n - 1, 0.975)) * parts["sampling"], 2 * (reading_u or 0.0))
    ends = (max(value - reach, 0.0), value + reach)
    return Estimate(value, unit, math.hypot(*parts.values()), parts, ends, n, clause)
