"""A package shows one face, and what is behind a name is imported when the name is first used.

The imports that a type checker reads in the package's `__init__` are the one list of its names. So
a command pays only for what it uses. Other packages import from the face and from nothing behind
it; tests/test_architecture.py holds them to it.
"""

from importlib import import_module

TYPE_CHECKING = False  # nothing is imported before the program begins: scara_iso.base.trust
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


def face(package: str) -> "Callable[[str], Any]":
    """Return the ``__getattr__`` of a package that imports its names under ``TYPE_CHECKING``."""
    homes: dict[str, str] = {}

    def find(name: str) -> "Any":
        if not homes:
            homes.update(_homes(package))
        if name == "__all__":
            return sorted(homes)
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(homes[name]), name)

    return find


def _homes(package: str) -> dict[str, str]:
    """Return the module of each name of a face."""
    import re  # noqa: PLC0415 - a name of a face is wanted; before that the start is short
    from pkgutil import get_data  # noqa: PLC0415

    shown = (get_data(package, "__init__.py") or b"").decode().partition("if TYPE_CHECKING:")[2]
    found, home = {}, ""
    for module, name in re.findall(r"from (\S+) import|(\w+) as \2\b", shown):
        home = module or home
        found[name] = home
    del found[""]  # of the lines that name a module
    return found
