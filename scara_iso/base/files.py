"""The files that a user names: how each is read, how each is written, and TOML by its keys.

Read is a regular file of a bounded size: a pipe or a device would wait or never end. Of a file
that is written the old one or the new one is there, whole, whatever happens; a path may lead to
standard output or a device, which is written as it is.

The operations of a disk are few enough to be replaced by a failing one in a test; each raises
`OSError` as the system does. A lock is held by the open file and ends with its process, however
that ends. Every fault in the values of a TOML file is named by its key.
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
from typing import Any, BinaryIO

from scara_iso.base.errors import (
    CannotCreateError,
    DataError,
    Fault,
    NoInputError,
    UsageError,
    WriteError,
)
from scara_iso.base.process import Later, were_heard

_LARGEST_TOML = 1_000_000
_NEARLY = 0.8


def is_folder(path: str | Path) -> bool:
    """Say whether a folder is there; a name that no disk takes is none, where `Path` raises."""
    return os.path.isdir(path)  # noqa: PTH112


def is_file(path: str | Path) -> bool:
    """Say likewise whether a regular file is there."""
    return os.path.isfile(path)  # noqa: PTH113


def open_file(path: str | Path) -> BinaryIO:
    """Open a regular file; `NoInputError` where there is none or it cannot be read."""
    try:
        file = open(path, "rb", opener=_open_at_once)  # noqa: SIM115 - the caller closes it
    except (OSError, ValueError) as error:
        raise not_read(path, error) from error
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise NoInputError(
            "is not a regular file", where=str(path), remedy="save it as a file, and name that"
        )
    return file


def not_read(path: str | Path, error: Exception) -> NoInputError:
    """Return the error of a file that cannot be read; one of nearly its name may be meant."""
    reason = getattr(error, "strerror", None) or str(error)
    remedy = "let this user read it, or name another file"
    if isinstance(error, FileNotFoundError):
        near = _nearly(Path(path))
        remedy = f"is it {near}?" if near else "check its name and its folder"
    return NoInputError(reason, where=str(path), remedy=remedy)


def _nearly(path: Path) -> Path | None:
    from difflib import get_close_matches  # noqa: PLC0415 - for a wrong name only

    try:
        found = get_close_matches(
            path.name, (one.name for one in path.parent.iterdir()), n=1, cutoff=_NEARLY
        )
    except (OSError, ValueError):
        return None
    return path.with_name(found[0]) if found else None


def read_file(path: str | Path, limit: int) -> bytes:
    """Return the bytes of a regular file; raises as `open_file`, `DataError` beyond ``limit``."""
    with open_file(path) as file:
        try:
            data = file.read(limit + 1)
        except OSError as error:
            raise not_read(path, error) from error
    if len(data) > limit:
        raise DataError(f"larger than {limit} bytes", where=str(path), remedy="name another file")
    return data


def read_toml(path: str | Path) -> dict[str, Any]:
    """Return what a TOML file of at most a megabyte holds; raises as `read_file`, `DataError`."""
    import tomllib  # noqa: PLC0415 - of all files only those

    remedy = "write KEY = VALUE lines, texts in quotes, below headings such as [robot]"
    try:
        found = tomllib.loads(read_file(path, _LARGEST_TOML).decode("utf-8-sig"))
        str(found)  # fails where a number has more digits than Python prints
    except RecursionError as error:
        raise DataError(
            "nested deeper than any of these", where=str(path), remedy=remedy
        ) from error
    except ValueError as error:
        raise DataError(f"is not valid TOML: {error}", where=str(path), remedy=remedy) from error
    return found


def _open_at_once(path: str, flags: int) -> int:
    """Open without waiting for the other end of a pipe."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


_ROOM = "make room, or name another place; what was there is as it was"
_ANOTHER, _MAKE = "name another place", "make the folder, or name another place"
_BINARY = getattr(os, "O_BINARY", 0)
_FULL = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))
_BLOCK = bytes(4096)


class Disk:
    """The machine's own files."""

    def open(self, path: Path, *, new: bool) -> int:
        """Open for appending, and lock; ``new`` demands that the file is not there yet.

        Raises `BlockingIOError` where another process has it.
        """
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | _BINARY | (os.O_EXCL if new else 0)
        file = os.open(path, flags, 0o666)
        try:
            _lock(file)
        except OSError:
            os.close(file)
            raise
        return file

    def create(self, path: Path) -> int:
        """Open a file that must not be there yet, with the permissions that the mask leaves."""
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, 0o666)

    def write(self, file: int, data: bytes) -> int:
        """Write at the end and return how many bytes were taken."""
        return os.write(file, data)

    def sync(self, file: int) -> None:
        """Return when everything written to the file is on the disk."""
        os.fsync(file)

    def close(self, file: int) -> None:
        """Close the file, which ends its lock."""
        os.close(file)

    def replace(self, source: Path, target: Path) -> None:
        """Rename over ``target``, in one step."""
        source.replace(target)

    def remove(self, path: Path) -> None:
        """Remove the file if it is there."""
        path.unlink(missing_ok=True)

    def sync_folder(self, folder: Path) -> None:
        """Return when the folder's names are on the disk; Windows keeps them by its journal."""
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
    names, and what stands there keeps its permissions. A signal ends the process behind it.
    """
    targets = {path.resolve(): data for path, data in files.items()}
    with Later():
        _write_parts(disk, targets, {target: target.with_name(_part_name()) for target in targets})
    for folder in {target.parent for target in targets}:
        disk.sync_folder(folder)


def _write_parts(disk: Disk, targets: Mapping[Path, bytes], parts: Mapping[Path, Path]) -> None:
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


def _part_name() -> str:
    """Return a name that no one else uses: never a user's own."""
    return f".scara-iso-{os.urandom(8).hex()}.part"


def _write_part(disk: Disk, part: Path, target: Path, data: bytes) -> None:
    file = disk.create(part)
    try:
        write_whole(disk, file, data)
        disk.sync(file)
    finally:
        disk.close(file)
    if target.exists():
        shutil.copymode(target, part)


def check_output(*paths: Path) -> None:
    """Raise, before any work begins, where one of these could not be written.

    `CannotCreateError` where no file can be there, `WriteError` for a disk that is full. What is
    there stays as it is: the folder is tried with a block, which is removed.
    """
    for path in paths:
        target = target_of(path)
        if target is not None:
            _try(target.parent, path)


_NO_TEXT = frozenset(
    (".xlsx", ".xls", ".ods", ".json", ".jsonl", ".html", ".md", ".pdf", ".png", ".svg", ".parquet")
)


def check_table_name(path: Path) -> None:
    """Raise `UsageError` where a table, which is text, is to have the ending of another kind."""
    if path.suffix.lower() in _NO_TEXT:
        raise UsageError(
            f"a table is text, and {path.suffix} is another kind of file",
            where=str(path),
            remedy=f"name it {path.with_suffix('.csv').name}",
        )


def check_folder(folder: Path) -> None:
    """Raise as `check_output` where a folder takes no files, or could not be made."""
    there = folder
    try:
        folder.exists()  # raises for a name that no disk takes
        while not os.path.lexists(there) and there != there.parent:
            there = there.parent
    except (OSError, ValueError) as error:
        raise not_writable(folder, error) from error
    _try(there, folder)


def _try(folder: Path, where: Path) -> None:
    """Write a block into a folder and remove it."""
    disk, part = Disk(), folder / _part_name()
    with Later():
        try:
            file = disk.create(part)
            try:
                write_whole(disk, file, _BLOCK)
            finally:
                disk.close(file)
                disk.remove(part)
        except (OSError, ValueError) as error:
            raise not_writable(where, error) from error


def write_file(path: Path, data: bytes, disk: Disk | None = None) -> None:
    """Write a file at once, so that no failure and no kill leaves half of it.

    Standard output or a device that the path names is written to as it is. Raises
    `CannotCreateError` where nothing can be there, `WriteError` where writing fails; what was
    there before then stays.
    """
    if were_heard():  # and swallowed where ``data`` was made: they may lack something
        raise KeyboardInterrupt
    target = target_of(path)
    disk = disk or Disk()
    try:
        if target is not None:
            write_atomically(disk, {target: data})
            return
        stream = open_stream(path)
        try:
            write_whole(disk, stream, data)
        finally:
            disk.close(stream)
    except OSError as error:
        raise WriteError(
            f"cannot be written: {error.strerror or error}", where=str(path), remedy=_ROOM
        ) from error


def target_of(path: Path) -> Path | None:
    """Return the file that a path leads to; None for standard output, or a device.

    Raises `CannotCreateError` where it cannot be written, as a pipe of another program.
    """
    try:
        if _is_stream(path):
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
    if _standard(found) is None and not stat.S_ISCHR(found.st_mode):
        if not stat.S_ISREG(found.st_mode) and not stat.S_ISDIR(found.st_mode):
            raise OSError(errno.ENXIO, "it is a pipe, or no file at all")
        return False
    if not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return True


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
    return os.open(path, os.O_WRONLY | _BINARY)


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
        return WriteError(f"cannot be written: {why}", where=str(path), remedy=_ROOM)
    with contextlib.suppress(OSError, ValueError):
        why += f" (it is a link to {path.readlink()})"
    remedy = _MAKE if number == errno.ENOENT else _ANOTHER
    return CannotCreateError(f"cannot be written: {why}", where=str(path), remedy=remedy)


class KeyFaults(list[Fault]):
    """Faults of one file, each named by its key."""

    def add(self, key: str, message: str) -> None:
        """Add a fault."""
        self.append(Fault(f"{key}: {message}"))


def section(document: Mapping[str, Any], key: str, faults: KeyFaults) -> dict[str, Any]:
    """Return the section ``key``, empty where it is missing or none."""
    found = document.get(key, {})
    if isinstance(found, dict):
        return found
    faults.add(key, "is not a section")
    return {}


def number_at(table: Mapping[str, Any], key: str, where: str, faults: KeyFaults) -> float | None:
    """Return a number; None where it is missing or none."""
    value = table.get(key)
    if value is None:
        return None
    if not is_number(value):
        faults.add(f"{where}.{key}", f"{repr(value)[:40]} is not a finite number")
        return None
    return float(value)


def pair(table: Mapping[str, Any], key: str, where: str, faults: KeyFaults) -> tuple[float, float]:
    """Return a list of two numbers, zeros for what is none."""
    value = table[key]
    if isinstance(value, list) and len(value) == 2:
        both = [number_at({key: part}, key, where, faults) for part in value]
        return (both[0] or 0.0, both[1] or 0.0)
    faults.add(f"{where}.{key}", f"{repr(value)[:40]} is not a pair of numbers")
    return (0.0, 0.0)


def only(table: Mapping[str, Any], known: set[str], where: str, faults: KeyFaults) -> None:
    """Add a fault for each key that is not known."""
    for key in table:
        if key not in known:
            faults.add(f"{where}.{key}", f"no such key; known are {', '.join(sorted(known))}")


def is_number(value: object) -> bool:
    """Return whether a value is a finite number that a float holds."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 1e300
