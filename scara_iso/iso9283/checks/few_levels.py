"""Fewer than five distinct readings.

Thirty readings on two, three or four divisions of the dial cannot show the shape of the scatter;
mean and spread depend on where the robot stands between two divisions. Use a finer indicator.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured, each_axis

CODE = "few-levels"
_FEWEST = 5


def check(measured: Measured) -> Findings:
    """Yield a note for each axis with two to four distinct readings."""
    for pose, axis in each_axis(measured.poses):
        levels = len(set(axis.readings.tolist()))
        if 1 < levels < _FEWEST:
            what = f"only {levels} distinct readings in {axis.n} cycles"
            yield Finding(CODE, "info", what, axis.name, pose.label)
