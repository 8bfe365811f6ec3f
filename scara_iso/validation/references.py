"""The files of references that come with the package.

Recorded streams and NIST's sets are those of tests/fixtures: a wheel carries them in ``data``
(pyproject.toml), and the sources are read where they stand.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from importlib.resources.abc import Traversable

_FIXTURES = "tests", "fixtures"


def references(*names: str) -> Traversable:
    """Return a file or folder of ``data``."""
    inside = files("scara_iso.validation").joinpath("data", *names)
    if inside.is_dir() or inside.is_file():
        return inside
    return files("scara_iso").joinpath("..", *_FIXTURES, *names)


def with_ending(folder: str, ending: str) -> Iterator[Traversable]:
    """Yield the files of a folder of ``data`` that have this ending, by name."""
    found = references(folder).iterdir()
    yield from (one for one in sorted(found, key=lambda f: f.name) if one.name.endswith(ending))
