"""What structure of no name looks like, said."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.diagnosis import Diagnosis
from scara_iso.reporting.digits import U_of_scatter, rounded

_HELD_OUT = ("without", "with_formula")


def courses_said(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield what the unexplained looks like in each axis, in words and as a formula."""
    n = len(diagnosis.series.cycle)
    for one in diagnosis.courses:
        if one.words:
            yield f"{one.axis} {one.words}"
        if one.formula is not None:
            before, after = (
                rounded(figure, U_of_scatter(figure, n))
                for figure in (one.held_out_rms[key] for key in _HELD_OUT)
            )
            yield (
                f"{one.axis} goes about like {one.formula} (k is the cycle): error on cycles that "
                f"it has not seen {before} without it, {after} with it"
            )
