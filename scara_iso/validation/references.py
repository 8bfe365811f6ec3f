"""The files of references that come with the package."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from importlib.resources.abc import Traversable


def references(*names: str) -> Traversable:
    """Return a file or folder of ``data``."""
    return files("scara_iso.validation").joinpath("data", *names)


def with_ending(folder: str, ending: str) -> Iterator[Traversable]:
    """Yield the files of a folder of ``data`` that have this ending, by name."""
    found = references(folder).iterdir()
    yield from (one for one in sorted(found, key=lambda f: f.name) if one.name.endswith(ending))
