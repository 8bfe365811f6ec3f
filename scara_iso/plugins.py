"""One file adds one thing: find the modules of a folder, and those that others add.

A folder such as ``indicators/`` or ``effects/`` is a package whose modules each hold one thing.
Third parties add more through an entry-point group; the callers meet both alike.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType


def find_modules(package: ModuleType, group: str) -> tuple[ModuleType, ...]:
    """Return the modules of ``package``, by name, then those of the entry-point ``group``.

    Modules whose name begins with an underscore are the package's own plumbing and left out.
    """
    own = sorted(m.name for m in iter_modules(package.__path__) if not m.name.startswith("_"))
    modules = [import_module(f"{package.__name__}.{name}") for name in own]
    return (*modules, *_modules_of_others(group))


def _modules_of_others(group: str) -> tuple[ModuleType, ...]:
    if not _is_declared(group):
        return ()
    from importlib.metadata import entry_points  # noqa: PLC0415 - 30 ms that few need to pay

    return tuple(entry.load() for entry in sorted(entry_points(group=group), key=lambda e: e.name))


def _is_declared(group: str) -> bool:
    """Return whether any installed distribution declares the group, without parsing them all."""
    header = f"[{group}]"
    declarations = (
        path
        for folder in sys.path
        for path in Path(folder or ".").glob("*.dist-info/entry_points.txt")
    )
    return any(header in path.read_text(encoding="utf-8") for path in declarations)
