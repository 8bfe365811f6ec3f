"""Overshoot: how far an arrival goes beyond the place where it comes to rest.

Of each arrival the largest distance beyond the attained pose after the first entry into the limit
band, 0 where it stays in the band; of three arrivals or more their mean, with Student's interval
and the indicator's uncertainty. `scara-iso visits` reads it from a stream of at least 50 Hz and
leaves it in the table. The clause is known; the definition is background knowledge of it, not
quoted, and so is that the mean is stated. The height of a peak is that of
the parabola through its top, so that noise does not raise it.
"""

from scara_iso.iso9283.characteristics._shapes import RowsOfPoses, counted, mean_of_arrivals
from scara_iso.iso9283.core.results import Characteristics, Measured
from scara_iso.iso9283.core.statistics import reading_uncertainty
from scara_iso.run import Axis, Run, overshoot_column

CODE = "overshoot"
CLAUSE = "7.5"
NEEDS = "three arrivals or more of a stream, as `scara-iso visits` writes them"


def compute(test: Measured) -> Characteristics:
    """Yield it for each axis of each pose whose table was made of a stream."""
    yield from overshoots(test.run, counted(test))


def overshoots(run: Run, poses: RowsOfPoses) -> Characteristics:
    """Yield it for the given rows of each pose."""

    def column(axis: Axis) -> tuple[str, str, float | None]:
        return overshoot_column(axis.name, axis.dimension), axis.unit, reading_uncertainty(axis)

    yield from mean_of_arrivals(run, poses, column, CODE, CLAUSE)
