"""Pose repeatability of an angle: plus or minus three standard deviations.

RP_a = +/- 3 S_a, S_a with n - 1, of an axis that was given as an angle, in degrees. The paper
treats theta as the other axes, by eq. 2-6; that figure stays beside it as RP of the axis.
"""

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.core.results import (
    Characteristic,
    Characteristics,
    Measured,
    each_axis,
    poses_in_cycles,
)

CODE = "RP_a"
CLAUSE = "7.2.2"
NEEDS = "cycles at a pose, read of an axis that is an angle"


def compute(test: Measured) -> Characteristics:
    """Yield it for each angle of each pose."""
    for pose, axis in each_axis(poses_in_cycles(test)):
        if axis.dimension is Dimension.ANGLE:
            of_it = (pose.label, axis.name, axis.three_S, (axis.name, CODE))
            parts = (axis.uncertainty, axis.calibration)
            yield Characteristic(CODE, *of_it, *parts, half_width=True)
