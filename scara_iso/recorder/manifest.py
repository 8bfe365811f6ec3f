"""The manifest beside a table: what its files were when the recording ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from scara_iso.base.errors import CannotCreateError

SCHEMA = "scara-iso/manifest/1"
_CHUNK = 1 << 18


@dataclass(frozen=True, slots=True)
class Doubts:
    """What is not as the recording left it, a line each; what cannot be compared is in both."""

    table: tuple[str, ...]
    recording: tuple[str, ...]
    """Of the raw file, and what was said of it earlier: it stays."""


def raw_path(table: Path) -> Path:
    """Return the raw file beside a table: ``run.raw.jsonl`` of ``run.csv``."""
    return _beside(table, ".raw.jsonl")


def manifest_path(table: Path) -> Path:
    """Return the manifest beside a table: ``run.manifest.json`` of ``run.csv``."""
    return _beside(table, ".manifest.json")


def manifest_of(table: Path, data: bytes, *, complete: bool, doubts: Sequence[str]) -> bytes:
    """Return the manifest of a table with the bytes ``data``; `OSError` without its raw file.

    The raw file may grow afterwards: what it was up to now is not changed by that.
    """
    import hashlib  # noqa: PLC0415 - of all tables only those that were recorded here have one
    import json  # noqa: PLC0415

    raw = raw_path(table)
    document = {
        "schema": SCHEMA,
        "complete": complete,
        "sha256": {table.name: hashlib.sha256(data).hexdigest(), raw.name: sha256(raw)},
        "raw_bytes": raw.stat().st_size,
        "doubts": list(doubts),
    }
    return (json.dumps(document, indent=2) + "\n").encode("ascii")


def check_manifest(table: Path) -> tuple[str, ...]:
    """Return a line for each file that is not as the recording left it, and each older doubt.

    Empty where all is as it was, and where the table was not recorded.
    """
    if not raw_path(table).exists() and not manifest_path(table).exists():
        return ()
    found = find_doubts(table)
    return tuple(dict.fromkeys(found.table + found.recording))


def find_doubts(table: Path) -> Doubts:
    """Compare a table and its raw file with their manifest."""
    import json  # noqa: PLC0415

    manifest, raw = manifest_path(table), raw_path(table)
    try:
        document = json.loads(manifest.read_text(encoding="utf-8"))
        files = {str(name): str(digest) for name, digest in document["sha256"].items()}
        size = int(document.get("raw_bytes", -1))
        earlier = tuple(str(line) for line in document.get("doubts", ()))
    except FileNotFoundError:
        missing = f"{manifest.name} is missing: whether the recording was changed cannot be seen"
        return Doubts((missing,), (missing,))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        unclear = f"{manifest.name} cannot be understood: the table cannot be checked against it"
        return Doubts((unclear,), (unclear,))
    return Doubts(_changed(table, files), (*_changed(raw, files, size), *earlier))


def _changed(path: Path, files: Mapping[str, str], size: int = -1) -> tuple[str, ...]:
    if path.name not in files:
        return (f"the manifest is of {', '.join(sorted(files))[:200]}, not of this table",)
    try:
        same = sha256(path, size) == files[path.name]
    except OSError:
        same = False
    return () if same else (f"{path.name} was changed after it was recorded",)


def sha256(path: Path, size: int = -1) -> str:
    """Return the SHA-256 of a file, or of its first ``size`` bytes, in hex."""
    import hashlib  # noqa: PLC0415

    digest = hashlib.sha256()
    with path.open("rb") as file:
        while part := file.read(_CHUNK if size < 0 else min(_CHUNK, size - file.tell())):
            digest.update(part)
    return digest.hexdigest()


def _beside(table: Path, ending: str) -> Path:
    if not table.name:
        raise CannotCreateError("names no file", where=str(table), remedy="name a file, OUT.csv")
    stem = table.stem if table.suffix.lower() == ".csv" else table.name
    return table.with_name(stem + ending)
