"""A figure as it is shown: its digits by its uncertainty, its interval, its p-value, its words.

A figure is printed with as many digits as its uncertainty leaves it: U is an expanded one, half of
a 95 % interval.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_UP, Context
from typing import Literal, Protocol

from scara_iso.diagnosis import UNKNOWN
from scara_iso.iso9283 import AxisResult, RadialResult

Tone = Literal["plain", "quiet", "strong", "good", "warn", "bad"]
NOT_STATED = "not stated"
MOST_PLACES = 9
"""Decimal places at most; what they would show as zero is a power of ten."""
_NOISE = 1e-15
"""Below this is the rounding of a computer."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number with all its digits, and how it is shown: `str` rounds it.

    ``spec`` is a format specification of Python, ``.4f``, or ``.0%`` of a share, whose value is a
    fraction; ``unit`` stands behind the digits, ``mark`` before them.
    """

    value: float
    spec: str = "d"
    unit: str = ""
    mark: str = ""

    @property
    def digits(self) -> str:
        """The number as it is shown, without its unit."""
        text = f"{self.value:{self.spec}}"
        vanishes = self.spec.endswith(f".{MOST_PLACES}f") and abs(self.value) > _NOISE
        if vanishes and float(text) == 0:
            text = f"{self.value:{self.spec.removesuffix(f'.{MOST_PLACES}f')}.1e}"
        elif not self.spec.endswith("e"):
            return text
        mantissa, exponent = text.split("e")
        return f"{mantissa}e{int(exponent)}"

    def __str__(self) -> str:
        return f"{self.mark}{self.digits}{self.unit and f' {self.unit}'}"


@dataclass(frozen=True, slots=True)
class Interval:
    """The two ends of an interval; one that nothing bounds is said in words."""

    low: Number | str
    high: Number | str

    def __str__(self) -> str:
        return f"{self.low}..{self.high}"


@dataclass(frozen=True, slots=True)
class Result:
    """A figure with its interval, and what a limit makes of it, in one cell."""

    value: Number
    interval: Interval | str = ""
    verdict: str = ""
    tone: Tone = "plain"

    def __str__(self) -> str:
        ends = f"[{self.interval}]" if self.interval else ""
        return " ".join(part for part in (str(self.value), ends, self.verdict) if part)


Cell = str | Number | Interval | Result
"""Text is text: a serial number 0123 is not a number, and no format makes one of it."""


Ends = tuple[float, float] | None
"""Of a 95 % interval, where there is one."""
_SIGNIFICANT = 3
_UNKNOWN = 4
_MOST_TO_DECIDE = 15


def decimals(figures: Sequence[float]) -> int:
    """Return the decimal places that give the smallest of ``figures`` three significant digits."""
    sizes = [abs(figure) for figure in figures if figure != 0 and math.isfinite(figure)]
    if not sizes:
        return _SIGNIFICANT
    return min(max(_SIGNIFICANT - 1 - math.floor(math.log10(min(sizes))), 0), MOST_PLACES)


class Tested(Protocol):
    """A result with its p-value, and whether no shuffle came as far: then it is only a bound."""

    @property
    def p_value(self) -> float:
        """Chance of as much in scatter alone."""

    @property
    def p_value_at_floor(self) -> bool:
        """Whether nothing drawn came as far."""


def p_value(tested: Tested) -> Number | str:
    """Return ``0.034``, or the text ``<= 0.0011``: a bound is not a value to compute with."""
    if tested.p_value_at_floor:
        return f"<= {Context(prec=2, rounding=ROUND_UP).create_decimal(repr(tested.p_value))}"
    return Number(tested.p_value, ".2g")


def p_equals(tested: Tested) -> str:
    """Return ``p = 0.034`` or ``p <= 0.0011``."""
    text = p_value(tested)
    return f"p {text}" if tested.p_value_at_floor else f"p = {text}"


def rounded(figure: float, U: float, *, sign: str = "", unit: str = "", mark: str = "") -> Number:
    """Return ``figure``, shown to the second digit of its uncertainty (GUM 7.2.6).

    A U of 0 stands for one that is not known: four digits then.
    """
    spec = f"{sign}.{places(U)}f" if U > 0 and math.isfinite(U) else f"{sign}.4g"
    return Number(figure, spec, unit, mark)


def half_of(ends: Ends) -> float:
    """Return U by a 95 % interval: half of it, 0 where there is none."""
    return (ends[1] - ends[0]) / 2 if ends else 0.0


def interval(ends: Ends) -> Interval | str:
    """Return ``0.008..0.030``, nothing for none: both ends to the second digit of half of it."""
    return Interval(*(rounded(end, half_of(ends)) for end in ends)) if ends else ""


def of_scatter(figure: float, n: int) -> Number:
    """Return a figure of n scattering readings to the digits that it has."""
    return rounded(figure, U_of_scatter(figure, n))


def places_that_decide(limit: float, values: Sequence[float], fewest: int) -> int:
    """Return the decimal places with which ``values`` stand to ``limit`` as the values themselves.

    ``fewest`` at least: 0.01231 against 0.0123 needs one more than three digits.
    """
    found = fewest
    while found < _MOST_TO_DECIDE and any(
        (float(f"{value:.{found}f}") > limit) != (value > limit) for value in values
    ):
        found += 1
    return found


def U_of_scatter(figure: float, n: int) -> float:  # noqa: N802 - GUM's symbol
    """Return U of a figure of the scatter of n readings, such as S, 3 S or an rms (GUM E.4.3)."""
    return 2 * abs(figure) / math.sqrt(2 * (n - 1))


def places(U: float) -> int:
    """Return the decimal places of the second digit of an uncertainty, four digits of 0."""
    if not (U > 0 and math.isfinite(U)):
        return _UNKNOWN
    exponent = int(f"{U:.1e}".partition("e")[2])
    return min(max(1 - exponent, 0), MOST_PLACES)


def four_digits(value: float, unit: str = "") -> Number:
    """Return ``value`` with four significant digits, as a power of ten where it is far from 1."""
    near = value == 0 or 1e-3 <= abs(value) < 1e6
    return Number(value, ".4g" if near else ".3e", unit)


_UNPRINTABLE = {"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"}


def words(name: str) -> str:
    """Return an effect's or a verdict's name in words: ``warm_up`` is ``warm up``."""
    if name == UNKNOWN:
        return "no known effect"
    return name.replace("_", " ").replace("-", " ")


def printable(text: str) -> str:
    """Return ``text`` with control and formatting characters made visible."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        c.encode("unicode_escape").decode() if unicodedata.category(c) in _UNPRINTABLE else c
        for c in text
    )


def digits_of(value: float, ends: Ends, limit: float | None = None) -> int:
    """Return the decimal places that show two significant digits of the interval.

    Of a figure without one, three digits; more where a limit would seem to be on the other side.
    """
    width = ends[1] - ends[0] if ends else 0.1 * abs(value)
    found = places(width)
    if limit is None:
        return found
    return places_that_decide(limit, (value, *(ends or ())), found)


def figure_cells(
    value: float, ends: Ends, *, limit: float | None = None, mark: str = "", sign: str = ""
) -> tuple[Number, Interval | str]:
    """Return a figure and its interval, to the same place."""
    spec = f"{sign}.{digits_of(value, ends, limit)}f"
    between = Interval(*(Number(end, spec) for end in ends)) if ends else ""
    return Number(value, spec, mark=mark), between


def figure_in_words(
    name: str, value: float, ends: Ends, unit: str, *, limit: float | None = None, sign: str = ""
) -> str:
    """Return ``XY 0.014 mm [0.009, 0.022]``."""
    number, between = figure_cells(value, ends, limit=limit, sign=sign)
    return " ".join(filter(None, (name, str(number), unit, in_brackets(between))))


def in_brackets(ends: Interval | str) -> str:
    """Return ``[0.009, 0.022]``; nothing for none."""
    return f"[{ends.low}, {ends.high}]" if isinstance(ends, Interval) else ""


def U_of_RP(found: AxisResult | RadialResult, n: int) -> float:  # noqa: N802 - GUM's symbol
    """Return U of an RP of n cycles: half of its interval, where it has one."""
    return half_of(found.RP_interval) or U_of_scatter(found.RP, n)


def U_of_mean(axis: AxisResult) -> float:  # noqa: N802 - GUM's symbol
    """Return U of the mean reading: its scatter, and what the indicator adds to every reading."""
    return 2 * math.hypot(axis.three_sigma / 3 / math.sqrt(axis.n), axis.uncertainty or 0.0)
