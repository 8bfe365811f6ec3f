"""By what the folder of a test is known; every command asks, so nothing else is imported here."""

from pathlib import Path

from scara_iso.base.files import is_file

FILE = "test.toml"


def is_test_folder(path: object) -> bool:
    """Say whether a path names the folder of a test."""
    return isinstance(path, str | Path) and is_file(Path(path) / FILE)
