"""Names of the code as a reader says them, and text of files as it may be shown."""

import unicodedata

from scara_iso.diagnosis import UNKNOWN

_HIDDEN = {"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"}


def words(name: str) -> str:
    """Return an effect's or a verdict's name in words: ``warm_up`` is ``warm up``."""
    if name == UNKNOWN:
        return "no known effect"
    return name.replace("_", " ").replace("-", " ")


def printable(text: str) -> str:
    """Return ``text`` with control and formatting characters made visible."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        c.encode("unicode_escape").decode() if unicodedata.category(c) in _HIDDEN else c
        for c in text
    )
