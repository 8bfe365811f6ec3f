"""Where the test of a folder is written down; nothing else is imported, for every command asks."""

from __future__ import annotations

from pathlib import Path

FILE = "test.toml"


def is_test_folder(path: object) -> bool:
    """Say whether a path names the folder of a test."""
    return isinstance(path, str | Path) and (Path(path) / FILE).is_file()
