"""What a test measures: one small file per characteristic, a clause each.

Each module's docstring is the page that explains it, ``CODE`` is its name in outputs and limits,
``CLAUSE`` where it is defined, ``NEEDS`` what a test must hold for it, and ``compute(test)`` yields
it for all poses that have it. Third parties add a module through the entry-point group
``scara_iso.characteristics``.
"""

import sys
from collections.abc import Mapping
from functools import cache
from types import ModuleType

from scara_iso.base.plugins import find_modules


@cache
def find_characteristics() -> tuple[ModuleType, ...]:
    """Return every characteristic there is: those of this folder by name, then those of others."""
    return find_modules(sys.modules[__name__], "scara_iso.characteristics")


def needs() -> Mapping[str, str]:
    """Return what a test must hold for each characteristic, by its code."""
    return {module.CODE: module.NEEDS for module in find_characteristics()}


def check_shape(module: ModuleType) -> None:
    """Raise `AttributeError` or `TypeError` unless a module is a characteristic's."""
    if not (callable(module.compute) and isinstance(module.CODE, str)):
        raise TypeError("compute is not a function, or CODE is not text")
    if not (isinstance(module.CLAUSE, str) and isinstance(module.NEEDS, str)):
        raise TypeError("CLAUSE or NEEDS is not text")
