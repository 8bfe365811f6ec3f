"""An axis varied at first and then showed one reading for the rest of the test.

A channel that scattered over several divisions and then repeats one reading to the end has most
likely lost its target, run into its stop, or was put on hold.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.results import Finding, Measured
from scara_iso.run import FloatArray

CODE = "stuck-channel"
_LONGEST = 8
_LEVELS_BEFORE = 4


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each axis that ends in at least eight equal readings after scatter."""
    for pose in measured.poses:
        for axis in pose.axes.values():
            tail = _equal_at_the_end(axis.readings)
            before = set(axis.readings[: axis.n - tail].tolist())
            if tail >= _LONGEST and len(before) >= _LEVELS_BEFORE:
                yield Finding(
                    CODE,
                    "warning",
                    f"the last {tail} readings, from cycle {pose.cycle[-tail]}, are all "
                    f"{axis.readings[-1]:g} {axis.unit}: the indicator may be stuck",
                    axis.name,
                    pose.label,
                )


def _equal_at_the_end(readings: FloatArray) -> int:
    other = np.flatnonzero(readings != readings[-1])
    return len(readings) - (int(other[-1]) + 1 if len(other) else 0)
