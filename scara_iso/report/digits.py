"""How many digits of a figure are worth printing."""

from __future__ import annotations

import math
from collections.abc import Sequence

_SIGNIFICANT = 3
_MOST_PLACES = 9


def decimals(figures: Sequence[float]) -> int:
    """Return the decimal places that give the smallest of ``figures`` three significant digits."""
    sizes = [abs(figure) for figure in figures if figure != 0 and math.isfinite(figure)]
    if not sizes:
        return _SIGNIFICANT
    return min(max(_SIGNIFICANT - 1 - math.floor(math.log10(min(sizes))), 0), _MOST_PLACES)


def four_digits(value: float) -> str:
    """Return ``value`` with four significant digits, as a power of ten where it is far from 1."""
    if value == 0 or 1e-3 <= abs(value) < 1e6:
        return f"{value:.4g}"
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{mantissa}e{int(exponent)}"
