"""The data of the picture of a gauge study."""

from __future__ import annotations

import numpy as np

from scara_iso.measurement_system import (
    AxisStudy,
    Crossed,
    Linearity,
    Stability,
    TypeOne,
)
from scara_iso.reporting.blocks import Figure
from scara_iso.reporting.plotted import Chart, Curve


def study_picture(study: AxisStudy) -> Figure:
    """Return the picture of a study: its readings, and what decides."""
    figures, unit, axis = study.figures, study.readings.unit, study.readings.axis
    match figures:
        case TypeOne():
            chart, said = _type_1(study, figures), "readings in the order in which they were taken"
        case Crossed():
            chart, said = _crossed(figures, unit), "mean of each part by operator"
        case Linearity():
            chart, said = _linearity(study, figures), "bias over the true value, line and its band"
        case Stability():
            chart, said = _stability(figures, unit), "means of the sessions, and their limits"
    return Figure(chart, axis, said)


def _type_1(study: AxisStudy, figures: TypeOne) -> Chart:
    values = study.readings.values
    levels = {"mean": figures.mean}
    if figures.reference is not None:
        levels["reference"] = figures.reference
        if study.tolerance is not None:
            for sign, name in ((1, "+ 0.1 T"), (-1, "- 0.1 T")):
                levels[f"reference {name}"] = figures.reference + sign * study.tolerance / 10
    points = Curve("readings", np.arange(1.0, len(values) + 1), values, joined=False)
    return Chart("reading", study.readings.unit, (points,), levels)


def _crossed(figures: Crossed, unit: str) -> Chart:
    means = figures.cells.mean(axis=2)
    x = np.arange(1.0, len(figures.parts) + 1)
    names = figures.operators or ("mean",)
    curves = tuple(Curve(name, x, means[:, k]) for k, name in enumerate(names))
    return Chart("part", unit, curves, {}, figures.parts)


def _linearity(study: AxisStudy, figures: Linearity) -> Chart:
    x = np.asarray(study.readings.reference)
    single = Curve("bias of a reading", x, study.readings.values - x, joined=False)
    middle = (figures.lower + figures.upper) / 2
    at = figures.references
    ends = (Curve("95 % band", at, figures.lower), Curve("", at, figures.upper))
    curves = (single, Curve("line", at, middle), *ends)
    unit = study.readings.unit
    return Chart(f"true value [{unit}]", unit, curves, {"no bias": 0.0})


def _stability(figures: Stability, unit: str) -> Chart:
    x = np.arange(1.0, len(figures.means) + 1)
    low, high = figures.centre - figures.half_width, figures.centre + figures.half_width
    curves = (Curve("mean", x, figures.means), Curve("limits", x, low), Curve("", x, high))
    return Chart("session", unit, curves, {"centre": figures.centre}, figures.sessions)
