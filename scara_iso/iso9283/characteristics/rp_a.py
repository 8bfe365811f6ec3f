"""Pose repeatability of an angle: plus or minus three standard deviations.

RP_a = +/- 3 S_a, S_a with n - 1, of an axis that was given as an angle, in degrees. The paper
treats theta as the other axes, by eq. 2-6; that figure stays beside it as RP of the axis.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.results import Characteristic, Measured, poses_in_cycles

CODE = "RP_a"
CLAUSE = "7.2.2"
NEEDS = "cycles at a pose, read of an axis that is an angle"


def compute(test: Measured) -> Iterator[Characteristic]:
    """Yield it for each angle of each pose."""
    for pose in poses_in_cycles(test):
        for name, axis in pose.axes.items():
            if axis.dimension is Dimension.ANGLE:
                yield Characteristic(
                    CODE,
                    pose.label,
                    name,
                    axis.three_S,
                    (name, CODE),
                    axis.uncertainty,
                    axis.calibration,
                    half_width=True,
                )
