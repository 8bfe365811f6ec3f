"""A report as one HTML file: no script, no network, nothing of a file but text.

The policy allows the one style sheet of this page, by its hash, and nothing else; the pictures
are inline and carry no style of their own.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator
from importlib.resources import files
from itertools import groupby

from scara_iso.render.pictures import picture
from scara_iso.reporting import NOT_STATED, Block, Document, Figure, Interval, Number, printable


def render(document: Document) -> bytes:
    """Return the page of a report; the same report gives the same page."""
    from jinja2 import Environment  # noqa: PLC0415 - for pages only
    from markupsafe import Markup  # noqa: PLC0415 - likewise

    environment = Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, finalize=_printable
    )
    style = _resource("report.css")
    numbers = iter(range(10**6))
    sections = [
        {
            "heading": section.heading,
            "blocks": [
                (kind, [(f, Markup(picture(f, next(numbers)))) for f in block])  # noqa: S704
                if isinstance(block, list)
                else (kind, block)
                for kind, block in _grouped(section.blocks)
            ],
        }
        for section in document.sections
    ]
    page = environment.from_string(_resource("report.html")).render(
        title=document.title,
        policy=_policy(style),
        style=Markup(style),  # noqa: S704 - our own
        sections=sections,
        not_stated=NOT_STATED,
        missing=Markup(' class="missing"'),
    )
    return page.encode()


def _policy(style: str) -> str:
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    return (
        f"default-src 'none'; style-src 'sha256-{digest}'; img-src data:; base-uri 'none'; "
        "form-action 'none'"
    )


def _grouped(blocks: tuple[Block, ...]) -> Iterator[tuple[str, Block | list[Figure]]]:
    """Yield each block with its kind; figures that follow each other come together."""
    for _, group in groupby(blocks, lambda block: isinstance(block, Figure)):
        together = list(group)
        figures = [block for block in together if isinstance(block, Figure)]
        if figures:
            yield "Pictures", figures
        else:
            yield from ((type(block).__name__, block) for block in together)


def _printable(value: object) -> object:
    return printable(str(value)) if type(value) in (str, Number, Interval) else value


def _resource(name: str) -> str:
    return files("scara_iso.render").joinpath("templates", name).read_text(encoding="utf-8")
