"""Pieces of grammar that several dialects share: decimal numbers and the spelling of units.

No source met so far sends a decimal comma, an exponent or a digit that is not ASCII on a serial
line; a dialect's pattern takes none of them.
"""

from __future__ import annotations

import re
from collections.abc import Collection

from scara_iso.base.errors import UsageError

UNITS = {b"mm": "mm", b"in": "inch", b"inch": "inch", b"um": "um", b"deg": "deg", b"rad": "rad"}
"""Units by their spelling on the wire, in lower case."""

_DECIMAL = re.compile(r"(-?)([0-9]+)(?:\.([0-9]+))?")


def decimal_text(sign: bytes, digits: bytes) -> str:
    """Return the number that a display shows: ``-``, no leading zeros or blanks, all decimals.

    ``sign`` is ``-`` or anything that means plus; ``digits`` holds digits and at most one point.
    """
    text = digits.decode("ascii").lstrip("0 ").removesuffix(".")
    if text[:1] in ("", "."):
        text = "0" + text
    return "-" + text if sign == b"-" else text


def show_digits(
    text: str, *, digits: int, decimals: Collection[int], point: bool = True, fill: str = "0"
) -> tuple[str, str]:
    """Return sign (``+`` or ``-``) and digits of ``text`` as a display of fixed width sends them.

    The result has ``digits`` digits and, if ``point``, the point. Raises `UsageError` for what is
    no decimal number, does not fit, or has a number of decimals that the display does not have.
    """
    found = _DECIMAL.fullmatch(text)
    if found is None:
        raise UsageError(f"{text!r} is not a decimal number")
    whole, fraction = found[2].lstrip("0"), found[3] or ""
    if len(fraction) not in decimals or len(whole) + len(fraction) > digits:
        raise UsageError(
            f"{text} does not fit a display of {digits} digits",
            remedy=f"decimals: {', '.join(map(str, decimals))}",
        )
    if not whole and len(fraction) < digits:
        whole = "0"
    shown = f"{whole}.{fraction}" if point else whole + fraction
    return found[1] or "+", shown.rjust(digits + point, fill)


def spell(unit: str | None, spellings: dict[str | None, str], *, key: str) -> str:
    """Return how dialect ``key`` writes ``unit``; `UsageError` where it has no word for it."""
    if unit not in spellings:
        known = ", ".join(str(name) for name in spellings)
        raise UsageError(f"{key} cannot state the unit {unit}", remedy=f"it knows {known}")
    return spellings[unit]
