"""A whole test, or a study, as one JSON object: what their commands publish."""

from __future__ import annotations

from scara_iso.base.errors import UsageError
from scara_iso.base.published import to_json, to_text
from scara_iso.gauge import GaugeStudy
from scara_iso.reporting import Document, Dossier


def render(document: Document) -> bytes:
    """Return the object as one line; `UsageError` for what is neither a whole test nor a study."""
    match document.source:
        case Dossier() | GaugeStudy():
            found = to_json(document.source)
        case _:
            raise UsageError(
                f"{document.title}: only a whole test or a study is written as JSON",
                remedy="let the name end in .html, .md or .csv",
            )
    return f"{to_text(found)}\n".encode()
