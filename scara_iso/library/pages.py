"""A document as a file, in any of the report's formats."""

from __future__ import annotations

from pathlib import Path

from scara_iso.base.disk import write_file
from scara_iso.base.errors import UsageError
from scara_iso.render import endings, find_format
from scara_iso.reporting import Document

_OF_A_TEST = ".json"


def check_page(path: Path) -> None:
    """Raise `UsageError` where no page can have that name, before anything is computed."""
    if path.suffix.lower() == _OF_A_TEST:
        others = ", ".join(ending for ending in endings() if ending != _OF_A_TEST)
        raise UsageError(f"{path.name}: a page is written as {others}", remedy="or say `json=True`")
    find_format(path.name, path.suffix)


def write_page(document: Document, path: Path) -> None:
    """Write a document by the name's ending; raises as `check_page` and `write_file`."""
    check_page(path)
    write_file(path, find_format(path.name, path.suffix)(document))
