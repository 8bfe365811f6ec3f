"""`Axis`: the readings of one indicator axis, with what is known of its dial."""

from __future__ import annotations

from collections.abc import Mapping
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
