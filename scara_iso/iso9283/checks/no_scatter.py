"""All readings of an axis are the same, so RP is 0.

No robot repeats without scatter: either the scatter is smaller than the dial can show, or the
indicator was stuck, out of reach of the target, or frozen (hold). The interval beside RP says how
much scatter one division can hide.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.results import Finding, Measured

CODE = "no-scatter"
BRIEF = "all readings alike"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each axis with RP = 0."""
    for pose in measured.poses:
        for axis in pose.axes.values():
            if axis.RP == 0 and axis.readings.min() == axis.readings.max():
                yield Finding(
                    CODE,
                    "warning",
                    f"RP is 0: all {axis.n} readings are {axis.mean:.7g} {axis.unit}; the dial is "
                    "too coarse, or was not touched",
                    axis.name,
                    pose.label,
                )
