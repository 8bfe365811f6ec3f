"""Static compliance: how far the arm gives way to a force, in mm per 100 N.

The slope of the reading over a force that is stepped to both sides in two loops or more, the play
and the friction of the joints taken apart: `scara-iso push` does the test of one joint and gives
those too. In a table of readings it needs a column `force_N`. That forces go in steps of 10 % of
the rated load, to both sides and three times, is background knowledge of the clause; the model of
spring, play and friction behind the slope is this program's choice.
"""

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.core.results import Characteristic, Characteristics, Measured, each_axis

CODE = "compliance"
CLAUSE = "10"
NEEDS = (
    "a column 'force_N' of forces stepped to both sides in two loops or more, or `scara-iso push`"
)


def compute(test: Measured) -> Characteristics:
    """Yield it for each length axis of each pose at which a force was stepped to and fro."""
    force = test.run.covariates.get("force_N")
    if force is None:
        return
    from scara_iso.iso9283.pushed_joint import compliance_estimate  # noqa: PLC0415
    from scara_iso.signals import ForceLoop, fit_loop, is_loop  # noqa: PLC0415 - for few tables

    for pose, axis in each_axis(test.poses):
        at = force[pose.rows]
        if axis.dimension is Dimension.LENGTH and is_loop(at):
            loop = ForceLoop(at, axis.readings, axis.resolution, axis.calibration)
            try:
                estimate = compliance_estimate(loop, fit_loop(loop))
            except DataError:  # this axis does not follow the force
                continue
            where = (pose.label, axis.name)
            yield Characteristic(CODE, *where, estimate, (CODE,), counted="readings")
