"""Units of formulas: products of powers of symbols, compared and never converted.

The unit of a recorded column is what its name ends in, ``temperature_C``; one whose name tells
none has a unit of its own, called like the column.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias

Unit: TypeAlias = Mapping[str, Fraction]
"""Powers by symbol; none is a number."""

NUMBER: Unit = {}
_NUMBERS = {"", "1", "rad", "cycles", "cycle"}
_SAME = {"C": "°C", "degC": "°C", "percent": "%", "u": "um", "sec": "s"}
_OF_COLUMNS = {
    "C",
    "K",
    "kg",
    "g",
    "s",
    "min",
    "h",
    "mm",
    "um",
    "m",
    "N",
    "Nm",
    "V",
    "A",
    "Hz",
    "W",
    "bar",
    "hPa",
    "percent",
    "deg",
}
_FACTOR = re.compile(r"([A-Za-zµ°%]+[A-Za-z_0-9]*)(?:\^(-?[1-9]))?")


def unit_in(text: str) -> Unit | None:
    """Return the unit that ``text`` spells, such as ``mm``, ``1/s`` or ``kg*m^2``; None for none.

    ``rad`` and ``cycles`` are numbers.
    """
    unit: Unit = NUMBER
    for sign, part in re.findall(r"([*/]?)([^*/]*)", "*" + text.strip()[:60])[:-1]:
        factor = _FACTOR.fullmatch(part.strip())
        if part.strip() in _NUMBERS:
            continue
        if factor is None:
            return None
        symbol = _SAME.get(factor[1], factor[1])
        power = Fraction(int(factor[2] or 1))
        unit = times(unit, {symbol: power}, -1 if sign == "/" else 1)
    return unit


def unit_of_column(name: str) -> Unit:
    """Return the unit of a recorded column."""
    if name == "approach":  # +1 and -1
        return NUMBER
    ending = name.rpartition("_")[2]
    return {_SAME.get(ending, ending) if ending in _OF_COLUMNS else name: Fraction(1)}


def times(one: Unit, other: Unit, power: int = 1) -> Unit:
    """Return ``one`` times ``other`` to a power."""
    powers = {
        symbol: one.get(symbol, Fraction(0)) + power * other.get(symbol, Fraction(0))
        for symbol in (*one, *other)
    }
    return {symbol: n for symbol, n in powers.items() if n}


def spelled(unit: Unit) -> str:
    """Return a unit as it is written, 1 for none."""
    above = "*".join(_power(s, n) for s, n in sorted(unit.items()) if n > 0)
    below = "*".join(_power(s, -n) for s, n in sorted(unit.items()) if n < 0)
    return (above or "1") + (f"/({below})" if "*" in below else f"/{below}" if below else "")


def said_of(unit: Unit) -> str:
    """Return what a quantity of this unit is: ``in mm``, or a number."""
    return f"in {spelled(unit)}" if unit else "a number"


def _power(symbol: str, n: Fraction) -> str:
    return symbol if n == 1 else f"{symbol}^{n}"
