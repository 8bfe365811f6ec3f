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
from typing import TYPE_CHECKING

from scara_iso.render.pictures import picture, picture_size
from scara_iso.reporting import (
    Block,
    Document,
    Facts,
    Figure,
    Interval,
    Number,
    Result,
    labels_of,
    printable,
    sparkline,
)

if TYPE_CHECKING:
    from markupsafe import Markup

_HALF = 5.0  # inch
_SIDE_BY_SIDE = (Figure, Facts)
"""Blocks of which several may stand beside each other."""


def render(document: Document) -> bytes:
    """Return the page of a report; the same report gives the same page."""
    from jinja2 import Environment  # noqa: PLC0415 - for pages only
    from markupsafe import Markup  # noqa: PLC0415 - likewise

    environment = Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, finalize=_shown
    )
    number = labels_of(document.language).get("page", "page")
    style = _resource("report.css").replace("PAGE", css_string(number))
    style = style.replace("TITLE", css_string(document.title))
    numbers = iter(range(10**6))
    environment.filters["picture"] = lambda figure: Markup(picture(figure, next(numbers)))  # noqa: S704
    environment.filters["drawn"] = sparkline
    environment.filters["fills_the_page"] = lambda figure: picture_size(figure)[0] > _HALF
    page = environment.from_string(_resource("report.html")).render(
        language=document.language,
        title=document.title,
        simulated=document.simulated,
        policy=_policy(style),
        style=Markup(style),  # noqa: S704 - our own
        sections=[
            {"of": section, "groups": list(_grouped(section.blocks))}
            for section in document.sections
        ],
    )
    return page.encode()


def css_string(text: str) -> str:
    """Return a string of CSS in which no letter of ``text`` is anything but a letter."""
    return "".join(c if c.isascii() and c.isalnum() else f"\\{ord(c):x} " for c in printable(text))


def _policy(style: str) -> str:
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    return (
        f"default-src 'none'; style-src 'sha256-{digest}'; img-src data:; base-uri 'none'; "
        "form-action 'none'"
    )


def _grouped(blocks: tuple[Block, ...]) -> Iterator[tuple[str, list[Block]]]:
    """Yield blocks by kind; those that may stand beside each other come together."""
    for kind, group in groupby(blocks, type):
        together = list(group)
        if kind in _SIDE_BY_SIDE:
            yield kind.__name__, together
        else:
            yield from ((kind.__name__, [block]) for block in together)


def _shown(value: object) -> object:
    if isinstance(value, Result):
        return _result(value)
    return printable(str(value)) if type(value) in (str, Number, Interval) else value


def _result(cell: Result) -> Markup:
    from markupsafe import Markup  # noqa: PLC0415 - for pages only

    parts = [Markup("<b>{}</b>").format(printable(str(cell.value)))]
    if cell.interval:
        parts.append(Markup("<small>{}</small>").format(printable(cell.interval.in_brackets)))
    if cell.verdict:
        parts.append(Markup('<span class="{}">{}</span>').format(cell.tone, cell.verdict))
    return Markup(" ").join(parts)


def _resource(name: str) -> str:
    return files("scara_iso.render").joinpath("templates", name).read_text(encoding="utf-8")
