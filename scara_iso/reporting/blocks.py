"""The document of a result: sections of blocks, and the data of its pictures.

Each section is tagged; the short screen, the long one and the page are filters of one document. A
figure is printed with as many digits as its uncertainty leaves it: U is an expanded one, half of a
95 % interval.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_UP, Context
from typing import Literal, Protocol, TypeAlias, TypeVar

from scara_iso.diagnosis import UNKNOWN
from scara_iso.iso9283 import AxisResult, RadialResult, Severity
from scara_iso.reporting.picture_data import (
    Chart,
    ControlPicture,
    Courses,
    DriftPicture,
    MonthsPicture,
    Planes,
    Predictions,
)
from scara_iso.run import FloatArray, IntArray

Tone = Literal["plain", "quiet", "strong", "good", "warn", "bad"]


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph."""

    text: str
    tone: Tone = "plain"


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
        _check_widths(self.rows, len(self.header))


def _check_widths(rows: Iterable[Sequence[Cell]], columns: int) -> None:
    for row in rows:
        if len(row) != columns:
            raise ValueError(f"{len(row)} cells for {columns} columns: {row}")


Row = TypeVar("Row")
Columns: TypeAlias = Mapping[str, Callable[[Row], Cell]]
"""The heading of each column, and what a row has in it."""


def table_by_column(rows: Iterable[Row], columns: Columns[Row], note: str = "") -> Table:
    """Return a table by its columns: a row of it for each of ``rows``."""
    cells = tuple(tuple(column(row) for column in columns.values()) for row in rows)
    return Table(tuple(columns), cells, note)


def table_by_name(rows: Sequence[Mapping[str, Cell]], note: str = "") -> Table:
    """Return a table of rows by column; a column that a row does not name is empty in it."""
    header = tuple(dict.fromkeys(name for row in rows for name in row))
    return Table(header, tuple(tuple(row.get(name, "") for name in header) for row in rows), note)


@dataclass(frozen=True, eq=False, slots=True)
class Charted:
    """A table of which a row may have readings over the cycles, drawn small in the last column.

    A row that has not a cell for each column before that one is a `ValueError`.
    """

    header: tuple[str, ...]
    rows: tuple[ChartedRow, ...]

    def __post_init__(self) -> None:
        _check_widths([row.cells for row in self.rows], len(self.header) - 1)


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


Depth = Literal["answer", "brief", "more", "detail", "appendix"]
"""How deep a reader goes.

Who sees the answer alone gets ``brief`` in place of a ``detail``; ``more`` says what lies below.
"""
_FORMS: Mapping[str, frozenset[Depth]] = {
    "brief": frozenset({"answer", "brief", "more"}),
    "full": frozenset({"answer", "detail"}),
    "page": frozenset({"answer", "detail", "appendix"}),
}


@dataclass(frozen=True, slots=True)
class Section:
    """Blocks under a heading; an empty heading is none."""

    heading: str
    blocks: tuple[Block, ...]
    one_of: str = ""
    """Which of several poses or tables it is about; the same for all sections of one of them."""
    new_page: bool = False
    """Whether it begins on a page of its own, where there are pages."""
    depth: Depth = "answer"


Report = tuple[Section, ...]
"""The document of a result; what is shown of it is a filter by depth."""


def in_form(report: Report, form: Literal["brief", "full", "page"]) -> Report:
    """Return the sections of the short screen, of the long one, or of a page."""
    return tuple(section for section in report if section.depth in _FORMS[form])


def page_sections(report: Report) -> Report:
    """Return the sections of a page, in the blocks that a file holds: no command to be typed."""
    return tuple(
        replace(section, blocks=tuple(filter(None, map(_of_page, section.blocks))))
        for section in in_form(report, "page")
    )


def _of_page(block: Block) -> Block | None:
    match block:
        case Headline():
            return Text("; ".join(block.parts), block.tone)
        case Charted():
            return Table(block.header[:-1], tuple(row.cells for row in block.rows))
        case NextStep():
            return None
    return block


@dataclass(frozen=True, slots=True)
class Document:
    """A report as a file holds it: title and sections, and what they are about, as data.

    ``title`` identifies the report on every page; ``simulated`` is to be seen across each of them.
    """

    title: str
    sections: Report
    source: object = None
    """What it is made from: the dossier of a test, a gauge study, or None."""
    simulated: bool = False
    """Whether the readings are of no dial."""
    language: str = "en"
    """Of its labels."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "sections", page_sections(self.sections))


def at_depth(depth: Depth, sections: Iterable[Section]) -> Iterator[Section]:
    """Yield sections with their depth changed."""
    return (replace(section, depth=depth) for section in sections)


def answer_lines(
    lines: Sequence[Block], following: NextStep | None, *, answer: int = 2
) -> tuple[Block, ...]:
    """Return the lines with what to do next behind the ``answer``: the third, or below its list."""
    behind = max(answer, 2)
    return (*lines[:behind], *([] if following is None else [following]), *lines[behind:])


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
    value: float, ends: Ends, *, limit: float | None = None, mark: str = ""
) -> tuple[Number, Interval | str]:
    """Return a figure and its interval, to the same place."""
    spec = f".{digits_of(value, ends, limit)}f"
    between = Interval(*(Number(end, spec) for end in ends)) if ends else ""
    return Number(value, spec, mark=mark), between


def figure_in_words(
    name: str, value: float, ends: Ends, unit: str, *, limit: float | None = None, mark: str = ""
) -> str:
    """Return ``XY 0.014 mm [0.009, 0.022]``."""
    number, between = figure_cells(value, ends, limit=limit, mark=mark)
    text = f"{name} {number} {unit}"
    return f"{text} [{between.low}, {between.high}]" if isinstance(between, Interval) else text


def U_of_RP(found: AxisResult | RadialResult, n: int) -> float:  # noqa: N802 - GUM's symbol
    """Return U of an RP of n cycles: half of its interval, where it has one."""
    if found.RP_interval is None:
        return U_of_scatter(found.RP, n)
    return (found.RP_interval[1] - found.RP_interval[0]) / 2


def U_of_mean(axis: AxisResult) -> float:  # noqa: N802 - GUM's symbol
    """Return U of the mean reading: its scatter, and what the indicator adds to every reading."""
    return 2 * math.hypot(axis.three_sigma / 3 / math.sqrt(axis.n), axis.uncertainty or 0.0)
