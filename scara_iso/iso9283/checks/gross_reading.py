"""A single reading lies far from all others.

One misread digit, half frame or bumped table carries the whole figure. The reading is counted as
it stands: look at the raw record, and repeat the test if it was a slip.
"""

import numpy as np

from scara_iso.iso9283.core.results import Finding, Findings, Measured, each_axis, poses_in_cycles
from scara_iso.iso9283.core.statistics import median
from scara_iso.run import FloatArray

CODE = "gross-reading"
BRIEF = "a reading lies far off"
_FARTHEST = 6.0
_OF_THE_OTHERS = 4.0
"""In standard deviations: of 20,000 rows of 30 Gaussian readings 0.14 % have one so far from the
others, 0.4 % by the median alone."""
_MAD_TO_SIGMA = 1.4826
_MOST = 3  # more of them are no single readings


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis with up to three readings over six sigma from the median."""
    for pose, axis in each_axis(poses_in_cycles(measured)):
        far = far_readings(axis.readings, axis.resolution)
        if far:
            named = (f"{axis.readings[k]:.7g} {axis.unit} in cycle {pose.cycle[k]}" for k in far)
            what = f"far from all others: {', '.join(named)}"
            advice = "look at the raw record"
            yield Finding(CODE, "warning", what, axis.name, pose.label, advice=advice)


def far_readings(readings: FloatArray, resolution: float | None) -> list[int]:
    """Return which of an axis' readings (n,) lie over six sigma from the median; at most three."""
    distance = np.abs(readings - median(readings))
    # A coarse dial makes the median distance 0: half a division is the least that it can mean.
    sigma = max(_MAD_TO_SIGMA * float(median(distance)), (resolution or 0.0) / 2)
    if sigma == 0:
        # Most readings are the same and no division is known: one other is far from them, of
        # several the nearest is taken as one division off.
        others = distance[distance > 0]
        sigma = float(others.min()) / 2 if len(others) > 1 else 0.0
    far = np.flatnonzero(distance > _FARTHEST * sigma)
    # Readings that crowd about the median make it small beside the scatter of all others.
    rest = np.delete(readings, far)
    if len(far) and len(rest) > 1:
        far = far[np.abs(readings[far] - rest.mean()) > _OF_THE_OTHERS * rest.std(ddof=1)]
    return far.tolist() if len(far) <= _MOST else []
