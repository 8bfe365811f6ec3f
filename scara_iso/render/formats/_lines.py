"""A report as lines of cells, for formats in which somebody computes: one number, one cell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple, TypeAlias

from scara_iso.reporting import (
    Block,
    Cell,
    Facts,
    Figure,
    Interval,
    Notice,
    Number,
    Result,
    Section,
    Signature,
    Strip,
    Table,
    Text,
)

_ENDS = "95 % interval"
"""Behind the heading of figures, whose intervals have columns of their own here."""

Labels: TypeAlias = Mapping[str, str]
"""By the English ones; empty for English."""


class Line(NamedTuple):
    """Cells beside each other, text or a finite number; ``heading`` if they name what follows."""

    cells: tuple[str | Number, ...]
    heading: bool = False


def section_lines(section: Section, labels: Labels) -> Iterator[Line]:
    """Yield the lines of a section, an empty one first; ``labels`` are those of its language."""
    yield Line(())
    if section.heading:
        yield Line((section.heading,), heading=True)
    for block in section.blocks:
        yield from _lines(block, labels)


def _lines(block: Block, labels: Labels) -> Iterator[Line]:
    match block:
        case Text():
            yield Line((block.text,))
        case Table():
            yield from _table(block, labels)
        case Facts():
            yield from [Line((block.heading,), heading=True)] if block.heading else []
            yield from map(Line, block.rows)
        case Signature():
            yield Line(block.lines)
        case Notice():
            yield Line((block.severity, block.code, block.subject, block.text))
        case Strip():
            yield Line((block.label, block.caption))
        case Figure():
            yield Line((block.title, block.caption))


def _table(table: Table, labels: Labels) -> Iterator[Line]:
    """Yield header, rows and note: an interval has two columns, units have one of their own."""
    columns = [
        column
        for k, heading in enumerate(table.header)
        for column in _columns(heading, [row[k] for row in table.rows], labels)
    ]
    header, *rows = zip(*columns, strict=True)
    yield Line(header, heading=True)
    yield from map(Line, rows)
    if table.note:
        yield Line((table.note,))


def _columns(heading: str, cells: list[Cell], labels: Labels) -> Iterator[tuple[str | Number, ...]]:
    if any(isinstance(cell, Result) for cell in cells):
        name = heading.removesuffix(f" [{_word(_ENDS, labels)}]")
        of = "" if name != heading else f"{heading} "
        results = [cell if isinstance(cell, Result) else None for cell in cells]
        yield from _columns(name, [c.value if isinstance(c, Result) else c for c in cells], labels)
        intervals: list[Cell] = [(one and one.interval) or "" for one in results]
        if any(intervals):
            yield from _columns(f"{of}{_word(_ENDS, labels)}", intervals, labels)
        if any(one and one.verdict for one in results):
            yield (
                f"{name} {_word('verdict', labels)}",
                *(one.verdict if one else "" for one in results),
            )
        return
    if any(isinstance(cell, Interval) for cell in cells):
        ends = [(c.low, c.high) if isinstance(c, Interval) else (c, "") for c in cells]
        yield (f"{heading}, {_word('low', labels)}", *(_plain(low) for low, _ in ends))
        yield (f"{heading}, {_word('high', labels)}", *(_plain(high) for _, high in ends))
        return
    yield (heading, *map(_plain, cells))
    units = [cell.unit if isinstance(cell, Number) else "" for cell in cells]
    if any(f"[{unit}]" not in heading for unit in filter(None, units)):
        yield (_word("unit", labels), *units)


def _word(english: str, labels: Labels) -> str:
    return labels.get(english, english)


def _plain(cell: Cell) -> str | Number:
    return cell if isinstance(cell, Number) and math.isfinite(cell.value) else str(cell)
