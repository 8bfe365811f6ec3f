"""What is at the place of an output: overwritten only where the program could make it again."""

from __future__ import annotations

import re
import zipfile
import zlib
from pathlib import Path

from scara_iso.base.errors import CannotCreateError, ScaraIsoError
from scara_iso.base.files import is_file, read_file

_LARGEST, _UNREAD = 1 << 28, b"unread"
_BROKEN = (zipfile.BadZipFile, zlib.error)
_OWN = re.compile(
    rb"\A\s*\Z|^(?!#).*scara-iso|^# (written by scara-iso|simulated:|stream_sha256:)"
    rb"|\A\W*(x_mm.y_mm.RP_mm|visit.pose.x_mm)",
    re.MULTILINE,
)
"""What a file of this program says: its name (in a comment that may stand above readings, only as
of a saved model), that readings are simulated or of a stream that is named, a map's or plan's head.
"""


def refuse_foreign(*paths: Path) -> None:
    """Raise `CannotCreateError` where one is there that the program could not make again.

    Readings are measured once: it overwrites nothing but what it wrote itself, and empty files.
    """
    for path in paths:
        if is_file(path) and not _OWN.search(text_of(path)):
            raise CannotCreateError(
                "is there, and may hold what cannot be made again",
                where=str(path),
                remedy="name another file, or remove it yourself",
            )


def text_of(path: Path) -> bytes:
    """Return the bytes of a file, those of its parts where it is packed, as a workbook is.

    Where they cannot be read, or are more than this program writes, some that it never writes.
    """
    try:
        data = read_file(path, _LARGEST)
        if not zipfile.is_zipfile(path):
            return data
        with zipfile.ZipFile(path) as parts:
            if sum(one.file_size for one in parts.infolist()) > _LARGEST:
                return _UNREAD
            return b"".join(map(parts.read, parts.namelist()))
    except (ScaraIsoError, OSError, RuntimeError, ValueError, EOFError, *_BROKEN):
        return _UNREAD
