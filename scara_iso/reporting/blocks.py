"""The few blocks that a report is made of.

How many digits of a figure are worth printing: those that its uncertainty leaves it.

Uncertainties here are expanded ones, U: half of a 95 % interval.

Names of the code as a reader says them, and text of files as it may be shown.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_UP, Context
from typing import TYPE_CHECKING, Literal, Protocol

from scara_iso.diagnosis import UNKNOWN
from scara_iso.iso9283 import Severity
from scara_iso.run import FloatArray, IntArray

if TYPE_CHECKING:
    from scara_iso.reporting.plotted import (
        Chart,
        ControlPicture,
        Courses,
        DriftPicture,
        MonthsPicture,
        Planes,
        Predictions,
    )


Tone = Literal["plain", "quiet", "strong", "good", "warn", "bad"]


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph."""

    text: str
    tone: Tone = "plain"


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
        said = f"{self.value:{self.spec}}"
        hidden = self.spec.endswith(f".{MOST_PLACES}f") and abs(self.value) > _NOISE
        if hidden and float(said) == 0:
            said = f"{self.value:{self.spec.removesuffix(f'.{MOST_PLACES}f')}.1e}"
        elif not self.spec.endswith("e"):
            return said
        mantissa, exponent = said.split("e")
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


@dataclass(frozen=True, slots=True)
class Headline:
    """The answer in one line: as many of its parts as have room, the first in any case."""

    parts: tuple[str, ...]
    tone: Tone = "strong"


@dataclass(frozen=True, slots=True)
class NextStep:
    """A command line to be typed as it is, so never broken; ``why`` stands behind it."""

    command: str
    why: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of cells; the first is aligned to the left, the others to the right.

    A row that is not as wide as the header is a `ValueError`.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.header):
                raise ValueError(f"{len(row)} cells for {len(self.header)} columns: {row}")


def table_by_name(rows: Sequence[Mapping[str, Cell]], note: str = "") -> Table:
    """Return a table of rows by column; a column that a row does not name is empty in it."""
    header = tuple(dict.fromkeys(name for row in rows for name in row))
    return Table(header, tuple(tuple(row.get(name, "") for name in header) for row in rows), note)


@dataclass(frozen=True, eq=False, slots=True)
class Charted:
    """A table of which a row may have readings over the cycles, drawn small in the last column."""

    header: tuple[str, ...]
    rows: tuple[ChartedRow, ...]


@dataclass(frozen=True, eq=False, slots=True)
class ChartedRow:
    """The first cell is aligned to the left, the others to the right."""

    cells: tuple[Cell, ...]
    readings: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class Facts:
    """What somebody stated: names and texts; groups of them may stand beside each other."""

    rows: tuple[tuple[str, str], ...]
    heading: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Strip:
    """Readings of one axis over the cycles, to be drawn small."""

    label: str
    cycle: IntArray
    readings: FloatArray
    caption: str


@dataclass(frozen=True, slots=True)
class Notice:
    """One finding, in words."""

    severity: Severity
    code: str
    subject: str
    text: str


@dataclass(frozen=True, eq=False, slots=True)
class Figure:
    """The data of a picture, one panel for each pose, and in words what is to be seen in it."""

    data: Courses | Planes | Predictions | DriftPicture | Chart | MonthsPicture | ControlPicture
    title: str
    caption: str


@dataclass(frozen=True, slots=True)
class Signature:
    """Lines to be signed on, and what each is for."""

    lines: tuple[str, ...]


Block = Text | Headline | NextStep | Table | Charted | Facts | Strip | Notice | Figure | Signature


@dataclass(frozen=True, slots=True)
class Section:
    """Blocks under a heading; an empty heading is none."""

    heading: str
    blocks: tuple[Block, ...]
    one_of: str = ""
    """Which of several poses or tables it is about; the same for all sections of one of them."""
    new_page: bool = False
    """Whether it begins on a page of its own, where there are pages."""


Report = tuple[Section, ...]


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
    said = p_value(tested)
    return f"p {said}" if tested.p_value_at_floor else f"p = {said}"


def rounded(figure: float, U: float, *, sign: str = "", unit: str = "", mark: str = "") -> Number:
    """Return ``figure``, shown to the second digit of its uncertainty (GUM 7.2.6).

    A U of 0 stands for one that is not known: four digits then.
    """
    spec = f"{sign}.{places(U)}f" if U > 0 and math.isfinite(U) else f"{sign}.4g"
    return Number(figure, spec, unit, mark)


def interval(ends: tuple[float, float] | None) -> Interval | str:
    """Return ``0.008..0.030``, nothing for none: both ends to the second digit of half of it."""
    if ends is None:
        return ""
    U = (ends[1] - ends[0]) / 2
    return Interval(rounded(ends[0], U), rounded(ends[1], U))


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


_HIDDEN = {"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"}


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
        c.encode("unicode_escape").decode() if unicodedata.category(c) in _HIDDEN else c
        for c in text
    )
