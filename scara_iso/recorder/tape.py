"""The line format of a raw file (``OUT.raw.jsonl``): one JSON object a line, each with its CRC-32.

A line proves itself: it is read whole and unharmed, or not at all. What a power cut leaves of
the last line is therefore seen, and nothing after it is lost.

Each also names the one before it: ``prev`` is its CRC-32, and of the first line zeros. Lines that
were taken away or changed afterwards are thus seen; what a crash tore off is not linked to. Files
of older versions have no ``prev``.

Every record has ``event``, ``t`` (seconds of the session's clock) and ``wall`` (UTC or null).
Bytes are records ``in`` and ``out`` with ``axis``, ``port`` and ``hex``.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from scara_iso.base.errors import NoInputError
from scara_iso.base.files import open_file

SCHEMA = "scara-iso/raw/1"
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


def read_tape(path: Path) -> Iterator[tuple[int, Record | None]]:
    """Yield each line's number (from 1) and record with ``crc``, None for one that is torn.

    A line that was written to its end and is damaged has an empty record: it was changed.
    Empty lines, which a session that goes on begins with, mean nothing.

    Raises `NoInputError` where the file cannot be read.
    """
    try:
        with open_file(path) as file:
            number = 0
            while line := file.readline(LONGEST_LINE):
                number += 1
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


def is_tape(start: bytes) -> bool:
    """Say whether a file that begins with ``start`` is a raw file and not a stream of bytes."""
    return start.startswith(b'{"event":')
