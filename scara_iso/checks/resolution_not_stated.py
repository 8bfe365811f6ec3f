"""The indicator's resolution is not stated.

Without it the dial's share of the figure is not known. State it in the table's head as
``# resolution: 0.001``, in the table's unit.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.results import Finding, Measured
from scara_iso.run import FloatArray

CODE = "resolution-not-stated"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each axis without a resolution, with the step its readings show."""
    for axis in measured.run.axes.values():
        if axis.resolution is None:
            step = _smallest_step(axis.readings)
            seen = f"; its readings differ by {step:g} {axis.unit} at least" if step else ""
            yield Finding(
                CODE,
                "warning",
                f"the resolution is not stated{seen}; uncertainty and verdict need it",
                axis.name,
            )


def _smallest_step(readings: FloatArray) -> float:
    levels = np.unique(readings)
    return float(np.diff(levels).min()) if len(levels) > 1 else 0.0
