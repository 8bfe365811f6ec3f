"""The stated resolution is not that of the readings.

Where all readings lie on coarser steps (a last digit of 0 and 5 alone), the dial's uncertainty is
computed too small. Where they fall between the divisions, the dial is finer, or the readings were
converted or averaged. Look at the dial, and correct ``# resolution``.
"""

import numpy as np

from scara_iso.iso9283.core.results import Finding, Findings, Measured
from scara_iso.run import Axis, FloatArray, seen_step

CODE = "doubtful-resolution"
BRIEF = "resolution is not as stated"
_BY_CHANCE = 0.001
_COARSER = 2
_TOLERANCE, _EQUAL = 0.02, 1e-6
_MOST_DIVISIONS = 1e9  # no dial counts farther, and beyond them a double loses the divisions


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis whose readings lie on another grid than stated."""
    for axis in measured.run.axes.values():
        size = axis.resolution
        if size is None or np.ptp(axis.shown) > _MOST_DIVISIONS * size:
            continue
        shifted = (axis.shown - axis.shown[0]) / size
        divisions = np.unique(shifted, return_index=True)[0]  # without: imports masked arrays
        on_one = np.ptp(divisions) > _EQUAL and np.ptp(np.rint(divisions)) == 0
        if on_one or np.any(np.abs(divisions - np.rint(divisions)) > _TOLERANCE):
            seen, advice = "readings fall between its divisions", ""
        elif (step := _step(axis, size, divisions)) and _chance(axis, size / step) <= _BY_CHANCE:
            seen = f"all readings lie on steps of {step:.3g} {axis.unit}"
            advice = f"look at the dial; if these are its steps, state {step:.3g} {axis.unit}"
        else:
            continue
        what = (
            f"a resolution of {size:g} {axis.unit} is stated, and {seen}; "
            "uncertainty and interval rest on it"
        )
        yield Finding(CODE, "warning", what, axis.name, advice=advice)


def _step(axis: Axis, stated: float, divisions: FloatArray) -> float:
    """Return the step on which all readings lie if it is coarser than stated, else 0."""
    common = int(np.gcd.reduce(np.rint(divisions).astype(np.int64)))
    step = max(seen_step(axis), common * stated)
    return step if step > stated * (_COARSER - _TOLERANCE) else 0.0


def _chance(axis: Axis, share: float) -> float:
    """Return how often readings on the stated steps would all lie on the coarser ones, a ``share``.

    One that equals a reading of the two before it says nothing: a robot may rest on two levels, and
    be approached from two sides in turn.
    """
    now, before, twice = axis.shown[2:], axis.shown[1:-1], axis.shown[:-2]
    others = int(np.count_nonzero((now != before) & (now != twice)))
    return float(share**others)
