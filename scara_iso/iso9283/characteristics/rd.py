"""Distance repeatability: how much the distance between two poses varies from cycle to cycle.

RD = +/- 3 S_D, where D_j is the distance between the poses attained in cycle j and S_D their
standard deviation with n - 1, as two secondary sources give the clause. Along an axis it needs no
common scale of the two poses: a dial that is set to zero at each of them shifts every D_j alike.
In XY and XYZ it does, so it is given there only with `# dial_zero: command` and two different
command poses. Both poses must be visited in each cycle, so tables that finish one pose before they
begin the next have no RD, nor have tests of more than ten poses. It is +/- of lengths, in mm; its
interval rests on the chi-square distribution of a variance, as that of RP_a.
"""

import math
from dataclasses import replace

import numpy as np

from scara_iso.iso9283.characteristics._shapes import distances
from scara_iso.iso9283.core.results import Characteristics, Measured
from scara_iso.iso9283.core.statistics import (
    largest_calibration,
    reading_uncertainty,
    scatter_estimate,
    standard_deviation,
    three_sigma_interval,
)
from scara_iso.run import step_of

CODE = "RD"
CLAUSE = "7.3"
NEEDS = "two to ten poses that are visited in each cycle"


def compute(test: Measured) -> Characteristics:
    """Yield it for each pair of poses: along each length axis, in XY and in XYZ."""
    for found in distances(test):
        # Signed along one axis: what two zeros of the dial add is then the same in every cycle.
        estimate = scatter_estimate(
            three_sigma_interval,
            3 * standard_deviation(found.attained),
            found.attained[np.newaxis, :],
            found.axes,
            steps=[math.sqrt(2) * max(map(step_of, found.axes))],  # both readings are rounded
            clause=CLAUSE,
        )
        stated = [u for u in map(reading_uncertainty, found.axes) if u is not None]
        u = math.sqrt(2) * max(stated) if len(stated) == len(found.axes) else None
        one = found.characteristic(CODE, estimate)
        calibration = largest_calibration(found.axes)
        yield replace(one, reading_u=u, calibration=calibration, half_width=True)
