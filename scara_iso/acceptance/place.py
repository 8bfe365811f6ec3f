"""Where the test of a folder is written down; nothing else is imported, for every command asks."""

from __future__ import annotations

import os
from pathlib import Path

FILE = "test.toml"


def is_test_folder(path: object) -> bool:
    """Say whether a path names the folder of a test."""
    # os.path, since it takes a name of any length
    return isinstance(path, str | Path) and os.path.isfile(os.path.join(path, FILE))  # noqa: PTH113, PTH118
