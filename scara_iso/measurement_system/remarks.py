"""What is to be known of a study before its figures are signed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scara_iso.measurement_system.crossed import Crossed
from scara_iso.measurement_system.linearity import Linearity
from scara_iso.measurement_system.readings import GaugeReadings, Remark
from scara_iso.measurement_system.stability import Stability
from scara_iso.measurement_system.type_1 import TypeOne

_LEVEL = 0.05
_WANTED = 25
"""Readings of a type 1 study: 50 are usual, 25 the fewest (Bosch booklet 10)."""
_GOOD, _BAD = 0.1, 0.3
"""AIAG's bands of R&R: good below, not acceptable above."""
_ORIGINS = {
    "CAL": "the dial's calibration (state '# indicator_uncertainty', from its certificate)",
    "RE": "the dial's division (state '# resolution')",
    "BI": "the bias (state the true value: '# reference')",
    "LIN": "linearity (a study of its own)",
}


def study_remarks(
    readings: GaugeReadings,
    figures: TypeOne | Crossed | Linearity | Stability,
    tolerance: float | None,
    statements: Mapping[str, str],
) -> Iterator[Remark]:
    """Yield what speaks against the figures, or limits what they say."""
    axis = readings.axis
    if statements.get("simulated"):
        yield Remark("warning", axis, "SIMULATED readings: no dial was read")
    if tolerance is None:
        yield Remark("info", axis, "no tolerance is stated: nothing is held against a limit")
    yield from _of_the_dial(readings)
    match figures:
        case TypeOne():
            yield from _of_type_1(axis, figures, readings.unit)
        case Crossed():
            yield from _of_crossed(axis, figures)
        case Linearity():
            yield from _of_linearity(axis, figures)
        case Stability():
            yield from _of_stability(axis, figures, readings.unit)
    if not isinstance(figures, Stability) and figures.budget.missing:
        said = "; ".join(_ORIGINS[name] for name in figures.budget.missing)
        yield Remark("info", axis, f"not counted in u: {said}")


def _of_the_dial(readings: GaugeReadings) -> Iterator[Remark]:
    levels = len(set(readings.values.tolist()))
    if levels == 1:
        yield Remark(
            "warning",
            readings.axis,
            "all readings are alike: the dial's division hides "
            "its scatter, and what it is cannot be told",
        )
    elif levels < 4 and len(readings.values) >= 10:
        yield Remark(
            "warning",
            readings.axis,
            f"the readings take {levels} values only: the dial's division decides their scatter",
        )


def _of_type_1(axis: str, figures: TypeOne, unit: str) -> Iterator[Remark]:
    if figures.n < _WANTED:
        yield Remark("warning", axis, f"{figures.n} readings; 50 are usual, {_WANTED} the fewest")
    if figures.bias is not None and figures.p_value is not None and figures.p_value < _LEVEL:
        side = "too much" if figures.bias > 0 else "too little"
        yield Remark(
            "info",
            axis,
            f"the dial reads {side}, by {abs(figures.bias):.2g} {unit} (p = {figures.p_value:.2g})",
        )


def _of_crossed(axis: str, figures: Crossed) -> Iterator[Remark]:
    p, o, r = figures.cells.shape
    if p * max(o, 1) < 15 or r < 2:
        yield Remark("warning", axis, f"{p} parts x {o} operators: 15 or more are usual")
    if 1 < o < 3:
        yield Remark(
            "info", axis, f"{o} operators tell little of what operators make; three are usual"
        )
    whole = figures.components["GRR"]
    share, of = (whole.of_study, "TV") if whole.of_tolerance is None else (whole.of_tolerance, "T")
    if _GOOD < share <= _BAD:
        yield Remark(
            "info",
            axis,
            f"R&R is {share:.0%} of {of}: between 10 and 30 % AIAG leaves "
            "it to the use and its cost",
        )
    zero = [
        name
        for name in ("AV", "INT", "PV")
        if name in figures.components and figures.components[name].sigma == 0
    ]
    if zero:
        yield Remark("info", axis, f"{', '.join(zero)}: estimated below 0, taken as 0")


def _of_linearity(axis: str, figures: Linearity) -> Iterator[Remark]:
    if not figures.holds_zero:
        yield Remark(
            "warning",
            axis,
            "the line of the bias leaves 0 within the range (AIAG): the "
            "dial is not linear there, or reads beside",
        )
    if len(figures.references) < 5:
        yield Remark("info", axis, f"{len(figures.references)} references; five are usual")


def _of_stability(axis: str, figures: Stability, unit: str) -> Iterator[Remark]:
    if figures.outside:
        yield Remark("warning", axis, f"outside the limits: {', '.join(figures.outside)}")
    if figures.trend_p_value is not None and figures.trend_p_value < _LEVEL:
        yield Remark(
            "warning",
            axis,
            f"the mean moves by {figures.trend:.2g} {unit} a session "
            f"(p = {figures.trend_p_value:.2g})",
        )
    if len(figures.sessions) < 20:
        yield Remark("info", axis, f"{len(figures.sessions)} sessions; limits settle with 20")
