"""How many digits of a figure are worth printing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_UP, Context
from typing import Protocol

_SIGNIFICANT = 3
_MOST_PLACES = 9


def decimals(figures: Sequence[float]) -> int:
    """Return the decimal places that give the smallest of ``figures`` three significant digits."""
    sizes = [abs(figure) for figure in figures if figure != 0 and math.isfinite(figure)]
    if not sizes:
        return _SIGNIFICANT
    return min(max(_SIGNIFICANT - 1 - math.floor(math.log10(min(sizes))), 0), _MOST_PLACES)


class Tested(Protocol):
    """A result with its p-value, and whether no shuffle came as far: then it is only a bound."""

    @property
    def p_value(self) -> float:
        """Chance of as much in scatter alone."""

    @property
    def p_value_at_floor(self) -> bool:
        """Whether nothing drawn came as far."""


def p_value(tested: Tested) -> str:
    """Return ``0.034``, or ``<= 0.0011`` where the p-value is only a bound."""
    if tested.p_value_at_floor:
        return f"<= {Context(prec=2, rounding=ROUND_UP).create_decimal(repr(tested.p_value))}"
    return f"{tested.p_value:.2g}"


def p_equals(tested: Tested) -> str:
    """Return ``p = 0.034`` or ``p <= 0.0011``."""
    said = p_value(tested)
    return f"p {said}" if tested.p_value_at_floor else f"p = {said}"


def four_digits(value: float) -> str:
    """Return ``value`` with four significant digits, as a power of ten where it is far from 1."""
    if value == 0 or 1e-3 <= abs(value) < 1e6:
        return f"{value:.4g}"
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{mantissa}e{int(exponent)}"
