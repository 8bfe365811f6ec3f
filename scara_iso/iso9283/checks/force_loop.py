"""A force was stepped to and fro while the readings were taken, so RP is not the repeatability.

The column `force_N` goes to both sides in loops: that is a test of static compliance (clause 10)
or a push test. RP would count what the force moves as scatter. Record a repeatability test without
the force.
"""

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.core.results import Finding, Findings, Measured, each_axis, poses_in_cycles

CODE = "force-loop"
BRIEF = "RP counts what the force moves"
_SAID = (
    "a force was stepped to and fro: compliance is the figure, and RP counts what "
    "the force moves as scatter"
)


def check(measured: Measured) -> Findings:
    """Yield a warning for each length axis of a pose at which a force was stepped."""
    force = measured.run.covariates.get("force_N")
    if force is None:
        return
    from scara_iso.signals import is_loop  # noqa: PLC0415 - for few tables

    for pose, axis in each_axis(poses_in_cycles(measured)):
        if axis.dimension is Dimension.LENGTH and is_loop(force[pose.rows]):
            yield Finding(CODE, "warning", _SAID, axis.name, pose.label)
