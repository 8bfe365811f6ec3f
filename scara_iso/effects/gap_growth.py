"""A gap that grows: lost motion by the recorded approach, wider from visit to visit."""

import numpy as np

from scara_iso.effects import Conditions, KnownCourse, Linear, Parameter
from scara_iso.run import FloatArray


def _columns(conditions: Conditions) -> FloatArray:
    side = np.sign(conditions.covariates["approach"])
    return np.stack([side, side * conditions.elapsed], axis=1)


EFFECT = KnownCourse(
    name="gap_growth",
    parameters=(
        Parameter("size", "h", "reading", "half of the distance between approaches, first cycle"),
        Parameter("growth", "g", "reading/cycle", "change of that half from cycle to cycle"),
    ),
    needs=("approach",),
    hidden_by=("payload_kg",),  # the load changes a reversal's width too: the gears' loop says how
    cause="a gear's gap that opens or closes during the test: a preload that gives, a bolt that "
    "turns loose, parts that warm",
    confirm_by="measure lost motion before and after a hundred further visits: it must differ",
    by_flank=True,
    weight=0.3,  # benchmarks/diagnosis.py, table gains
    linear=Linear(
        ("size", "growth"),
        lambda c: {"size": float(c[0]), "growth": float(c[1])},
        lambda v: np.array([v["size"], v["growth"]]),
    ),
    columns=_columns,
)
