"""The manifest beside a table: what its files were when the recording ended."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from scara_iso.recorder.disk import Disk, write_atomically

SCHEMA = "scara-iso/manifest/1"


def raw_path(table: Path) -> Path:
    """Return the raw file beside a table: ``run.raw.jsonl`` of ``run.csv``."""
    return _beside(table, ".raw.jsonl")


def manifest_path(table: Path) -> Path:
    """Return the manifest beside a table: ``run.manifest.json`` of ``run.csv``."""
    return _beside(table, ".manifest.json")


def write_manifest(table: Path, *, complete: bool, disk: Disk) -> None:
    """Write the SHA-256 of a table and of its raw file; `OSError` where that fails."""
    files = {file.name: sha256(file) for file in (table, raw_path(table))}
    document = {"schema": SCHEMA, "complete": complete, "sha256": files}
    text = json.dumps(document, indent=2) + "\n"
    write_atomically(disk, manifest_path(table), text.encode("ascii"))


def check_manifest(table: Path) -> tuple[str, ...]:
    """Return a line for each file that is not as the recording left it.

    Empty where all is as it was, and where no manifest is beside the table.
    """
    manifest = manifest_path(table)
    try:
        text = manifest.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ()
    try:
        document = json.loads(text)
        files = {str(name): str(digest) for name, digest in document["sha256"].items()}
    except (ValueError, KeyError, TypeError, AttributeError):
        return (f"{manifest.name} cannot be understood: the table cannot be checked against it",)
    expected = {table.name, raw_path(table).name}
    if set(files) != expected:
        return (f"{manifest.name} is of {', '.join(sorted(files))[:200]}, not of this table",)
    changed = [name for name, digest in files.items() if _digest(table.with_name(name)) != digest]
    return tuple(f"{name} was changed after it was recorded" for name in changed)


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _digest(path: Path) -> str:
    try:
        return sha256(path)
    except OSError:
        return ""


def _beside(table: Path, ending: str) -> Path:
    stem = table.stem if table.suffix.lower() == ".csv" else table.name
    return table.with_name(stem + ending)
