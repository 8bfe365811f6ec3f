"""Pose repeatability: how closely the robot comes back to the same place.

RP = l_bar + 3 S_l, where l_j is the distance of the attained position j to the barycentre, l_bar
their mean and S_l their standard deviation with n - 1: of each axis that is a length (the paper's
eq. 2-6), of the plane XY and of space XYZ (radial). No Gaussian scatter is assumed in it. Of an
angle it is RP_a.
"""

from scara_iso.base.quantities import MILLIMETRE
from scara_iso.iso9283.core.figures import EVERY_LENGTH
from scara_iso.iso9283.core.results import (
    Characteristic,
    Characteristics,
    Measured,
    poses_in_cycles,
)

CODE = "RP"
CLAUSE = "7.2.2"
NEEDS = "cycles at a pose, read along an axis that is a length"


def compute(test: Measured) -> Characteristics:
    """Yield it for each length axis, XY and XYZ of each pose."""
    for pose in poses_in_cycles(test):
        for name, found in pose.figures.items():
            if found.repeatability.unit == MILLIMETRE.name:
                of_it = (pose.label, name, found.repeatability, (name, CODE, EVERY_LENGTH))
                yield Characteristic(CODE, *of_it, found.uncertainty, found.calibration)
