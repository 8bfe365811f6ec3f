"""All readings of an axis are the same, so RP is 0.

No robot repeats without scatter: either the scatter is smaller than the dial can show, or the
indicator was stuck, out of reach of the target, or on hold. The interval beside RP says how
much scatter one division can hide.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured, each_axis

CODE = "no-scatter"
BRIEF = "all readings alike"


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis with RP = 0."""
    for pose, axis in each_axis(measured.poses):
        if axis.RP == 0 and axis.readings.min() == axis.readings.max():
            what = (
                f"RP is 0: all {axis.n} readings are {axis.mean:.7g} {axis.unit}; the dial is "
                "too coarse, or was not touched"
            )
            yield Finding(CODE, "warning", what, axis.name, pose.label)
