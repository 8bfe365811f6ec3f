"""A report as comma-separated values: its sections below each other."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.quantities import parse_number
from scara_iso.report.blocks import Block, Figure, Notice, Report, Strip, Table, Text
from scara_iso.report.words import printable
from scara_iso.tables import PLAIN, Digits, SheetLocale, write_rows


def to_csv(report: Report, title: str, locale: SheetLocale = PLAIN) -> str:
    """Return a report as CSV; no cell of it becomes a formula in a spreadsheet."""
    return locale.bom + write_rows(
        ([_cell(cell) for cell in row] for row in to_rows(report, title)), locale
    )


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
            yield from _with_numbers(block.rows)
            yield from [(block.note,)] if block.note else []
        case Notice():
            yield (block.severity, block.code, block.subject, block.text)
        case Strip():
            yield (block.label, block.caption)
        case Figure():
            yield (block.title, block.caption)


def _with_numbers(rows: tuple[tuple[str, ...], ...]) -> Iterator[tuple[str, ...]]:
    """Mark the numbers in columns that hold nothing else: a serial number 1.10 stays as it is."""
    numeric = [all(map(_is_blank_or_number, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        pairs = zip(row, numeric, strict=True)
        yield tuple(Digits(c) if n and parse_number(c) is not None else c for c, n in pairs)


def _is_blank_or_number(cell: str) -> bool:
    return cell in ("", "-") or parse_number(cell) is not None


def _cell(text: str) -> str:
    return text if isinstance(text, Digits) else printable(text)
