"""Theta is given as a length.

A dial that touches a lever shows a displacement, not an angle: the same rotation reads twice as
much at twice the radius. With ``# theta_radius_mm: R`` in the table's head the angle is given too.
"""

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "theta-as-length"


def check(measured: Measured) -> Findings:
    """Yield a note where theta is a length of unknown radius."""
    theta = measured.run.axes.get("theta")
    if theta is None or theta.dimension is not Dimension.LENGTH:
        return
    if "theta_radius_mm" not in measured.run.metadata:
        what = "given as a length at a radius that is not stated: no angle can be given"
        yield Finding(CODE, "info", what, "theta", advice="add '# theta_radius_mm: R'")
