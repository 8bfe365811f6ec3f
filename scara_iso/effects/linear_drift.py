"""A drift at constant rate: size per cycle times the cycles since the first."""

from scara_iso.effects import Conditions, KnownCourse, Parameter, as_column
from scara_iso.run import FloatArray


def _columns(conditions: Conditions) -> FloatArray:
    return as_column(conditions.elapsed)


EFFECT = KnownCourse(
    name="linear_drift",
    parameters=(Parameter("size", "b", "reading/cycle", "drift per cycle"),),
    cause="a slow thermal trend, or creep of fixture, indicator stand or belt",
    confirm_by="repeat the run after a warm-up: thermal drift has gone, creep has slowed; compare "
    "the slope of a second run",
    at_once="let the robot run warm, and check clamps and stand for creep",
    test_weight=1.2,  # benchmarks/diagnosis.py, table power
    smooth=True,
    columns=_columns,
)
