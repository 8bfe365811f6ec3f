"""Count the words of the site, page by page: ``python docs/words.py``; a test holds the budget."""

from __future__ import annotations

import re
import sys
from pathlib import Path

DOCS = Path(__file__).parent
BUDGET = 40_000
GENERATED = 9_000


def words(text: str) -> int:
    """Return how many words a page has: what stands between spaces and holds a letter or digit."""
    return sum(1 for one in text.split() if re.search(r"\w", one))


def counted(folder: Path = DOCS) -> dict[str, int]:
    """Return the words of every page of a folder by its path, generated ones included."""
    pages = sorted(folder.rglob("*.md"))
    return {
        page.relative_to(folder).as_posix(): words(page.read_text(encoding="utf-8"))
        for page in pages
    }


if __name__ == "__main__":
    found = counted()
    for page, count in found.items():
        sys.stdout.write(f"{count:6} {page}\n")
    sys.stdout.write(f"{sum(found.values()):6} of {BUDGET}\n")
