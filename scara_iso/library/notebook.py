"""How results show themselves in a notebook: as the page that the renderer makes.

The results stand below the renderer and cannot name it, so the room above both joins them.
"""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from scara_iso.reporting import Report

Result = TypeVar("Result")


def shows_itself(kind: type[Result], report: Callable[[Result], Report], title: str) -> None:
    """Give a type of results ``_repr_html_``: the page of its report, in a frame of its own."""

    def _repr_html_(self: Result) -> str:
        from scara_iso.render import find_format
        from scara_iso.reporting import Document

        page = find_format("page", ".html")(Document(title, report(self), None))  # type: ignore[arg-type]  # a page holds no data
        return framed(page.decode())

    setattr(kind, "_repr_html_", _repr_html_)  # noqa: B010 - it has none that a checker could know


def framed(page: str) -> str:
    """Return a page in a frame: its style and its policy stay its own."""
    style = "width:100%;height:45em;border:0"
    return f'<iframe sandbox srcdoc="{escape(page)}" style="{style}"></iframe>'
