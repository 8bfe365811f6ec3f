"""What is shown of the library: the names of a package, and a result in a notebook.

A package shows one face, and what is behind a name is imported when the name is first used. The
imports that a type checker reads in the package's `__init__` are the one list of its names. So a
command pays only for what it uses. Other packages import from the face and from nothing behind it;
tests/test_architecture.py holds them to it.

Results stand far below the renderer and cannot name it: the face of the whole puts it here.
"""

from importlib import import_module

TYPE_CHECKING = False  # nothing is imported before the program begins: scara_iso.base.process
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from matplotlib.figure import Figure


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


def _none() -> "Any":
    raise NotImplementedError("no renderer")


notebook: "Callable[[], Any]" = _none
"""Gives ``page(result)`` and ``figure(result)``; called when somebody looks."""


class Displayed:
    """A result that a notebook shows as a page."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        page: str = notebook().page(self)
        return page


class Plotted(Displayed):
    """A result that also has a picture."""

    __slots__ = ()

    def plot(self) -> "Figure":
        """Return its picture, a matplotlib figure; a notebook shows it."""
        figure: Figure = notebook().figure(self)
        return figure
