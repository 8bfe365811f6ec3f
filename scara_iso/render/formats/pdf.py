"""A report as a PDF, for those who file paper: the page of `html`, printed on A4."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from scara_iso.errors import UsageError
from scara_iso.render.formats import html
from scara_iso.render.pictures import font_file
from scara_iso.reporting import Document

_REMEDY = (
    "pip install 'scara-iso[pdf]', and the system's Pango library; or print the .html from a "
    "browser"
)
_FACES = (("DejaVuSans.ttf", 400), ("DejaVuSans-Bold.ttf", 700))
"""Fonts that come with matplotlib: the same page wherever it is made."""


def render(document: Document) -> bytes:
    """Return a report as the bytes of a PDF; `UsageError` without the library for it."""
    weasyprint = _library()
    fonts = weasyprint.text.fonts.FontConfiguration()
    faces = [font_file(name).as_uri() for name, _ in _FACES]
    style = "".join(
        f"@font-face {{ font-family: Paper; font-weight: {weight}; src: url({face}) }}"
        for face, (_, weight) in zip(faces, _FACES, strict=True)
    )
    style += "@page { size: A4 } body, svg text { font-family: Paper; } "
    page = weasyprint.HTML(string=html.render(document).decode(), url_fetcher=_refused)
    sheet = weasyprint.CSS(string=style, font_config=fonts)
    return bytes(page.write_pdf(stylesheets=[sheet], font_config=fonts))


def _library() -> Any:  # it has no types
    try:
        import_module("weasyprint.text.fonts")
        return import_module("weasyprint")
    except (ImportError, OSError) as error:  # OSError: without Pango
        raise UsageError("a PDF needs WeasyPrint", remedy=_REMEDY) from error


def _refused(url: str) -> dict[str, Any]:
    raise ValueError(f"{url}: a report fetches nothing")
