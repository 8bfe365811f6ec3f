"""The document of a result: sections of blocks, and the data of its pictures.

Each section is tagged; the short screen, the long one and the page are filters of one document.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar

from scara_iso.base.published import fill
from scara_iso.iso9283 import Severity
from scara_iso.reporting.shared.digits import Cell, Number, Tone
from scara_iso.run import FloatArray


@cache
def texts() -> Mapping[str, Any]:
    """Return what texts.toml holds: notes, and the terms that `explain` knows."""
    return tomllib.loads(Path(__file__).with_name("texts.toml").read_text("utf-8"))


def note(name: str) -> str:
    """Return a note of texts.toml on one line."""
    return " ".join(texts()["notes"][name].split())


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph, and parts behind it: on a screen as many as have room in its line."""

    text: str
    tone: Tone = "plain"
    parts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class NextStep:
    """A command line to be typed as it is, so never broken; ``why`` stands behind it."""

    command: str
    why: str = ""
    in_full: bool = False
    """Whether it only shows the long screen."""
    once: str = ""
    """What must be so first, in place of ``why``: never left out."""


Row = TypeVar("Row")
Columns: TypeAlias = Mapping[str, Callable[[Row], Cell | int | None]]
"""The heading of each column, and what a row has in it: a whole number is one, None is empty."""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of cells; the first is aligned to the left, the others to the right.

    A row that is not as wide as the header is a `ValueError`. A screen draws the ``readings`` of
    each row over the cycles beside it.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    readings: tuple[FloatArray | None, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        columns = len(self.header)
        for row in self.rows:
            if len(row) != columns:
                raise ValueError(f"{len(row)} cells for {columns} columns: {row}")

    @classmethod
    def of(cls, rows: Iterable[Row], columns: Columns[Row], note: str = "") -> Table:
        """Return a table by its columns: a row of it for each of ``rows``."""

        def cell(found: Cell | int | None) -> Cell:
            return Number(found) if isinstance(found, int) else found or ""

        cells = tuple(tuple(cell(of(row)) for of in columns.values()) for row in rows)
        return cls(tuple(columns), cells, note)

    @classmethod
    def by_name(cls, rows: Sequence[Mapping[str, Cell]], note: str = "") -> Table:
        """Return a table of rows by column; a column that a row does not name is empty in it."""
        header = tuple(dict.fromkeys(name for row in rows for name in row))
        return cls(header, tuple(tuple(row.get(name, "") for name in header) for row in rows), note)

    @classmethod
    def in_columns(cls, columns: Mapping[str, Sequence[Cell]], note: str = "") -> Table:
        """Return a table by the cells of each column, all of one length."""
        return cls(tuple(columns), tuple(zip(*columns.values(), strict=True)), note)


@dataclass(frozen=True, slots=True)
class Facts:
    """What somebody stated: names and texts; groups of them may stand beside each other."""

    rows: tuple[tuple[str, str], ...]
    heading: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Strip:
    """Readings of one axis over the cycles, to be drawn small."""

    label: str
    readings: FloatArray
    caption: str


@dataclass(frozen=True, slots=True)
class Notice:
    """One finding, in words."""

    severity: Severity
    code: str
    subject: str
    text: str


Look = Literal[
    "points",
    "joined",
    "line",
    "dashed",
    "dotted",
    "hollow",
    "above",
    "below",
    "ring",
    "cross",
    "band",
]
"""How points are drawn; ``above`` and ``below`` are of those beyond the picture."""
Hue = Literal["ink", "blue", "orange", "grey"]


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """Points over a scale, shape (n,) both.

    ``ends`` of shape (2, n) are those of their intervals, or of the band; ``counts`` of shape (n,)
    how often each was attained.
    """

    name: str
    x: FloatArray
    y: FloatArray
    look: Look = "joined"
    hue: Hue | None = None
    """None: told from the others by colour, mark and dashes."""
    ends: FloatArray | None = None
    counts: FloatArray | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Panel:
    """Curves, levels by name, and bands: ``across`` from low to high, ``along`` a time."""

    title: str
    curves: tuple[Curve, ...]
    levels: Mapping[str, float] = field(default_factory=dict)
    across: tuple[float, float] | None = None
    along: tuple[float, float] | None = None
    upright: tuple[float, ...] = ()
    """Where a line stands, such as the day of a service."""


@dataclass(frozen=True, eq=False, slots=True)
class Figure:
    """Panels on one scale, and in words what is to be seen; ``ticks`` name 1, 2, 3 and so on."""

    title: str
    caption: str
    x_label: str
    y_label: str
    panels: tuple[Panel, ...]
    x_limits: tuple[float, float] | None = None
    y_limits: tuple[float | None, float | None] = (None, None)
    ticks: tuple[str, ...] = ()
    square: bool = False
    """Whether both scales are the same."""
    dates: bool = False
    """Whether x are days since 1970-01-01."""
    wide: bool = False
    """Whether it fills a page."""
    logarithmic: bool = False
    """Whether the scale of y is."""


@dataclass(frozen=True, slots=True)
class Signature:
    """Lines to be signed on, and what each is for."""

    lines: tuple[str, ...]


Block = Text | NextStep | Table | Facts | Strip | Notice | Figure | Signature


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
    raw: bool = False
    """Whether it holds readings as they were taken."""

    @classmethod
    def of_answer(
        cls, lines: Sequence[Block], following: NextStep | None, name: str = "", *, answer: int = 2
    ) -> Section:
        """Return the lines, and what to do next behind the ``answer``: third, or below its list."""
        lines, behind = [line for line in lines if _is_shown(line, "brief")], max(answer, 2)
        after = [] if following is None else [following]
        return cls("", (*lines[:behind], *after, *lines[behind:]), name)

    @staticmethod
    def in_detail(sections: Iterable[Section]) -> Iterator[Section]:
        """Yield sections as those of the long screen and of a page."""
        return (replace(section, depth="detail") for section in sections)


Report = tuple[Section, ...]
"""The document of a result; what is shown of it is a filter by depth."""


def in_form(report: Report, form: Literal["brief", "full", "page"]) -> Report:
    """Return the sections of the short screen, of the long one, or of a page.

    A text, a table or a section that holds nothing is left out, and of the long screen the way to
    it.
    """
    shown = (
        replace(one, blocks=tuple(block for block in one.blocks if _is_shown(block, form)))
        for one in report
        if one.depth in _FORMS[form]
    )
    return tuple(section for section in shown if section.blocks)


def _is_shown(block: Block, form: str) -> bool:
    match block:
        case Text(text=text):
            return bool(text)
        case Table(rows=rows) | Facts(rows=rows):
            return bool(rows)
        case NextStep(in_full=True):
            return form != "full"
    return True


_PARAMETER = re.compile(r"`(\w+=[^`]*)`")


def _of_page(block: Block) -> Block | None:
    match block:
        case Text(text=text, tone=tone, parts=parts):
            return Text(_PARAMETER.sub(r"\1", "; ".join([text, *parts])), tone)
        case Notice(text=text):
            return replace(block, text=_PARAMETER.sub(r"\1", text))
        case Table(note=note):
            return replace(block, note=_PARAMETER.sub(r"\1", note))
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
        sections = (
            replace(section, blocks=tuple(filter(None, map(_of_page, section.blocks))))
            for section in in_form(self.sections, "page")
        )
        fill(self, sections=tuple(sections))


def ended(report: Report, title: str) -> Report:
    """Return the sections of a report, and the line that says that no page is missing."""
    return (*report, Section("", (Text(f"End of {title}", "quiet"),)))
