"""`Axis`: the readings of one indicator axis, and its dial.

Of a dial the step counts on which its readings lie, and what its certificate corrects.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.base.published import ALWAYS, INTERNAL, Unit as BaseUnit, fill, published
from scara_iso.base.quantities import Dimension, Unit

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Commanded = float | Mapping[str, float] | None
"""A coordinate of the command pose: of the only pose, or by pose; None where not stated."""

AXES = ("X", "Y", "Z", "theta")
"""Names of the indicator axes, in the order in which they are reported."""
AxisKey: TypeAlias = Annotated[str, ("enum", AXES)]
"""One of them, as a schema says it."""

FARTHEST = 1e9
"""Largest reading, in mm or degrees, that a dial could show."""


def _base_unit(dimension: Dimension) -> BaseUnit:
    return "mm" if dimension is Dimension.LENGTH else "deg"


@dataclass(frozen=True, eq=False, slots=True)
class Axis:
    """Readings of one indicator axis over the rows of a run.

    ``readings`` has shape (rows,), in mm where ``dimension`` is a length and in degrees where it
    is an angle; ``resolution``, ``uncertainty`` (standard uncertainty of the indicator, from its
    certificate) and ``command`` are in the same unit, None where not stated. ``command`` is the
    coordinate of the command pose: a number for a run of one pose, else numbers by pose.
    """

    name: str = field(metadata=INTERNAL)
    """``X``, ``Y``, ``Z`` or ``theta``."""
    readings: FloatArray = field(repr=False)
    """By row."""
    dimension: Dimension = field(
        default=Dimension.LENGTH, metadata=published("unit", by=_base_unit)
    )
    """Of readings and resolution."""
    resolution: Annotated[float, ("exclusiveMinimum", 0)] | None = field(
        default=None, metadata=ALWAYS
    )
    """The dial's division; null where not stated."""
    uncertainty: float | None = field(default=None, metadata=INTERNAL)
    command: Commanded = field(default=None, metadata=INTERNAL)
    displayed: FloatArray | None = field(default=None, repr=False, metadata=INTERNAL)
    """The readings as the dial showed them, where `readings` are corrected; else None."""
    certified: float | None = field(default=None, metadata=INTERNAL)
    """The part of `uncertainty` that is of the certificate, where corrections add to it."""
    stated_unit: Unit | None = field(default=None, repr=False, metadata=INTERNAL)
    """In which the readings were given, where that is another than `unit`."""

    def __post_init__(self) -> None:
        fill(self, readings=read_only(self.readings, np.float64))
        if self.displayed is not None:
            fill(self, displayed=read_only(self.displayed, np.float64))
        if isinstance(self.command, Mapping):
            fill(self, command=MappingProxyType(dict(self.command)))
        for name in ("resolution", "uncertainty"):
            value = getattr(self, name)
            if value is not None and not 0 < value < FARTHEST:
                raise DataError(
                    f"axis {self.name}: a {name} of {value:g} {self.unit}",
                    remedy="state a size above 0, or leave it out",
                )

    @property
    def unit(self) -> str:
        """Unit of readings and resolution: ``mm`` or ``deg``."""
        return self.dimension.value

    @property
    def shown(self) -> FloatArray:
        """The readings on the dial's own divisions: as displayed, shape (rows,)."""
        return self.readings if self.displayed is None else self.displayed

    def take(self, rows: IntArray) -> Axis:
        """Return the axis of some of the rows."""
        displayed = None if self.displayed is None else self.displayed[rows]
        return replace(self, readings=self.readings[rows], displayed=displayed)


def beyond_dials(readings: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which readings are not finite, or beyond any dial, shape (rows,)."""
    return ~((readings >= -FARTHEST) & (readings <= FARTHEST))


def read_only(values: npt.ArrayLike, dtype: type[np.generic]) -> npt.NDArray[np.generic]:
    """Return an array that nobody can write to: itself where it is one, else a copy."""
    if (
        isinstance(values, np.ndarray)
        and np.issubdtype(values.dtype, dtype)
        and values.base is None
        and not values.flags.writeable
    ):
        return values  # of another run, or of the reader
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


_EXACT = 1e-6
_STEEPEST = 0.1
"""Largest change of the error by travel that a certificate could state."""
_WIDEST_DEG = 45.0
"""Beyond this angle a plunger measures another axis."""
_OFF_STEP = 0.02
"""Share of a step by which a reading may lie beside its multiple."""
_COARSE = (2.0, 26.0)
"""Divisions of a dial stated too fine, at 0.001 mm: 0.005 mm, or 0.0005 and 0.001 inch."""
_FEWEST_LEVELS = 3
_ROUNDED_FROM = 4.0
"""Of finer steps than so many divisions, readings that are rounded again would fill the grid."""


def step_of(axis: Axis) -> float:
    """Return the axis' resolution, else the step on which all its readings lie, 0 without one."""
    return axis.resolution or common_step(axis.shown)


def common_step(readings: FloatArray) -> float:
    """Return the smallest distance of two readings if all others are multiples of it, else 0.

    A coarse dial of which nothing is stated would pass for two levels.
    """
    distances = np.diff(np.sort(readings))
    distances = distances[distances > 0]
    if not len(distances) or distances.min() < _EXACT * np.ptp(readings):
        return 0.0
    steps = (readings - readings.min()) / distances.min()
    return float(distances.min()) if np.all(np.abs(steps - np.rint(steps)) < _OFF_STEP) else 0.0


def seen_step(axis: Axis) -> float:
    """Return `step_of`, or the coarser step on which three or more different readings lie.

    A dial of 0.0005 inch that shows 0.013, 0.025 and 0.038 mm has 0.0127 mm, whatever is stated:
    its neighbouring steps are neither two levels nor odd readings.
    """
    division = step_of(axis)
    if not division:
        return 0.0
    shown = np.rint((axis.shown - axis.shown[0]) / division)
    levels = np.unique(shown, return_index=True)[0]  # without: imports masked arrays
    if len(levels) < _FEWEST_LEVELS or np.diff(levels).min() < _COARSE[0]:
        return division
    step, off = _spaced(levels)
    rounded = 0.5 + _EXACT if step >= _ROUNDED_FROM else _OFF_STEP * step
    return step * division if step <= _COARSE[1] and off <= rounded else division


def _spaced(levels: FloatArray) -> tuple[float, float]:
    """Return the even distance of rising levels, and how far one of them lies off it at most."""
    gaps = np.diff(levels)
    step = float(gaps.min())
    for _ in range(2):
        place = np.concatenate([[0.0], np.cumsum(np.rint(gaps / step))])
        step, first = np.polyfit(place, levels, 1)
    return float(step), float(np.abs(levels - first - step * place).max())


@dataclass(frozen=True, slots=True)
class Correction:
    """What the certificate and the mounting of an indicator correct.

    ``points`` are the curve: nominal and error (indicated minus nominal), rising, in mm or degrees.
    ``zero`` is the place on the certificate's scale at which the display was zeroed; None where
    the readings are on that scale themselves. ``uncertainty`` is the standard one of the curve.
    """

    points: tuple[tuple[float, float], ...] = ()
    zero: float | None = None
    uncertainty: float | None = None
    alignment_deg: float | None = None
    """Angle between plunger and axis."""
    alignment_u_deg: float | None = None
    """Its standard uncertainty."""

    def __bool__(self) -> bool:
        return bool(self.points) or self.alignment_deg is not None

    def faults(self, dimension: Dimension) -> Iterator[str]:
        """Yield what is wrong with it."""
        nominal, error = np.array(self.points or [(0.0, 0.0)]).T
        rising = np.diff(nominal)
        if len(self.points) == 1 or np.any(rising <= 0):
            yield "a curve needs two points or more, their nominal values rising"
        elif np.any(np.abs(np.diff(error)) > _STEEPEST * rising):
            yield f"an error that changes by more than {_STEEPEST:.0%} of the travel"
        if not self and any(x is not None for x in (self.zero, self.uncertainty)):
            yield "zero or uncertainty of a curve that is not given"
        if self.alignment_deg is None and self.alignment_u_deg is not None:
            yield "the uncertainty of an angle that is not given: state 0 where it is nominal"
        if self.alignment_deg is not None and not 0 <= self.alignment_deg < _WIDEST_DEG:
            yield f"an angle of {self.alignment_deg:g} degrees between plunger and axis"
        if self.alignment_deg is not None and dimension is Dimension.ANGLE:
            yield "an angle is measured: it has no cosine error"

    def uncovered(self, axis: Axis) -> IntArray:
        """Return the rows whose readings do not lie on the curve."""
        place = axis.readings + (self.zero or 0.0)
        if not self.points:
            return np.empty(0, dtype=np.int64)
        low, high = self.points[0][0], self.points[-1][0]
        return np.flatnonzero((place < low) | (place > high))

    def applied(self, axis: Axis, *, reach: float) -> Axis:
        """Return the axis with corrected readings; all of them are to be covered.

        The error is interpolated linearly, and less that at the zero. A plunger that stands at an
        angle on a face square to the axis travels by 1 / cos of it too far. ``reach`` is the
        longest distance that is measured; the angle's part of its uncertainty (GUM F.2.4.4) and
        the curve's are added to the certificate's as independent.
        """
        nominal, error = np.array(self.points or [(0.0, 0.0)]).T
        at_zero = 0.0 if self.zero is None else np.interp(self.zero, nominal, error)
        curve = np.interp(axis.readings + (self.zero or 0.0), nominal, error) - at_zero
        angle = math.radians(self.alignment_deg or 0.0)
        u_angle = math.radians(self.alignment_u_deg or 0.0)
        u_cosine = reach * math.hypot(math.tan(angle) * u_angle, math.sqrt(2) * u_angle**2)
        u = math.hypot(axis.uncertainty or 0.0, self.uncertainty or 0.0, u_cosine)
        return replace(
            axis,
            readings=(axis.readings - curve) * math.cos(angle),
            displayed=axis.readings,
            uncertainty=u or None,
            certified=axis.uncertainty,
        )


def joined_axis(axes: Sequence[Axis], command: Commanded) -> Axis:
    """Return the readings of one axis below each other; the coarsest of its dials counts."""
    corrected = any(axis.displayed is not None for axis in axes)
    return replace(
        axes[0],
        readings=np.concatenate([axis.readings for axis in axes]),
        displayed=np.concatenate([axis.shown for axis in axes]) if corrected else None,
        resolution=_largest([axis.resolution for axis in axes]),
        uncertainty=_largest([axis.uncertainty for axis in axes]),
        certified=_largest([axis.certified for axis in axes]),
        command=command or None,
    )


def _largest(sizes: Sequence[float | None]) -> float | None:
    known = [size for size in sizes if size is not None]
    return max(known) if len(known) == len(sizes) else None
