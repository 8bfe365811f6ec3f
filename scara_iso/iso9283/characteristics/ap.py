"""Pose accuracy: how far the mean of the attained poses lies from the command pose.

Of an axis the mean minus the command coordinate, of XY and XYZ the distance from the command pose
to the barycentre. A dial knows it only where its zero is referred to the command pose: state
`# dial_zero: command` and `# command_X` for each pose, else it is not given. Its uncertainty holds
the scatter of the mean and what the indicator adds to every reading alike.
"""

from scara_iso.base.quantities import Estimate
from scara_iso.iso9283.core.figures import AxisResult
from scara_iso.iso9283.core.results import (
    Characteristic,
    Characteristics,
    Measured,
    limit_names,
    poses_in_cycles,
)
from scara_iso.iso9283.core.statistics import dial_uncertainty, distance_estimate, position_estimate
from scara_iso.run import Run

CODE = "AP"
CLAUSE = "7.2.1"
NEEDS = (
    "the command pose of each pose ('# command_X: ...', '# command_X[P3]: ...') and dials whose "
    "zero is referred to it ('# dial_zero: command')"
)


def compute(test: Measured) -> Characteristics:
    """Yield it for each axis, XY and XYZ of each pose whose command pose the dial knows."""
    for pose in poses_in_cycles(test):
        for name, found in pose.figures.items():
            value = found.accuracy
            if value is None:
                continue
            if name in pose.axes:
                estimate = _of_axis(value, pose.axes[name], test.run)
            else:
                parts = [_of_axis(0.0, pose.axes[letter], test.run) for letter in name]
                estimate = distance_estimate(value, parts)
            names = limit_names(CODE, pose.label, name)
            yield Characteristic(CODE, pose.label, name, estimate, names, of_means=True)


def _of_axis(value: float, axis: AxisResult, run: Run) -> Estimate:
    S, u = axis.three_sigma / 3, dial_uncertainty(run.axes[axis.name])
    return position_estimate(value, S=S, n=axis.n, reading_u=u, unit=axis.unit, clause=CLAUSE)
