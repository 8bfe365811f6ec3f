"""The line format of a raw file (``OUT.raw.jsonl``): one JSON object a line, each with its CRC-32.

A line proves itself: it is read whole and unharmed, or not at all. What a power cut leaves of
the last line is therefore seen, and nothing after it is lost.

Each also names the one before it: ``prev`` is its CRC-32, and of the first line zeros. Lines that
were taken away or changed afterwards are thus seen; what a crash tore off is not linked to. Files
of older versions have no ``prev``.

Every record has ``event``, ``t`` (seconds of the session's clock) and ``wall`` (UTC or null).
Bytes are records ``in`` and ``out`` with ``axis``, ``port`` and ``hex``.

The manifest beside a table (``OUT.manifest.json``) says what table and raw file were when the
recording ended.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from scara_iso import rawfile
from scara_iso.base.errors import CannotCreateError, NoInputError, ScaraIsoError
from scara_iso.base.files import open_file
from scara_iso.run import SEPARATOR, Run

SCHEMA = "scara-iso/raw/1"
MANIFEST_SCHEMA = "scara-iso/manifest/1"
_CHUNK = 1 << 18
CHANGED = "was changed after it was recorded"
FIRST = "00000000"
"""What the first line names as the one before it."""
LONGEST_LINE = 1 << 20
"""A longer line is not a line of ours; bounds the memory that a strange file takes [bytes]."""

_END = re.compile(rb'"crc":"[^"]{8}"}|"}\n$')
"""The end of a line, either half of it harmed."""
_TAIL = len(b',"crc":"01234567"}')

Record = dict[str, Any]


def encode(record: Mapping[str, object]) -> bytes:
    """Return the line of a record; `ValueError` where it holds a number that is not finite."""
    body = json.dumps(record, separators=(",", ":"), allow_nan=False).encode("ascii")
    return b'%b,"crc":"%08x"}\n' % (body[:-1], zlib.crc32(body))


def decode_record(line: bytes) -> Record | None:
    """Return the record of a line, or None where the line is torn or damaged.

    A line that lost only its end of line is whole: what is appended after it begins with one.
    """
    line = line.removesuffix(b"\n")
    body = line[:-_TAIL] + b"}"
    if line[-_TAIL:] != b',"crc":"%08x"}' % zlib.crc32(body):
        return None
    try:
        record = json.loads(body)
    except ValueError:
        return None
    return record if isinstance(record, dict) and "event" in record else None


def checksum(line: bytes) -> str:
    """Return the checksum at the end of a whole line, by which the next one names it."""
    return line.removesuffix(b"\n")[-10:-2].decode("ascii")


def read_records(path: Path) -> Iterator[tuple[int, Record | None]]:
    """Yield each line's number (from 1) and record with ``crc``, None for one that is torn.

    A line that was written to its end and is damaged has an empty record: it was changed.
    Empty lines, which a session that goes on begins with, mean nothing.

    Raises `NoInputError` where the file cannot be read.
    """
    try:
        with open_file(path) as file:
            lines = iter(lambda: file.readline(LONGEST_LINE), b"")
            for number, line in enumerate(lines, 1):
                if line != b"\n":
                    yield number, _read(line)
    except OSError as error:
        raise NoInputError(
            f"cannot be read: {error.strerror}", where=str(path), remedy="check the file name"
        ) from error


def _read(line: bytes) -> Record | None:
    if record := decode_record(line):
        return {**record, "crc": checksum(line)}
    return {} if _END.search(line) else None


def is_raw_file(start: bytes) -> bool:
    """Say whether a file that begins with ``start`` is a raw file and not a stream of bytes."""
    return start.startswith(b'{"event":')


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

    raw = raw_path(table)
    document = {
        "schema": MANIFEST_SCHEMA,
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
    return tuple(dict.fromkeys(line for lines in find_doubts(table) for line in lines))


def find_doubts(table: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what is not as the manifest says, of a table and of its raw file; some is of both."""
    manifest, raw = manifest_path(table), raw_path(table)
    try:
        document = json.loads(manifest.read_text(encoding="utf-8"))
        files = {str(name): str(digest) for name, digest in document["sha256"].items()}
        size = int(document.get("raw_bytes", -1))
        earlier = tuple(str(line) for line in document.get("doubts", ()))
    except FileNotFoundError:
        missing = f"{manifest.name} is missing: whether the recording was changed cannot be seen"
        return (missing,), (missing,)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        unclear = f"{manifest.name} cannot be understood: the table cannot be checked against it"
        return (unclear,), (unclear,)
    return _changed(table, files), (*_changed(raw, files, size), *earlier)


def _changed(path: Path, files: Mapping[str, str], size: int = -1) -> tuple[str, ...]:
    if path.name not in files:
        return (f"the manifest is of {', '.join(sorted(files))[:200]}, not of this table",)
    try:
        same = sha256(path, size) == files[path.name]
    except OSError:
        return (f"{path.name} is missing or cannot be read",)
    return () if same else (f"{path.name} {CHANGED}",)


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


LEFT_OUT = "record_left_out"
"""Key of what is stored in the raw file beside a table, and not in the table."""
_RECORDED = re.compile(r"(X|Y|Z|theta) [\w-]+ .+ at \S.*", re.DOTALL)  # of an indicator


def check_recording(run: Run, table: Path) -> Run:
    """Return the run of a table with what raw file and manifest, or their lack, say against it."""
    raw, head = raw_path(table), dict(run.metadata)
    found = check_manifest(table)
    if raw.exists() and f"{table.name} {CHANGED}" not in found:
        found += _differs(run, raw, table.name, head)
    elif not found and _RECORDED.match(head.get("indicator", "")):
        missing = f"{raw.name} and {manifest_path(table).name} are missing"
        found = (f"{missing}: nothing holds {table.name} against what was recorded",)
    if doubts := [*filter(None, head.get("doubts", "").split(SEPARATOR)), *found]:
        head["doubts"] = SEPARATOR.join(dict.fromkeys(doubts))
    return replace(run, metadata=head)


def _differs(run: Run, raw: Path, table: str, head: dict[str, str]) -> tuple[str, ...]:
    """Return that readings are not those of the raw file; ``head`` takes that it holds more."""
    try:
        recorded = rawfile.read_history(raw).run().unwrapped()
    except ScaraIsoError as error:
        return (f"{table} cannot be held against {raw.name}: {error.what}",)
    same = len(recorded) >= len(run) and all(
        name in recorded.axes
        and np.abs(axis.shown - recorded.axes[name].readings[: len(run)]).max() < 1e-9
        for name, axis in run.axes.items()
    )
    if same and len(recorded) > len(run):
        counted = "cycles" if recorded.pose is None else "visits"
        more = f"{len(recorded)} {counted}, {table} {len(run)}"
        todo = f"record with `resume=True` goes on, with `rebuild={raw}` makes the table of it"
        head[LEFT_OUT] = f"{raw.name} holds {more}: {todo}"
        return ()
    return () if same else (f"the readings of {table} are not those of {raw.name}",)
