"""The few blocks that a report is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scara_iso.results import Severity
from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph."""

    text: str
    tone: Literal["plain", "quiet", "strong", "good", "warn", "bad"] = "plain"


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of text; the first is aligned to the left, the others to the right."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


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


Block = Text | Table | Strip | Notice


@dataclass(frozen=True, slots=True)
class Section:
    """Blocks under a heading; an empty heading is none."""

    heading: str
    blocks: tuple[Block, ...]


Report = tuple[Section, ...]
