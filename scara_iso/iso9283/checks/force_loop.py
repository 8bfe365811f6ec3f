"""A force was stepped to and fro while the readings were taken, so RP is no repeatability.

The column `force_N` goes to both sides in loops: that is a test of static compliance (clause 10)
or a push test. RP counts how far the force moves the arm as if the robot scattered so, and says
nothing of how it repeats a pose. Record the cycles of a repeatability test without the force.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.results import Finding, Measured, poses_in_cycles

CODE = "force-loop"
BRIEF = "RP counts what the force moves"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each length axis of a pose at which a force was stepped."""
    force = measured.run.covariates.get("force_N")
    if force is None:
        return
    from scara_iso.signals import is_loop  # noqa: PLC0415 - for few tables

    for pose in poses_in_cycles(measured):
        for axis in pose.axes.values() if is_loop(force[pose.rows]) else ():
            if axis.dimension is Dimension.LENGTH:
                yield Finding(
                    CODE,
                    "warning",
                    "a force was stepped to and fro: compliance is the figure, and RP counts what "
                    "the force moves as scatter",
                    axis.name,
                    pose.label,
                )
