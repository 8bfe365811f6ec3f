"""The file operations a recording rests on, few enough to be replaced by a failing disk in a test.

Each raises `OSError` as the system does. A lock is held by the open file and ends with its
process, however that ends.
"""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from typing import Protocol

_BINARY = getattr(os, "O_BINARY", 0)


class Disk(Protocol):
    """What a recording does with files."""

    def open(self, path: Path, *, new: bool) -> int:
        """Open for appending, and lock; ``new`` demands that the file is not there yet."""

    def write(self, file: int, data: bytes) -> int:
        """Write at the end and return how many bytes were taken."""

    def sync(self, file: int) -> None:
        """Return when everything written to the file is on the disk."""

    def close(self, file: int) -> None:
        """Close the file, which ends its lock."""

    def replace(self, source: Path, target: Path) -> None:
        """Rename over ``target``, in one step."""

    def remove(self, path: Path) -> None:
        """Remove the file if it is there."""

    def sync_folder(self, folder: Path) -> None:
        """Return when the folder's names are on the disk."""


class SystemDisk:
    """The machine's own files."""

    def open(self, path: Path, *, new: bool) -> int:
        """Open for appending, and lock; `BlockingIOError` where another recorder has it."""
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | _BINARY | (os.O_EXCL if new else 0)
        file = os.open(path, flags, 0o666)
        try:
            _lock(file)
        except OSError:
            os.close(file)
            raise
        return file

    def write(self, file: int, data: bytes) -> int:
        """Write at the end."""
        return os.write(file, data)

    def sync(self, file: int) -> None:
        """Flush to the disk."""
        os.fsync(file)

    def close(self, file: int) -> None:
        """Close."""
        os.close(file)

    def replace(self, source: Path, target: Path) -> None:
        """Rename over ``target``."""
        source.replace(target)

    def remove(self, path: Path) -> None:
        """Remove the file if it is there."""
        path.unlink(missing_ok=True)

    def sync_folder(self, folder: Path) -> None:
        """Flush the folder; Windows has no such call and keeps names by its journal."""
        if sys.platform == "win32":
            return
        file = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(file)
        finally:
            os.close(file)


def _lock(file: int) -> None:
    if sys.platform == "win32":
        import msvcrt  # noqa: PLC0415 - only there

        # A byte far behind the end: a lock on Windows would keep others from reading it.
        os.lseek(file, 0x7FFF0000, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl  # noqa: PLC0415 - not on Windows

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def write_whole(disk: Disk, file: int, data: bytes) -> None:
    """Write all of ``data``; `OSError` where the disk takes nothing."""
    while data:
        taken = disk.write(file, data)
        if taken <= 0:
            raise OSError(errno.ENOSPC, "the disk takes no more bytes")
        data = data[taken:]


def write_atomically(disk: Disk, path: Path, data: bytes) -> None:
    """Put ``data`` at ``path``: after a power cut the old or the new file is there, whole."""
    part = path.with_name(path.name + ".part")
    disk.remove(part)
    file = disk.open(part, new=True)
    try:
        write_whole(disk, file, data)
        disk.sync(file)
    finally:
        disk.close(file)
    disk.replace(part, path)
    disk.sync_folder(path.parent)
