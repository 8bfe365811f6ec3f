"""The units of this trade, and the uncertainty that a resolution brings.

Inside the package a length is in millimetres and an angle in degrees; a `Unit` converts on the
way in. Factors are kept as a ratio of two numbers, so that 35 hundredths of a millimetre become
0.35 and not 0.35000000000000003.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from enum import Enum
from fractions import Fraction
from typing import Annotated, TypeVar

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import Interval, Size

Number = TypeVar("Number", float, npt.NDArray[np.float64])


class Dimension(Enum):
    """What a unit measures; the value is the unit in which the package computes."""

    LENGTH = "mm"
    ANGLE = "deg"


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit by its name and its size: ``numerator / denominator`` mm or degrees."""

    name: str
    """As it is written."""
    dimension: Dimension
    """What it measures."""
    numerator: float
    """Of its size in mm or degrees."""
    denominator: float
    """Likewise."""

    def to_base(self, value: Number) -> Number:
        """Convert a value, or an array of any shape, in this unit to mm or degrees."""
        return value * self.numerator / self.denominator

    def read(self, text: str) -> float:
        """Convert a display's decimal number to mm or degrees, rounded once.

        ``0.5660`` inch is 14.3764 mm and not 14.376399999999999. Raises `ArithmeticError`.
        """
        return float(Decimal(text) * Decimal(self.numerator) / Decimal(self.denominator))

    @property
    def other(self) -> Unit | None:
        """The unit itself where it is another than mm or degrees, or parts of these."""
        return None if self.name.endswith(self.base_name) else self

    @property
    def base_name(self) -> str:
        """Name of the unit in which converted values are: ``mm`` or ``deg``."""
        return self.dimension.value


MILLIMETRE = Unit("mm", Dimension.LENGTH, 1, 1)
DEGREE = Unit("deg", Dimension.ANGLE, 1, 1)

_UNITS = (
    MILLIMETRE,
    Unit("um", Dimension.LENGTH, 1, 1000),
    Unit("nm", Dimension.LENGTH, 1, 1_000_000),
    Unit("cm", Dimension.LENGTH, 10, 1),
    Unit("m", Dimension.LENGTH, 1000, 1),
    Unit("inch", Dimension.LENGTH, 127, 5),
    Unit("thou", Dimension.LENGTH, 127, 5000),
    DEGREE,
    Unit("rad", Dimension.ANGLE, 180, math.pi),
    Unit("mrad", Dimension.ANGLE, 180, 1000 * math.pi),
    Unit("arcmin", Dimension.ANGLE, 1, 60),
    Unit("arcsec", Dimension.ANGLE, 1, 3600),
)
_ALIASES = {
    "millimeter": "mm",
    "millimetre": "mm",
    "µm": "um",
    "μm": "um",
    "micron": "um",
    "microns": "um",
    "micrometer": "um",
    "micrometre": "um",
    "mikrometer": "um",
    "mikron": "um",
    "in": "inch",
    "inches": "inch",
    "mil": "thou",
    "mils": "thou",
    '"': "inch",
    "zoll": "inch",
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
    "'": "arcmin",
    "′": "arcmin",
    "″": "arcsec",
    "radian": "rad",
    "radians": "rad",
}
_BY_NAME = {unit.name: unit for unit in _UNITS}
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?")
_LONGEST = 60
_SCALED = re.compile(r"([0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]{1,2})?)\s*[x×*]?\s*(\D.*)")


def find_unit(text: str) -> Unit | None:
    """Return the unit that ``text`` spells, ``0.01 mm`` and aliases included, or None."""
    name = text.strip().lower()
    if len(name) > _LONGEST:
        return None
    plain = _BY_NAME.get(_ALIASES.get(name, name))
    if plain is not None:
        return plain
    scaled = _SCALED.fullmatch(name)
    if scaled is None:
        return None
    scale, base = Fraction(scaled[1]), _BY_NAME.get(_ALIASES.get(scaled[2], scaled[2]))
    if base is None or scale <= 0:
        return None
    return Unit(
        f"{scaled[1]} {base.name}",
        base.dimension,
        base.numerator * scale.numerator,
        base.denominator * scale.denominator,
    )


def parse_unit(text: str) -> Unit:
    """Return the unit that ``text`` spells; `UsageError` names the known ones otherwise."""
    unit = find_unit(text)
    if unit is None:
        raise UsageError(
            f"unknown unit {text!r}",
            remedy=f"use one of {', '.join(_BY_NAME)}, or a scaled one such as '0.01 mm'",
        )
    return unit


def parse_number(text: str) -> float | None:
    """Return the finite number that ``text`` spells in plain ASCII, or None.

    ``float`` also takes nan, inf, 1_0 and the digits of other scripts.
    """
    if _NUMBER.fullmatch(text.strip()) is None:
        return None
    value = float(text)
    return value if math.isfinite(value) else None


_WITH_UNIT = re.compile(rf"({_NUMBER.pattern})\s*([^\s0-9.,+-].*)")


def size_in(text: str, unit: str) -> float | None:
    """Return a size with its unit, such as ``20um``, in ``unit`` (`UNITS_OF_FIGURES`).

    None where it has no unit, or one of another kind.
    """
    found = _WITH_UNIT.fullmatch(text.strip())
    if found is None:
        return None
    number, name = found.groups()
    if _plain(name) == _plain(unit):
        return float(number)
    own, wanted = find_unit(name), find_unit(unit)
    if own is None or wanted is None or own.dimension is not wanted.dimension:
        return None
    return own.read(number) * wanted.denominator / wanted.numerator


def is_size(text: str) -> bool:
    """Say whether a text is a number with a unit that a figure can have."""
    return any(size_in(text, unit) is not None for unit in UNITS_OF_FIGURES)


def _plain(unit: str) -> str:
    return "".join(unit.split()).casefold()


def which_unit(option: str, given: float, unit: Unit) -> UsageError:
    """Return what asks back for the unit of a bare size, of readings in ``unit``."""
    base, other = unit.base_name, unit.name.rpartition(" ")[2]
    return UsageError(
        f"`{option}={given:g}`: {given:g} {base} or {given:g} {other}?",
        remedy=f"write `{option}={given:g}{base}` or `{option}={given:g}{other}`",
    )


TURN = 360.0
"""A full turn in degrees."""


def unwrap(
    angles: npt.NDArray[np.float64], about: npt.NDArray[np.float64] | None = None
) -> npt.NDArray[np.float64]:
    """Return angles [deg], shape (n,), with whole turns taken off so that they lie together.

    Each is taken within half a turn of what it is ``about``. Without that, angles within half a
    turn stay as they are; others are taken about their circular mean, which is put between -90
    and 270 degrees: far from 0/360 and +/-180, where instruments jump. Raises `DataError` where
    they scatter over more than half a turn.
    """
    if about is None and (len(angles) == 0 or np.ptp(angles) <= TURN / 2):
        return angles
    turns = np.round((angles - (_middle(angles) if about is None else about)) / TURN)
    # Rounded: 359.99 - 360 is meant as -0.01, on the same divisions as its neighbours.
    return np.where(turns == 0, angles, np.round(angles - TURN * turns, 9))


def _middle(angles: npt.NDArray[np.float64]) -> float:
    around = np.sort(angles % TURN)
    gaps = np.diff(around, append=around[0] + TURN)
    widest = int(np.argmax(gaps))
    if gaps[widest] < TURN / 2:
        raise DataError("the readings scatter over more than half a turn")
    middle = around[widest] + gaps[widest] / 2 + TURN / 2
    return float(middle - TURN * math.ceil((middle - 270) / TURN))


def same_turn(
    angles: npt.NDArray[np.float64], others: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return angles [deg] with the whole turns that bring their mean nearest to that of others."""
    turns = round(float(others.mean() - angles.mean()) / TURN)
    return angles if turns == 0 else angles + TURN * turns


def within_half_a_turn(difference: float) -> float:
    """Return a difference of angles [deg] without whole turns: between -180 and 180."""
    return math.remainder(difference, TURN)


UNITS_OF_FIGURES = ("mm", "deg", "h", "s", "mm/100 N", "N", "N m", "arcmin", "N m/arcmin")


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure with what is known of it; nothing here is rounded."""

    value: float
    """In `unit`."""
    unit: Annotated[str, ("enum", UNITS_OF_FIGURES)]
    """Of `value`, `u`, `parts`, `interval` and limit."""
    u: Size | None
    """Standard uncertainty: the root of the sum of squares of `parts`; None without `interval`."""
    parts: Mapping[Annotated[str, ("enum", ("sampling", "calibration", "reading"))], Size]
    """Standard uncertainties by origin: `sampling` (chance of the cycles, the dial's rounding with
    it) and what the indicator adds: `calibration` as its certificate states it, or `reading`, of a
    mean (resolution and calibration)."""
    interval: Interval | None
    """95 %; None where so few readings allow none."""
    n: Annotated[int, ("minimum", 2)]
    """Number of cycles, or of what else counts."""
    clause: str
    """Clause of ISO 9283, or equation of the paper."""

    def scaled(self, factor: float, unit: str) -> Estimate:
        """Return the same figure in another unit: everything times ``factor``, which is exact."""
        return replace(
            self,
            value=self.value * factor,
            unit=unit,
            u=None if self.u is None else self.u * factor,
            parts={name: part * factor for name, part in self.parts.items()},
            interval=None
            if self.interval is None
            else (self.interval[0] * factor, self.interval[1] * factor),
        )


def rounding_uncertainty(resolution: float) -> float:
    """Return the standard uncertainty of a reading rounded to ``resolution``: half width / sqrt(3).

    GUM (JCGM 100:2008) F.2.2.1: resolution / sqrt(12).
    """
    return resolution / math.sqrt(12)
