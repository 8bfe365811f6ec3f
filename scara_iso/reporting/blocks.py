"""The document of a result: sections of blocks, and the data of its pictures.

Each section is tagged; the short screen, the long one and the page are filters of one document.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from scara_iso.iso9283 import Severity
from scara_iso.run import FloatArray, IntArray

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
        _check_widths(self.rows, len(self.header))


def _check_widths(rows: Iterable[Sequence[Cell]], columns: int) -> None:
    for row in rows:
        if len(row) != columns:
            raise ValueError(f"{len(row)} cells for {columns} columns: {row}")


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


Depth = Literal["answer", "more", "detail", "appendix"]
"""How deep a reader goes: ``more`` says what lies below the answer, to who sees that alone."""
_FORMS: Mapping[str, frozenset[Depth]] = {
    "brief": frozenset({"answer", "more"}),
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


def at_depth(depth: Depth, sections: Iterable[Section]) -> Iterator[Section]:
    """Yield sections with their depth changed."""
    return (replace(section, depth=depth) for section in sections)


def answer_lines(
    lines: Sequence[Block], following: NextStep | None, *, answer: int = 2
) -> tuple[Block, ...]:
    """Return the lines with what to do next behind the ``answer``: the third, or below its list."""
    behind = max(answer, 2)
    return (*lines[:behind], *([] if following is None else [following]), *lines[behind:])


@dataclass(frozen=True, eq=False, slots=True)
class Course:
    """Readings of one axis over the cycles at one pose, with their mean and the dial's step.

    ``discarded_cycle`` and ``discarded`` are of the rows that do not count.
    """

    pose: str | None
    cycle: IntArray
    readings: FloatArray
    mean: float
    resolution: float | None
    discarded_cycle: IntArray
    discarded: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Courses:
    """The courses of one axis at some poses, in ``unit``, all within ``span`` of their means."""

    axis: str
    unit: str
    panels: tuple[Course, ...]
    span: float


@dataclass(frozen=True, eq=False, slots=True)
class Plane:
    """Attained places in the XY plane about their barycentre, with the circle of radius RP [mm].

    ``positions`` of shape (2, n), ``barycentre`` of shape (2,).
    """

    pose: str | None
    positions: FloatArray
    barycentre: FloatArray
    RP: float


@dataclass(frozen=True, eq=False, slots=True)
class Planes:
    """The planes of some poses, all within ``span`` of their barycentres [mm]."""

    panels: tuple[Plane, ...]
    span: float


@dataclass(frozen=True, eq=False, slots=True)
class Prediction:
    """Readings at one pose and what the model says of them, before and after the diagnosis."""

    pose: str | None
    cycle: IntArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class DriftPicture:
    """How far each axis moved by block [mm], what is fitted, and when it is steady [h]."""

    hours: FloatArray
    moved: Mapping[str, FloatArray]
    fitted: Mapping[str, FloatArray]
    steady: tuple[float, float, float] | None
    """Lower end, estimate and upper end."""


@dataclass(frozen=True, eq=False, slots=True)
class Predictions:
    """The predictions of one axis at some poses, in ``unit``, all within ``span`` of the mean."""

    axis: str
    unit: str
    panels: tuple[Prediction, ...]
    span: float


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """Points over a scale, shape (n,) both; ``joined`` by a line or not."""

    name: str
    x: FloatArray
    y: FloatArray
    joined: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class Chart:
    """Curves in ``unit`` over one scale, and levels by name; ``ticks`` name 1, 2, 3 and so on."""

    x_label: str
    unit: str
    curves: tuple[Curve, ...]
    levels: Mapping[str, float]
    ticks: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class MonthsPicture:
    """A figure of one robot by day (since 1970-01-01), with intervals, in ``unit``.

    ``fitted`` is what the trend expects; ``ahead`` are days and figures from the last test on.
    """

    days: FloatArray
    values: FloatArray
    ends: FloatArray
    """Lower and upper ends, shape (2, tests); NaN where there is no interval."""
    label: str
    fitted: FloatArray | None
    ahead: tuple[FloatArray, FloatArray] | None
    limit: float | None
    events: tuple[float, ...]
    """Days of the services."""


@dataclass(frozen=True, eq=False, slots=True)
class ControlPicture:
    """Lines of a control chart by day, with centre and limits of shape (tests,)."""

    days: FloatArray
    lines: Mapping[str, FloatArray]
    centre: FloatArray
    low: FloatArray
    high: FloatArray
    alarms: tuple[int, ...]
    """Tests, from 0."""
    label: str
    events: tuple[float, ...]
