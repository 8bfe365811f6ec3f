"""The pose was approached from both sides.

The column `approach` says it, or the line ``# approached_from: both sides``. With arrivals from
both sides the gap and the wind-up of the drive enter the figure; a unidirectional figure of a
catalogue is not comparable. ``definitions=True`` gives ISO 230-2's figures for each direction and
the reversal.
"""

import numpy as np

from scara_iso.iso9283.checks._stated import stated
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "mixed-approach"
BRIEF = "approached from both sides"
_ONE_SIDE = "one side"
_RULE = "good practice (no clause verified): every visit comes from the same side"
_BOTH = (
    "the pose is approached from both sides: RP includes the reversal; "
    "the definitions of ISO 230-2 give each direction"
)


def check(measured: Measured) -> Findings:
    """Yield a warning for each pose approached from both sides, and for an unknown coding."""
    for line in stated(measured.run.metadata, {"approached_from"}):
        if line.text.lower() != _ONE_SIDE:
            yield Finding(CODE, "warning", f"{line}, which RP includes", rule=_RULE)
    approach = measured.run.covariates.get("approach")
    if approach is None:
        return
    others = np.setdiff1d(approach, [-1, 1])
    if len(others):
        what = f"the column approach holds {others[0]:g}, where only +1 and -1 say a side"
        yield Finding(CODE, "warning", what)
        return
    for pose in measured.poses:
        if np.ptp(approach[pose.rows]) > 0:
            yield Finding(CODE, "warning", _BOTH, pose=pose.label, rule=_RULE)
