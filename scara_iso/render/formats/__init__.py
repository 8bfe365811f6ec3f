"""Formats of a report: a file of this folder adds one, and its name is the ending of a file's.

Each gives ``render(document: Document) -> bytes``: the same document, the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pkgutil import iter_modules

from scara_iso.base.errors import UsageError


def endings() -> tuple[str, ...]:
    """Return the endings that a report may have, such as ``.html``."""
    return tuple(f".{m.name}" for m in iter_modules(__path__) if not m.name.startswith("_"))


def find_format(name: str, ending: str) -> Callable[..., bytes]:
    """Return ``render`` of an ending; `UsageError` names the others for the file ``name``."""
    if ending.lower() not in endings():
        raise UsageError(
            f"{name}: a report is written as {', '.join(endings())}",
            remedy="let the name end in one of them",
        )
    render: Callable[..., bytes] = import_module(f"{__name__}.{ending[1:].lower()}").render
    return render
