"""The paper's figure of a plane: root sum of squares of the axes' repeatability.

The paper's eq. 23 combines RP of X and of Y. A limit of XY holds for the standard's own figure of
the plane, the radial RP (7.2.2); a limit of this figure is ``XY_eq23``.
"""

from scara_iso.iso9283.core.results import (
    Characteristic,
    Characteristics,
    Measured,
    poses_in_cycles,
)

CODE = "RP_rss"
CLAUSE = "paper eq. 23"
NEEDS = "cycles at a pose, read along X and Y"


def compute(test: Measured) -> Characteristics:
    """Yield it for XY of each pose."""
    for pose in poses_in_cycles(test):
        if (XY := pose.XY) is not None:
            of_it = (pose.label, "XY", XY.root_sum_of_squares, ("XY_eq23", CODE))
            yield Characteristic(CODE, *of_it, XY.uncertainty, XY.calibration)
