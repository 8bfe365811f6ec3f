"""One file adds one thing: find the modules of a folder, and those that others add.

A folder such as ``indicators/`` or ``effects/`` is a package whose modules each hold one thing.
Third parties add more through an entry-point group; the callers meet both alike.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType


def find_modules(package: ModuleType, group: str) -> tuple[ModuleType, ...]:
    """Return the modules of ``package``, by name, then those of the entry-point ``group``.

    Modules whose name begins with an underscore are the package's own plumbing and left out.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 - 20 ms that --help need not pay

    own = sorted(m.name for m in iter_modules(package.__path__) if not m.name.startswith("_"))
    modules = [import_module(f"{package.__name__}.{name}") for name in own]
    others = sorted(entry_points(group=group), key=lambda entry: entry.name)
    return (*modules, *(entry.load() for entry in others))
