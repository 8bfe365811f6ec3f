"""A report as CSV: its sections below each other."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.quantities import parse_number
from scara_iso.reporting import Block, Figure, Notice, Report, Strip, Table, Text, printable
from scara_iso.tables import PLAIN, Digits, OutputCell, SheetLocale, write_rows


def to_csv(report: Report, title: str, locale: SheetLocale = PLAIN) -> str:
    """Return a report as CSV; numbers are numbers, and no cell becomes a formula."""
    return locale.bom + write_rows(_rows_of(report, title), locale)


def _rows_of(report: Report, title: str) -> Iterator[tuple[OutputCell, ...]]:
    yield (printable(title),)
    for section in report:
        yield ()
        if section.heading:
            yield (printable(section.heading),)
        for block in section.blocks:
            yield from _rows(block)


def _rows(block: Block) -> Iterator[tuple[OutputCell, ...]]:
    match block:
        case Text():
            yield (printable(block.text),)
        case Table():
            yield tuple(map(printable, block.header))
            spell = printable if block.verbatim else _cell
            yield from (tuple(map(spell, row)) for row in block.rows)
            yield from [(printable(block.note),)] if block.note else []
        case Notice():
            said = (block.severity, block.code, block.subject, block.text)
            yield tuple(map(printable, said))
        case Strip():
            yield (printable(block.label), printable(block.caption))
        case Figure():
            yield (printable(block.title), printable(block.caption))


def _cell(text: str) -> OutputCell:
    return printable(text) if parse_number(text) is None else Digits(text)
