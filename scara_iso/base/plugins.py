"""One file adds one thing: find the modules of a folder, and those that others add.

A folder such as ``indicators/`` or ``effects/`` is a package whose modules each hold one thing.
Third parties add more through an entry-point group; the callers meet both alike.
"""

from __future__ import annotations

import warnings
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import TYPE_CHECKING

from scara_iso.base.process import code_folders

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def find_modules(package: ModuleType, group: str) -> tuple[ModuleType, ...]:
    """Return the modules of ``package``, by name, then those of the entry-point ``group``.

    Modules whose name begins with an underscore are the package's own plumbing and left out. One
    of others that fails, or that ``package.check_shape`` refuses by `AttributeError` or
    `TypeError`, is left out with a warning that names it.
    """
    own = sorted(m.name for m in iter_modules(package.__path__) if not m.name.startswith("_"))
    modules = [import_module(f"{package.__name__}.{name}") for name in own]
    for entry in _entries(group):
        try:
            module = entry.load()
            package.check_shape(module)
            modules.append(module)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001 - a plugin may also try to exit
            warnings.warn(
                f"plugin {entry.name} ({entry.value}) of {group} is left out: "
                f"{type(error).__name__}: {error}",
                stacklevel=2,
            )
    return tuple(modules)


def _entries(group: str) -> list[EntryPoint]:
    folders = code_folders()
    if f"[{group}]".encode() not in _declared(tuple(folders)):
        return []
    from importlib.metadata import distributions  # noqa: PLC0415 - 30 ms that few need to pay

    found: dict[str, EntryPoint] = {}
    for distribution in distributions(path=folders):
        try:
            entries = distribution.entry_points
        except (ValueError, TypeError) as error:  # not UTF-8, or not in the form of such a file
            warnings.warn(f"entry points left out: {error}", stacklevel=3)
            continue
        for entry in entries:
            if entry.group == group:
                found.setdefault(entry.name, entry)
    return [found[name] for name in sorted(found)]


@cache
def _declared(folders: tuple[str, ...]) -> bytes:
    """Return the entry points that all distributions in some folders declare, unparsed."""
    declarations = (
        path
        for folder in folders
        for path in Path(folder or ".").glob("*.dist-info/entry_points.txt")
    )
    return b"\n".join(path.read_bytes() for path in declarations if path.is_file())
