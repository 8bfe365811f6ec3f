"""Where a path leads that is to be written: to a file on a disk, or to a stream such as a pipe."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from pathlib import Path

from scara_iso.base.errors import CannotCreateError, WriteError

ROOM = "make room, or name another place; what was there is as it was"
_ANOTHER, _MAKE = "name another place", "make the folder, or name another place"
_BINARY, _AT_ONCE = getattr(os, "O_BINARY", 0), getattr(os, "O_NONBLOCK", 0)
_FULL = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))
_pipes: dict[Path, int] = {}
"""Opened by `target_of`: closed before the first byte, a reader would take that for the end."""


def target_of(path: Path) -> Path | None:
    """Return the file that a path leads to; None for a stream, such as a pipe, once it is open.

    Raises `CannotCreateError` where it cannot be written.
    """
    try:
        if _is_stream(path):
            _open_pipe(path)
            return None
        target = path.resolve()
        _refuse_unwritable(target)
    except (OSError, ValueError) as error:
        raise not_writable(path, error) from error
    return target


def _is_stream(path: Path) -> bool:
    """Say whether bytes go where the path names no file on a disk, and none that may be."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return False
    on_disk = stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode)
    return not on_disk or _standard(found) is not None


def _standard(found: os.stat_result) -> int | None:
    """Return which of the standard streams a file is, if any."""
    for file in (1, 2):
        with contextlib.suppress(OSError):  # closed
            if os.path.samestat(os.fstat(file), found):
                return file
    return None


def open_stream(path: Path) -> int:
    """Open what takes the bytes where the path names no file on a disk."""
    standard = _standard(path.stat())
    if standard is not None:
        return os.dup(standard)  # its place in a file that the shell opened is kept
    held = _pipes.pop(path, None)
    return os.open(path, os.O_WRONLY | _BINARY) if held is None else held


def _open_pipe(path: Path) -> None:
    """Open a pipe that somebody reads; without a reader that would wait for ever."""
    found = path.stat()
    if _standard(found) is not None or path in _pipes:
        return
    if stat.S_ISCHR(found.st_mode) or stat.S_ISBLK(found.st_mode):
        if not os.access(path, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return
    _pipes[path] = os.open(path, os.O_WRONLY | _BINARY | _AT_ONCE)
    os.set_blocking(_pipes[path], True)


def _refuse_unwritable(target: Path) -> None:
    """Raise the `OSError` of writing in place: a rename would pass over a file's protection."""
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


def not_writable(path: Path, error: Exception) -> CannotCreateError | WriteError:
    """Return the error of a place that cannot be written; `WriteError` for a full disk."""
    number, why = getattr(error, "errno", None), getattr(error, "strerror", None) or str(error)
    if number in _FULL:
        return WriteError(f"cannot be written: {why}", where=str(path), remedy=ROOM)
    with contextlib.suppress(OSError, ValueError):
        why += f" (it is a link to {path.readlink()})"
    remedy = _MAKE if number == errno.ENOENT else _ANOTHER
    if number == errno.ENXIO:
        why, remedy = "it is a pipe that nobody reads", "start its reader first, or name a file"
    return CannotCreateError(f"cannot be written: {why}", where=str(path), remedy=remedy)
