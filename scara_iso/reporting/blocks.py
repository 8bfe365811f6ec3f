"""The few blocks that a report is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

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
