"""The stated resolution is not that of the readings.

Where all readings lie on a grid five or more times as coarse as the stated resolution, the dial's
step is larger than stated, and its uncertainty is computed too small; where they fall between the
divisions, the dial is finer than stated, or the readings were converted or averaged. Correct
``# resolution`` (it is in the table's unit unless one stands behind it).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.iso9283.results import Finding, Measured
from scara_iso.run import FloatArray

CODE = "doubtful-resolution"
BRIEF = "resolution is not as stated"
_FEWEST_LEVELS = 4  # of random numbers, four differ by multiples of five or more once in fifty
_COARSER = 5
_TOLERANCE = 0.02
_MOST_DIVISIONS = 1e9  # no dial counts farther, and beyond them a double loses the divisions


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each axis whose readings lie on another grid than stated."""
    for axis in measured.run.axes.values():
        if axis.resolution is None or np.ptp(axis.shown) > _MOST_DIVISIONS * axis.resolution:
            continue
        shifted = (axis.shown - axis.shown[0]) / axis.resolution
        divisions = np.unique(shifted, return_index=True)[0]  # without: imports masked arrays
        if np.any(np.abs(divisions - np.rint(divisions)) > _TOLERANCE):
            seen = "readings fall between its divisions"
        elif (step := _common_step(divisions)) >= _COARSER:
            seen = f"all readings differ by multiples of {step * axis.resolution:g} {axis.unit}"
        else:
            continue
        yield Finding(
            CODE,
            "warning",
            f"a resolution of {axis.resolution:g} {axis.unit} is stated, and {seen}; "
            "uncertainty and interval rest on it",
            axis.name,
        )


def _common_step(divisions: FloatArray) -> int:
    """Return the greatest common divisor of the readings' distances, 1 where they are too few."""
    if len(divisions) < _FEWEST_LEVELS:
        return 1
    return int(np.gcd.reduce(np.rint(divisions).astype(np.int64)))
