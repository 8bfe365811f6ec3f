"""A report as lines of cells, for formats in which somebody computes: one number, one cell."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

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

_ENDS = " [95 % interval]"
"""Behind the heading of figures, whose intervals have columns of their own here."""


class Line(NamedTuple):
    """Cells beside each other, text or a finite number; ``heading`` if they name what follows."""

    cells: tuple[str | Number, ...]
    heading: bool = False


def section_lines(section: Section) -> Iterator[Line]:
    """Yield the lines of a section, an empty one first."""
    yield Line(())
    if section.heading:
        yield Line((section.heading,), heading=True)
    for block in section.blocks:
        yield from _lines(block)


def _lines(block: Block) -> Iterator[Line]:
    match block:
        case Text():
            yield Line((block.text,))
        case Table():
            yield from _table(block)
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


def _table(table: Table) -> Iterator[Line]:
    """Yield header, rows and note: an interval has two columns, units have one of their own."""
    columns = [
        column
        for k, heading in enumerate(table.header)
        for column in _columns(heading, [row[k] for row in table.rows])
    ]
    header, *rows = zip(*columns, strict=True)
    yield Line(header, heading=True)
    yield from map(Line, rows)
    if table.note:
        yield Line((table.note,))


def _columns(heading: str, cells: list[Cell]) -> Iterator[tuple[str | Number, ...]]:
    if any(isinstance(cell, Result) for cell in cells):
        name = heading.removesuffix(_ENDS)
        of = "" if name != heading else f"{heading} "
        results = [cell if isinstance(cell, Result) else None for cell in cells]
        yield from _columns(name, [c.value if isinstance(c, Result) else c for c in cells])
        intervals: list[Cell] = [(one and one.interval) or "" for one in results]
        if any(intervals):
            yield from _columns(f"{of}95 % interval", intervals)
        if any(one and one.verdict for one in results):
            yield (f"{name} verdict", *(one.verdict if one else "" for one in results))
        return
    if any(isinstance(cell, Interval) for cell in cells):
        ends = [(c.low, c.high) if isinstance(c, Interval) else (c, "") for c in cells]
        yield (f"{heading}, low", *(_plain(low) for low, _ in ends))
        yield (f"{heading}, high", *(_plain(high) for _, high in ends))
        return
    yield (heading, *map(_plain, cells))
    units = [cell.unit if isinstance(cell, Number) else "" for cell in cells]
    if any(units):
        yield ("unit", *units)


def _plain(cell: Cell) -> str | Number:
    return cell if isinstance(cell, Number) and math.isfinite(cell.value) else str(cell)
