"""The data of the pictures of a document, whatever draws them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True)
class Course:
    """Readings of one axis over the cycles at one pose, with their mean and the dial's step.

    ``discarded_cycle`` and ``discarded`` are of the rows that do not count.
    """

    pose: str | None
    cycle: IntArray
    readings: FloatArray
    mean: float
    resolution: float | None
    discarded_cycle: IntArray
    discarded: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Courses:
    """The courses of one axis at some poses, in ``unit``, all within ``span`` of their means."""

    axis: str
    unit: str
    panels: tuple[Course, ...]
    span: float


@dataclass(frozen=True, eq=False, slots=True)
class Plane:
    """Attained places in the XY plane about their barycentre, with the circle of radius RP [mm].

    ``positions`` of shape (2, n), ``barycentre`` of shape (2,).
    """

    pose: str | None
    positions: FloatArray
    barycentre: FloatArray
    RP: float


@dataclass(frozen=True, eq=False, slots=True)
class Planes:
    """The planes of some poses, all within ``span`` of their barycentres [mm]."""

    panels: tuple[Plane, ...]
    span: float


@dataclass(frozen=True, eq=False, slots=True)
class Prediction:
    """Readings at one pose and what the model says of them, before and after the diagnosis."""

    pose: str | None
    cycle: IntArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class DriftPicture:
    """How far each axis moved by block [mm], what is fitted, and when it is steady [h]."""

    hours: FloatArray
    moved: Mapping[str, FloatArray]
    fitted: Mapping[str, FloatArray]
    steady: tuple[float, float, float] | None
    """Lower end, estimate and upper end."""


@dataclass(frozen=True, eq=False, slots=True)
class Predictions:
    """The predictions of one axis at some poses, in ``unit``, all within ``span`` of the mean."""

    axis: str
    unit: str
    panels: tuple[Prediction, ...]
    span: float


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """Points over a scale, shape (n,) both; ``joined`` by a line or not."""

    name: str
    x: FloatArray
    y: FloatArray
    is_line: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class Chart:
    """Curves in ``unit`` over one scale, and levels by name; ``ticks`` name 1, 2, 3 and so on."""

    x_label: str
    unit: str
    curves: tuple[Curve, ...]
    levels: Mapping[str, float]
    ticks: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class MonthsPicture:
    """A figure of one robot by day (since 1970-01-01), with intervals, in ``unit``.

    ``fitted`` is what the trend expects; ``ahead`` are days and figures from the last test on.
    """

    days: FloatArray
    values: FloatArray
    ends: FloatArray
    """Lower and upper ends, shape (2, tests); NaN where there is no interval."""
    label: str
    fitted: FloatArray | None
    ahead: tuple[FloatArray, FloatArray] | None
    limit: float | None
    events: tuple[float, ...]
    """Days of the services."""


@dataclass(frozen=True, eq=False, slots=True)
class ControlPicture:
    """Lines of a control chart by day, with centre and limits of shape (tests,)."""

    days: FloatArray
    lines: Mapping[str, FloatArray]
    centre: FloatArray
    low: FloatArray
    high: FloatArray
    alarms: tuple[int, ...]
    """Tests, from 0."""
    label: str
    events: tuple[float, ...]
