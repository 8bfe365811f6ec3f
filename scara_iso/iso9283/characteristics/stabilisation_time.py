"""Stabilisation time: how long an arrival takes from first reaching its place to staying there.

Of each arrival the time from the first entry into the limit band about the attained pose to the
last; of three arrivals or more their mean, with Student's interval and the sampling interval of the
stream. `scara-iso visits` reads it from a stream of at least 50 Hz and leaves it in the table; the
dwell before every other reading must not be shorter than the longest of them. The clause is known;
the definition is background knowledge of it, not quoted, and so is that the mean is stated.
"""

import math

from scara_iso.base.quantities import parse_number
from scara_iso.iso9283.characteristics._shapes import RowsOfPoses, counted, mean_of_arrivals
from scara_iso.iso9283.core.results import Characteristics, Measured
from scara_iso.run import Axis, Run, stabilisation_column

CODE = "stabilisation_time"
CLAUSE = "7.4"
NEEDS = "three arrivals or more of a stream, as `scara-iso visits` writes them"


def compute(test: Measured) -> Characteristics:
    """Yield it for each axis of each pose whose table was made of a stream."""
    yield from stabilisation_times(test.run, counted(test))


def stabilisation_times(run: Run, poses: RowsOfPoses) -> Characteristics:
    """Yield it for the given rows of each pose."""
    rate = parse_number(run.metadata.get("stream_rate_hz", ""))
    # Each of the two crossings lies between two samples (GUM F.2.2.1).
    u = None if not rate else math.sqrt(2 / 12) / rate

    def column(axis: Axis) -> tuple[str, str, float | None]:
        return stabilisation_column(axis.name), "s", u

    yield from mean_of_arrivals(run, poses, column, CODE, CLAUSE)
