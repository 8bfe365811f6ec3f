"""Each deviation is taken back in the next reading: y_j = e_j + a_j, a_(j+1) = a_j - g y_j.

At g = 1 a reading is the difference of two independent ones, e_j - e_(j-1): so it is where the
dial is set to zero at each reading, or a counter is read twice. It is the second rule of Deming's
funnel (Deming 1986, Out of the Crisis, chapter 11).
"""

import numpy as np

from scara_iso.effects import Grid, Parameter, RandomCourse
from scara_iso.run import FloatArray


def _left_alone(*, share: float) -> float:
    """Return the variance of readings that nobody corrects, over that of those corrected."""
    return 1 - share / 2


def _filtered(innovations: FloatArray, *, share: float) -> FloatArray:
    """Return readings whose variance becomes 1."""
    course: FloatArray = np.sqrt(_left_alone(share=share)) * innovations
    correction = np.zeros(course.shape[1:])
    for j in range(len(course)):
        course[j] += correction
        correction -= share * course[j]
    return course


EFFECT = RandomCourse(
    name="overcorrection",
    parameters=(
        Parameter(
            "share",
            "g",
            "",
            "share of each deviation that is taken back in the next reading",
            above=0,
            up_to=1.9,
            grid=lambda _: Grid.exact([0.7, 1.0, 1.4, 1.7]),
        ),
        Parameter("size", "σ", "reading", "standard deviation of the readings that it makes"),
    ),
    cause="a dial set to zero, or a controller corrected, by the deviation of each reading; a "
    "reading that is the difference of two",
    confirm_by="change no setting between the cycles: the scatter must become smaller",
    weight=0.1,  # benchmarks/diagnosis.py, table naming
    test_weight=0.6,  # benchmarks/diagnosis.py, table power
    common=False,
    filtered=_filtered,
    variances=(4.0, 16.0),
    stays=_left_alone,
)
