"""What a user should know about a test's figures: one small file per check.

Each module's docstring is the page that explains its finding, ``CODE`` names the finding, and
``check(measured)`` yields it. Third parties add a module through the entry-point group
``scara_iso.checks``.
"""

import sys
from functools import cache
from types import ModuleType

from scara_iso.base.plugins import find_modules


@cache
def find_checks() -> tuple[ModuleType, ...]:
    """Return every check there is: those of this folder by name, then those of others."""
    return find_modules(sys.modules[__name__], "scara_iso.checks")


def in_brief(code: str) -> str:
    """Return a finding in a few words: its file's ``BRIEF``, else its name in words."""
    briefs = {one.CODE: getattr(one, "BRIEF", "") for one in reversed(find_checks())}
    return briefs.get(code) or code.replace("-", " ")


def check_shape(module: ModuleType) -> None:
    """Raise `AttributeError` or `TypeError` unless a module has ``check`` and ``CODE``."""
    if not (callable(module.check) and isinstance(module.CODE, str)):
        raise TypeError("check is not a function, or CODE is not text")
