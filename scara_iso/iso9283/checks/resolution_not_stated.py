"""The indicator's resolution is not stated.

Without it the dial's share of the figure is unknown. Where all readings lie on equal steps, the
step is taken for the interval of RP. State it in the head of the table: ``# resolution: 0.001``, in
the table's unit.
"""

from scara_iso.iso9283.results import Finding, Findings, Measured
from scara_iso.run import common_step

CODE = "resolution-not-stated"
BRIEF = "resolution not stated"
OPTION = "`resolution=0.001`"


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis without a resolution, with the step its readings show."""
    for axis in measured.run.axes.values():
        if axis.resolution is None:
            step = common_step(axis.readings)
            taken = f"; its readings lie on steps of {step:.4g} {axis.unit}, taken as the dial's"
            what = f"the resolution is not stated{taken if step else ''}"
            advice = "state it: interval and verdict rest on it"
            yield Finding(CODE, "warning", what, axis.name, advice=advice)
