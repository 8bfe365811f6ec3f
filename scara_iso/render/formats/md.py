"""A report as Markdown: readable as it stands, pictures as lines of blocks."""

from __future__ import annotations

import re
from collections.abc import Iterator

from scara_iso.reporting import (
    Block,
    Document,
    Facts,
    Figure,
    Notice,
    Signature,
    Strip,
    Table,
    Text,
    printable,
    sparkline,
)
from scara_iso.run import FloatArray

_DRAWN = {("joined", "cycle"), ("points", "")}
"""Courses over cycles and figures by date: how they look, and over what."""
_LINE = r"\_" * 24
_SPECIAL = re.compile(r"([\\`*_\[\]|~#!])")
_FIRST = re.compile(r"^(\s*\d*)([-+=.)])(?=\s|$|[-=])")
"""A bullet, a number of a list, or a rule."""
_CODED = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "@": "&#64;", "$": "&#36;"})
_HOST = re.compile(r"(?i)\b(www)\.|:(?=//)")


def render(document: Document) -> bytes:
    """Return a report as Markdown; no text of a file is markup in it."""
    parts = [f"# {_text(document.title)}"]
    for section in document.sections:
        parts += [f"## {_text(section.heading)}"] if section.heading else []
        parts += [text for block in section.blocks for text in _block(block)]
    return "\n\n".join([*parts, "by scara-iso\n"]).encode()


def _block(block: Block) -> Iterator[str]:
    match block:
        case Text():
            yield (_strong if block.tone == "strong" else _text)(block.text)
        case Table():
            yield from filter(None, (_table(block), _text(block.note)))
        case Notice():
            subject = f"{_strong(block.subject)}: " if block.subject else ""
            yield f"{block.severity}: {subject}{_text(block.text)} ({_text(block.code)})"
        case Strip():
            yield f"{_text(block.label)} {_drawn(block.readings)} {_text(block.caption)}"
        case Facts():
            heads = (block.heading or "stated", "")
            yield _table(Table(heads, block.rows), left=True)
        case Figure():
            yield from _figure(block)
        case Signature():
            yield "\n\n".join(f"{_text(line)}: {_LINE}" for line in block.lines)


def _figure(figure: Figure) -> Iterator[str]:
    """Yield a figure as lines of blocks, else where it is drawn: captions are of the drawing."""
    lines = [
        f"{_text(panel.title)} {_drawn(first.y)}".strip()
        for panel in figure.panels
        if ((first := panel.curves[0]).look, figure.x_label) in _DRAWN
    ]
    yield _strong(figure.title) + ("" if lines else " (drawn in a report as .html)")
    yield from lines


def _drawn(readings: FloatArray) -> str:
    return f"`{sparkline(readings)}`"


def _table(table: Table, *, left: bool = False) -> str:
    rule = ["---", *["---" if left else "--:"] * (len(table.header) - 1)]
    rows = [[_text(str(cell)) for cell in row] for row in (table.header, *table.rows)]
    rows.insert(1, rule)
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _strong(text: str) -> str:
    return f"**{_text(printable(text).strip())}**"


def _text(text: str) -> str:
    """Return text in which nothing is markup, HTML or a link."""
    safe = _FIRST.sub(r"\1\\\2", _SPECIAL.sub(r"\\\1", printable(text)))
    safe = safe.translate(_CODED)
    return _HOST.sub(lambda found: f"{found[1]}&#46;" if found[1] else "&#58;", safe)
