"""A single reading that stands apart from all others."""

import numpy as np

from scara_iso.effects import Conditions, Grid, KnownCourse, Linear, Parameter, as_column
from scara_iso.run import FloatArray


def _farthest(coefficients: FloatArray) -> dict[str, float]:
    return {"size": float(coefficients[np.abs(coefficients).argmax()])}


def _columns(conditions: Conditions, *, at_cycle: float) -> FloatArray:
    return as_column(conditions.cycle == at_cycle)


EFFECT = KnownCourse(
    name="outlier",
    parameters=(
        Parameter("at_cycle", "k", "", "the cycle", grid=lambda seen: Grid.exact(seen.cycle)),
        Parameter("size", "e", "reading", "distance from the others"),
    ),
    cause="a misread or mistyped digit, a bumped table, or a damaged frame on the serial line",
    confirm_by="look at the sheet or the raw capture of that cycle",
    recurs=False,
    gain=60.0,
    linear=Linear(("size",), _farthest, lambda values: np.array([values["size"]])),
    columns=_columns,
)
