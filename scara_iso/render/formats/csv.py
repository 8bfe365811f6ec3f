"""A report as CSV: its sections below each other, numbers with all their digits."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.render.formats._lines import Line, section_lines
from scara_iso.reporting import Document, Number, labels_of, printable
from scara_iso.tables import PLAIN, OutputCell, SheetLocale, write_rows


def render(document: Document, locale: SheetLocale = PLAIN) -> bytes:
    """Return a report as CSV; numbers are numbers, and no cell becomes a formula."""
    return (locale.bom + write_rows(_rows(document), locale)).encode()


def _rows(document: Document) -> Iterator[list[OutputCell]]:
    labels = labels_of(document.language)
    lines = (line for section in document.sections for line in section_lines(section, labels))
    for line in (Line((document.title,)), Line(("by scara-iso",)), *lines):
        yield [c.value if isinstance(c, Number) else printable(c) for c in line.cells]
