"""The readings scatter as those of another unit would.

At one pose fifty times more than at the others, or farther than any robot's: micrometres under a
heading in mm, or the other way round. Look at the display and at the heading, and state the unit.
"""

import numpy as np

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.core.results import Finding, Findings, Measured, each_axis, poses_in_cycles
from scara_iso.iso9283.core.statistics import median

CODE = "unit-in-doubt"
BRIEF = "is the unit right?"
_MOST_MM = 0.5  # RP of a SCARA is 0.01 to 0.1 mm
_LEAST_MM = 5e-5  # a tenth of the finest dial's step
_TIMES = 50  # micrometres for mm are 1000; joints make no pose 50 times worse than another


def check(measured: Measured) -> Findings:
    """Yield a warning for each pose and axis whose typical distance from its middle is odd."""
    found = [
        (pose, axis, float(median(np.abs(axis.readings - median(axis.readings)))))
        for pose, axis in each_axis(poses_in_cycles(measured))
        if axis.dimension is Dimension.LENGTH and "force_N" not in measured.run.covariates
    ]
    for pose, axis, size in found:
        others = [s for p, a, s in found if a.name == axis.name and p is not pose and s > 0]
        usual = float(np.median(others)) if len(others) > 1 else 0.0
        if size > _MOST_MM:
            what = f"half of its readings lie more than {size:.2g} mm from their middle"
        elif 0 < size < _LEAST_MM:
            what = f"half of its readings lie within {size:.2g} mm: finer than dials show"
        elif usual and size > _TIMES * usual:
            what = f"it scatters {size / usual:.0f} times more than at the other poses"
        else:
            continue
        yield Finding(CODE, "warning", what, axis.name, pose.label, advice="is the unit right?")
