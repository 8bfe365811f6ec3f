"""How every file is written: the old one or the new one is there, whole, whatever happens.

The operations are few enough to be replaced by a failing disk in a test; each raises `OSError` as
the system does. A lock is held by the open file and ends with its process, however that ends.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import stat
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from scara_iso.errors import CannotCreateError, WriteError

_BINARY = getattr(os, "O_BINARY", 0)


class Disk(Protocol):
    """What is done with files."""

    def open(self, path: Path, *, new: bool) -> int:
        """Open for appending, and lock; ``new`` demands that the file is not there yet."""

    def create(self, path: Path) -> int:
        """Open a file that must not be there yet."""

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

    def create(self, path: Path) -> int:
        """Open a new file, with the permissions that the user's mask leaves."""
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, 0o666)

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
        except OSError as error:
            if error.errno != errno.EINVAL:  # a file system that has no such call
                raise
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


def write_atomically(disk: Disk, files: Mapping[Path, bytes]) -> None:
    """Put bytes at their paths: after a power cut each holds what it held, or the new, whole.

    Nothing is renamed before all of them are on the disk. A link goes on pointing to what it
    names, and what stands there keeps its permissions.
    """
    targets = {path.resolve(): data for path, data in files.items()}
    parts = {target: _part(target) for target in targets}
    try:
        for target, data in targets.items():
            _write_part(disk, parts[target], target, data)
        for target, part in parts.items():
            disk.replace(part, target)
    except BaseException:
        for part in parts.values():
            with contextlib.suppress(OSError):
                disk.remove(part)
        raise
    for folder in {target.parent for target in targets}:
        disk.sync_folder(folder)


def _part(target: Path) -> Path:
    """Return a name in the folder of ``target`` that no one else uses: never a user's own."""
    return target.with_name(f".scara-iso-{os.urandom(8).hex()}.part")


def _write_part(disk: Disk, part: Path, target: Path, data: bytes) -> None:
    file = disk.create(part)
    try:
        write_whole(disk, file, data)
        disk.sync(file)
    finally:
        disk.close(file)
    if target.exists():
        shutil.copymode(target, part)


def write_file(path: Path, data: bytes, disk: Disk | None = None) -> None:
    """Write a file at once, so that no failure and no kill leaves half of it.

    Standard output, a pipe or a device that the path names is written to as it is. Raises
    `CannotCreateError` where nothing can be there, `WriteError` where writing fails; what was
    there before then stays.
    """
    try:
        stream = _open_stream(path)
        if stream is None:
            _refuse_unwritable(path)
    except OSError as error:
        raise CannotCreateError(
            f"cannot be written: {error.strerror}", where=str(path), remedy="name another place"
        ) from error
    disk = disk or SystemDisk()
    try:
        if stream is None:
            write_atomically(disk, {path: data})
            return
        try:
            write_whole(disk, stream, data)
        finally:
            disk.close(stream)
    except OSError as error:
        raise WriteError(
            f"cannot be written: {error.strerror or error}", where=str(path),
            remedy="make room, or name another place; what was there is as it was",
        ) from error  # fmt: skip


def _open_stream(path: Path) -> int | None:
    """Return what to write to where the path names no file on a disk, else None."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    for file in (1, 2):
        with contextlib.suppress(OSError):  # closed
            if os.path.samestat(os.fstat(file), found):
                return os.dup(file)  # its place in a file that the shell opened is kept
    return None if stat.S_ISREG(found.st_mode) else os.open(path, os.O_WRONLY | _BINARY)


def _refuse_unwritable(path: Path) -> None:
    """Raise the `OSError` of writing in place: a rename would pass over a file's protection."""
    target = path.resolve()
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    folder = target.parent
    if not folder.is_dir():
        number = errno.ENOTDIR if folder.exists() else errno.ENOENT
        raise OSError(number, os.strerror(number))
    if not os.access(folder, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
