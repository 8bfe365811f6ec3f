"""Fewer than five distinct readings.

Thirty readings that fall on two, three or four divisions of the dial cannot show the shape of the
scatter; mean and spread depend on where the robot happens to stand between two divisions.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.results import Finding, Measured

CODE = "few-levels"
_FEWEST = 5


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a note for each axis with two to four distinct readings."""
    for pose in measured.poses:
        for axis in pose.axes.values():
            levels = len(set(axis.readings.tolist()))
            if 1 < levels < _FEWEST:
                yield Finding(
                    CODE,
                    "info",
                    f"only {levels} distinct readings in {axis.n} cycles",
                    axis.name,
                    pose.label,
                )
