"""Parts of a page that a script computes: print them, or write them with --write."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"
RESULTS = Path(__file__).parent / "results"


def run(
    parts: Mapping[str, Callable[[], Iterator[str]]], page: Path, description: str | None
) -> None:
    """Print every part; with ``--write`` also put each between its marks in ``page``."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--write", action="store_true", help=f"write the parts into {page.name}")
    write = parser.parse_args().write
    text = page.read_text(encoding="utf-8") if write else ""
    for name, part in parts.items():
        body = "\n".join(part())
        print(f"{name}\n{body}\n")
        text = put(text, name, body) if write else text
    if write:
        page.write_text(text, encoding="utf-8")


def put(text: str, name: str, body: str) -> str:
    """Return the text of a page with ``body`` between the marks of ``name``."""
    begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->"
    if begin not in text:
        raise SystemExit(f"the page has no part {name!r}")
    return re.sub(
        f"({re.escape(begin)}).*?({re.escape(end)})",
        lambda m: f"{m[1]}{body}\n{m[2]}",
        text,
        flags=re.DOTALL,
    )
