"""A report as a PDF, for those who file paper: the page of `html`, printed on A4."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from scara_iso.base.errors import UsageError, with_extra
from scara_iso.render.formats import html
from scara_iso.render.pictures import font_file
from scara_iso.reporting import Document

_REMEDY = (
    f"{with_extra('pdf')}, and the system's Pango library (Debian: apt-get install "
    "libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0; Windows: MSYS2); or "
    "print the .html from a browser"
)
_FACES = (("DejaVuSans.ttf", 400), ("DejaVuSans-Bold.ttf", 700))
"""Fonts that come with matplotlib: the same page wherever it is made."""

_OWN = (
    "@page { size: A4 } body, svg text { font-family: Paper !important } "
    # `overflow-wrap: anywhere` costs WeasyPrint the square of a word's length
    "body { overflow-wrap: break-word !important } "
    # and a figure across all columns of a grid gets none of them
    ".pictures { display: block !important } figure { display: inline-block; width: 48% } "
    "figure.all { display: block; width: auto }"
)
"""What WeasyPrint needs beside the page's own style."""


@contextmanager
def _without_harfbuzz_subset() -> Iterator[None]:
    """Let fontTools make the part of a font that is used, where HarfBuzz-Subset is not there.

    WeasyPrint warns of that, which a reader of the report need not know. fontTools writes the time
    into the font, for which SOURCE_DATE_EPOCH stands: the same report gives the same bytes.
    """
    before = os.environ.get("SOURCE_DATE_EPOCH")
    os.environ["SOURCE_DATE_EPOCH"] = before or "0"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            yield
    finally:
        if before is None:
            del os.environ["SOURCE_DATE_EPOCH"]


@_without_harfbuzz_subset()
def render(document: Document) -> bytes:
    """Return a report as the bytes of a PDF; `UsageError` without the library for it."""
    try:
        from weasyprint import CSS, HTML  # noqa: PLC0415 - an extra
        from weasyprint.text.fonts import FontConfiguration  # noqa: PLC0415 - likewise
    except (ImportError, OSError) as error:  # OSError: without Pango
        raise UsageError("a PDF needs WeasyPrint", remedy=_REMEDY) from error
    fonts = FontConfiguration()
    faces = "".join(
        f"@font-face {{ font-family: Paper; font-weight: {weight}; "
        f"src: url({font_file(name).as_uri()}) }}"
        for name, weight in _FACES
    )
    style = f"{faces} {_OWN}"
    page = HTML(string=html.render(document).decode(), url_fetcher=_refused)
    sheet = CSS(string=style, font_config=fonts)
    return bytes(page.write_pdf(stylesheets=[sheet], font_config=fonts)) + b"% scara-iso\n"


def _refused(url: str) -> dict[str, Any]:
    raise ValueError(f"{url}: a report fetches nothing")
