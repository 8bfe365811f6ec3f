"""A figure as it is shown: its digits by its uncertainty, its interval, its p-value, its words.

A figure is printed with as many digits as its interval, or its expanded uncertainty U, leaves it.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import ROUND_UP, Context
from typing import Literal, Protocol

import numpy as np

from scara_iso.diagnosis import UNKNOWN
from scara_iso.iso9283 import AxisResult
from scara_iso.run import FloatArray

Tone = Literal["plain", "quiet", "strong", "good", "warn", "bad"]
NOT_STATED = "not stated"
OF_EQ_23 = "_eq23"
"""Behind the name of a plane: the paper's figure of it, as a limit of it is named."""
MOST_PLACES = 9
"""Decimal places at most; what they would show as zero is a power of ten."""
_NOISE = 1e-15
"""Below this is the rounding of a computer."""
LEVELS = "▁▂▃▄▅▆▇█"
"""Of readings that are drawn in one line of text, lowest to highest."""
_UNPRINTABLE = {"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"}


@dataclass(frozen=True, slots=True)
class Number:
    """A number with all its digits, and how it is shown: `str` rounds it.

    ``spec`` is a format specification of Python, ``.4f``, or ``.0%`` of a share, whose value is a
    fraction; ``unit`` stands behind the digits, ``mark`` before them. No minus is before zero.
    """

    value: float
    spec: str = "d"
    unit: str = ""
    mark: str = ""

    @property
    def digits(self) -> str:
        """The number as it is shown, without its unit."""
        sign = "+" if self.spec.startswith("+") else ""
        spec = self.spec if self.spec == "d" else f"{sign}z{self.spec.removeprefix(sign)}"
        text = f"{self.value:{spec}}"
        vanishes = spec.endswith(f".{MOST_PLACES}f") and abs(self.value) > _NOISE
        if vanishes and float(text) == 0:
            text = f"{self.value:{sign}.1e}"
        elif not spec.endswith("e"):
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

    @property
    def in_brackets(self) -> str:
        """As it stands behind its figure."""
        return f"[{self.low}, {self.high}]"


@dataclass(frozen=True, slots=True)
class Result:
    """A figure with its interval, and what a limit makes of it, in one cell."""

    value: Number
    interval: Interval | None = None
    verdict: str = ""
    tone: Tone = "plain"

    def __str__(self) -> str:
        ends = self.interval.in_brackets if self.interval else ""
        return " ".join(filter(None, (str(self.value), ends, self.verdict)))


Cell = str | Number | Interval | Result
"""Text is text: a serial number 0123 is not a number, and no format makes one of it."""


FIGURE = "figure [95 % interval]"
"""Above the column of such results."""
Ends = tuple[float | None, float | None] | None
"""Of a 95 % interval, where there is one; an end that nothing bounds is None."""
_SIGNIFICANT = 3
_UNKNOWN = 4
_MOST_TO_DECIDE = 15


def decimals(figures: Sequence[float]) -> int:
    """Return the decimal places that give the smallest of ``figures`` three significant digits."""
    sizes = [abs(figure) for figure in figures if figure != 0 and math.isfinite(figure)]
    if not sizes:
        return _SIGNIFICANT
    return min(max(_SIGNIFICANT - 1 - math.floor(math.log10(min(sizes))), 0), MOST_PLACES)


class _Tested(Protocol):
    """A result with its p-value, and whether no shuffle came as far: then it is only a bound."""

    @property
    def p_value(self) -> float: ...
    @property
    def p_value_at_floor(self) -> bool: ...


def p_value(tested: _Tested) -> Number | str:
    """Return ``0.034``, or the text ``<= 0.0011``: a bound is not a value to compute with."""
    if tested.p_value_at_floor:
        return f"<= {Context(prec=2, rounding=ROUND_UP).create_decimal(repr(tested.p_value))}"
    return Number(tested.p_value, ".2g")


def p_equals(tested: _Tested) -> str:
    """Return ``p = 0.034`` or ``p <= 0.0011``."""
    text = p_value(tested)
    return f"p {text}" if tested.p_value_at_floor else f"p = {text}"


def rounded(figure: float, U: float, *, sign: str = "", unit: str = "") -> Number:
    """Return ``figure``, shown to the second digit of its uncertainty (GUM 7.2.6).

    A U of 0 stands for one that is not known: four digits then.
    """
    spec = f"{sign}.{places(U)}f" if U > 0 and math.isfinite(U) else f"{sign}.4g"
    return Number(figure, spec, unit)


def of_scatter(figure: float, n: int, unit: str = "") -> Number:
    """Return a figure of n scattering readings to the digits that it has."""
    return rounded(figure, U_of_scatter(figure, n), unit=unit)


def U_of_scatter(figure: float, n: int) -> float:  # noqa: N802 - GUM's symbol
    """Return U of a figure of the scatter of n readings, such as S, 3 S or an rms (GUM E.4.3)."""
    return 2 * abs(figure) / math.sqrt(2 * (n - 1))


def U_of_mean(axis: AxisResult) -> float:  # noqa: N802 - GUM's symbol
    """Return U of the mean reading: its scatter, and what the indicator adds to every reading."""
    return 2 * math.hypot(axis.three_sigma / 3 / math.sqrt(axis.n), axis.uncertainty or 0.0)


def places(U: float) -> int:
    """Return the decimal places of the second digit of an uncertainty, four digits of 0."""
    if not (U > 0 and math.isfinite(U)):
        return _UNKNOWN
    exponent = int(f"{U:.1e}".partition("e")[2])
    return min(max(1 - exponent, 0), MOST_PLACES)


def result(
    value: float,
    ends: Ends,
    unit: str = "",
    *,
    n: int = 0,
    limit: float | None = None,
    sign: str = "",
    mark: str = "",
) -> Result:
    """Return a figure with its interval, both to the second digit of the interval's width.

    To the second digit of the figure where that is further, and the interval excludes zero.
    Of a figure without one, three digits, or those that the scatter of ``n`` readings leaves; more
    where a limit would seem to be on the other side.
    """
    known = [end for end in ends or () if end is not None]
    width = 2 * U_of_scatter(value, n) if n > 1 else 0.1 * abs(value)
    if known:
        width = 2 * sum(abs(end - value) for end in known) / len(known)
    found = places(width)
    if known and min(known) * max(known) > 0:
        found = max(found, places(abs(value)))
    if limit is not None:
        found = places_that_differ([value, *known], limit, found)
    spec = f"{sign}.{found}f"
    low, high = ("any" if end is None else Number(end, spec) for end in ends or (None, None))
    return Result(Number(value, spec, unit, mark), Interval(low, high) if ends else None)


def places_that_differ(values: Sequence[float], limit: float, places: int) -> int:
    """Return the decimal places, so many or more, that show values on their side of a limit."""
    while places < _MOST_TO_DECIDE:
        shown = ((float(f"{v:.{places}f}"), v) for v in values)
        if all((a > limit) == (v > limit) and (a < limit) == (v < limit) for a, v in shown):
            break
        places += 1
    return places


def four_digits(value: float | None, unit: str = "") -> Number | str:
    """Return ``value`` with four significant digits, as a power of ten where it is far from 1."""
    if value is None:
        return ""
    near = value == 0 or 1e-3 <= abs(value) < 1e6
    return Number(value, ".4g" if near else ".3e", unit)


def numbers(values: Iterable[float], spec: str = "d") -> list[Number]:
    """Return a cell for each value, all shown alike."""
    return [Number(value, spec) for value in np.asarray([*values]).tolist()]


def many(count: int, word: str) -> str:
    """Return ``1 table``, ``2 tables``."""
    return f"{count} {word}{'s' * (count != 1)}"


def few(names: Sequence[str], most: int) -> str:
    """Return the first names, and how many more there are."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def share(ratio: float | None, spec: str = ".0%") -> Number | str:
    """Return a share of 1 in per cent; nothing for None."""
    return "" if ratio is None else Number(ratio, spec)


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


def sparkline(readings: FloatArray, levels: str = LEVELS, width: int = 60) -> str:
    """Return readings drawn one character each, lowest to highest level.

    ``readings`` of shape (n,); more than ``width`` of them are averaged in equal groups.
    """
    if len(readings) > width:
        edges = np.linspace(0, len(readings), width + 1).astype(int)
        readings = np.add.reduceat(readings, edges[:-1]) / np.diff(edges)
    low, high = float(readings.min()), float(readings.max())
    if high == low:
        return levels[len(levels) // 2] * len(readings)
    place = (readings - low) / (high - low) * (len(levels) - 1)
    return "".join(levels[k] for k in np.rint(place).astype(int))
