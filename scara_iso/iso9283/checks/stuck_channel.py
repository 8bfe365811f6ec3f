"""An axis that varies shows one reading for a long stretch of the test.

A channel that scatters over several divisions and repeats one reading ten times running has most
likely lost its target, run into its stop, or was put on hold for a while.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.iso9283.results import Finding, Measured
from scara_iso.run import FloatArray

CODE = "stuck-channel"
BRIEF = "readings stand still"
_LONGEST = 10
_LEVELS_BESIDE = 4


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each axis with ten equal readings running, and scatter beside them."""
    for pose in measured.poses:
        for axis in pose.axes.values():
            first, length = longest_stretch(axis.readings)
            beside = {*axis.readings[:first].tolist(), *axis.readings[first + length :].tolist()}
            if length >= _LONGEST and len(beside) >= _LEVELS_BESIDE:
                yield Finding(
                    CODE,
                    "warning",
                    f"{length} readings running, from cycle {pose.cycle[first]}, are all "
                    f"{axis.readings[first]:.7g} {axis.unit}: the indicator may have been stuck",
                    axis.name,
                    pose.label,
                )


def longest_stretch(readings: FloatArray) -> tuple[int, int]:
    """Return where the longest stretch of equal readings begins, and how long it is."""
    begins = np.flatnonzero(np.diff(readings, prepend=np.nan) != 0)
    lengths = np.diff(begins, append=len(readings))
    longest = int(np.argmax(lengths))
    return int(begins[longest]), int(lengths[longest])
