"""An axis that varies shows one reading for a long stretch of the test.

A channel that scatters over several divisions and repeats one reading ten times running has most
likely lost its target, run into its stop or been put on hold: check it, and repeat the test.
"""

import numpy as np

from scara_iso.iso9283.core.results import Finding, Findings, Measured, each_axis

CODE = "stuck-channel"
BRIEF = "readings stand still"
_LONGEST = 10
_LEVELS_BESIDE = 4


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis with ten equal readings running, and scatter beside them."""
    for pose, axis in each_axis(measured.poses):
        begins = np.flatnonzero(np.diff(axis.readings, prepend=np.nan) != 0)
        lengths = np.diff(begins, append=axis.n)
        longest = int(np.argmax(lengths))
        first, length = int(begins[longest]), int(lengths[longest])
        beside = {*axis.readings[:first].tolist(), *axis.readings[first + length :].tolist()}
        if length >= _LONGEST and len(beside) >= _LEVELS_BESIDE:
            what = (
                f"{length} readings running, from cycle {pose.cycle[first]}, are all "
                f"{axis.readings[first]:.7g} {axis.unit}: the indicator may have been stuck"
            )
            yield Finding(CODE, "warning", what, axis.name, pose.label)
