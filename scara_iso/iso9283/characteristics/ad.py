"""Distance accuracy: how far the mean distance of two poses is from the commanded one.

AD = D_bar - D_c, where D_bar is the mean of the distances between the poses attained in each cycle
and D_c that of the command poses, as two secondary sources give the clause; along an axis both are
counted in the direction commanded. It needs one scale that holds at both poses: a dial measures
over its own range only, and one that is set to zero at each pose knows no distance between them.
State `# dial_zero: command` and two different command poses; along an axis on which they do not
differ there is none. Its interval is Student's, with what the indicator adds to both readings.
"""

import math
from dataclasses import replace

import numpy as np

from scara_iso.iso9283.characteristics._shapes import Distances, distances
from scara_iso.iso9283.core.results import Characteristic, Characteristics, Measured
from scara_iso.iso9283.core.statistics import (
    dial_uncertainty,
    position_estimate,
    standard_deviation,
)
from scara_iso.run import FloatArray

CODE = "AD"
CLAUSE = "7.3"
NEEDS = (
    "two to ten poses that are visited in each cycle, read on one scale: '# dial_zero: command' "
    "and a different command pose for each"
)


def compute(test: Measured) -> Characteristics:
    """Yield it for each pair of poses on one scale: along each length axis, in XY and in XYZ."""
    for found in distances(test):
        if found.commanded is not None:
            yield _of(found, found.commanded)


def _of(found: Distances, commanded: FloatArray) -> Characteristic:
    D_c = float(np.linalg.norm(commanded))
    D = found.attained * np.sign(commanded[0]) if len(found.axes) == 1 else found.attained
    estimate = position_estimate(
        float(D.mean()) - D_c,
        S=float(standard_deviation(D)),
        n=len(D),
        reading_u=math.sqrt(2) * max(map(dial_uncertainty, found.axes)),
        unit=found.axes[0].unit,
        clause=CLAUSE,
    )
    return replace(found.characteristic(CODE, estimate), of_means=True)
