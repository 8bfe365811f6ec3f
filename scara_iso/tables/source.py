"""Bytes of a path, of standard input, or of an open file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import BinaryIO

from scara_iso.files import not_read, open_file
from scara_iso.tables.faults import refuse
from scara_iso.tables.kinds import refuse_other_kind

LIMIT = 256 * 2**20
"""Largest file that is read, in bytes; a million rows take about 50 MB."""

WORKBOOK = b"PK\x03\x04"
OLD_WORKBOOK = b"\xd0\xcf\x11\xe0"
"""First bytes of an .xlsx, and of an .xls or a protected workbook."""

Source = str | Path | bytes | BinaryIO


def read_bytes(source: Source) -> tuple[bytes, str]:
    """Return a source's bytes and its name: the path, or what else it is.

    Raises `NoInputError` where there is no such file or it cannot be read, `DataError` where it
    is larger than `LIMIT`, or a picture or the like.
    """
    name = _name(source)
    try:
        data = _read(source)
    except (OSError, ValueError) as error:
        raise not_read(name, error) from error
    if len(data) > LIMIT:
        raise refuse(name, f"larger than {LIMIT // 2**20} MB", remedy="split the file")
    refuse_other_kind(data, name)
    return data, name


def _name(source: Source) -> str:
    match source:
        case "-":
            return "standard input"
        case str() | Path():
            return str(source)
        case bytes():
            return "bytes"
        case _:
            return str(getattr(source, "name", "file object"))


def _read(source: Source) -> bytes:
    match source:
        case bytes():
            return source
        case "-":
            if sys.stdin is None:
                raise OSError("standard input is closed")
            return sys.stdin.buffer.read(LIMIT + 1)
        case str() | Path():
            with open_file(source) as file:
                return file.read(LIMIT + 1)
        case _:
            return source.read(LIMIT + 1)
