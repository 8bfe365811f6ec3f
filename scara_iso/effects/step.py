"""A sudden shift: 0 before a cycle, the full size from it on."""

from scara_iso.effects import Conditions, Grid, KnownCourse, Parameter, as_column
from scara_iso.run import FloatArray


def _columns(conditions: Conditions, *, at_cycle: float) -> FloatArray:
    return as_column(conditions.cycle >= at_cycle)


def _starts(conditions: Conditions) -> Grid:
    """Return every cycle but the first: a shift before the last reading is an outlier's rival."""
    return Grid.exact(conditions.cycle[1:])


EFFECT = KnownCourse(
    name="step",
    parameters=(
        Parameter("at_cycle", "k", "", "first cycle after the shift", grid=_starts),
        Parameter("size", "Δ", "reading", "shift"),
    ),
    cause="fixture or indicator slipped, a collision, a skipped tooth, or a re-zeroed indicator",
    confirm_by="check the clamps of fixture and indicator, then repeat the run: the shift must "
    "not come back at the same cycle",
    at_once="check the clamps of fixture and indicator",
    weight=1.8,  # benchmarks/ablation.py
    test_weight=0.95,  # benchmarks/diagnosis.py, table power
    columns=_columns,
)
