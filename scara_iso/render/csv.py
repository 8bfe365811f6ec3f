"""A report as comma-separated values: its sections below each other."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from scara_iso.quantities import parse_number
from scara_iso.report.blocks import Block, Figure, Notice, Report, Strip, Table, Text
from scara_iso.report.words import printable

_FORMULA = ("=", "+", "-", "@", "'", "|", "%")


def to_csv(report: Report, title: str) -> str:
    """Return a report as CSV; no cell of it becomes a formula in a spreadsheet."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    for row in to_rows(report, title):
        writer.writerow(_cell(cell) for cell in row)
    return file.getvalue()


def to_rows(report: Report, title: str) -> Iterator[tuple[str, ...]]:
    """Yield the rows of a report, an empty one before each heading."""
    yield (title,)
    for section in report:
        yield ()
        if section.heading:
            yield (section.heading,)
        for block in section.blocks:
            yield from _rows(block)


def _rows(block: Block) -> Iterator[tuple[str, ...]]:
    match block:
        case Text():
            yield (block.text,)
        case Table():
            yield block.header
            yield from block.rows
            yield from [(block.note,)] if block.note else []
        case Notice():
            yield (block.severity, block.code, block.subject, block.text)
        case Strip():
            yield (block.label, block.caption)
        case Figure():
            yield (block.title, block.caption)


def _cell(text: str) -> str:
    safe = printable(text)
    return f"'{safe}" if safe.lstrip().startswith(_FORMULA) and parse_number(safe) is None else safe
