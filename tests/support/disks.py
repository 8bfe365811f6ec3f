"""Disks that fail, and what a power cut may leave of what was written to one."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from pathlib import Path

from scara_iso.base.files import Disk


class UnsyncedDisk(Disk):
    """A disk for tests that look at something else: it does not wait for the platter."""

    def sync(self, file):
        pass

    def sync_folder(self, folder):
        pass


class LoggedDisk(UnsyncedDisk):
    """A real disk that keeps the list of what was done to it, and of what was announced."""

    def __init__(self):
        self.log = []
        self._paths = {}

    def announce(self, said):
        self.log.append(("said", said))

    def open(self, path, *, new):
        created = not path.exists()
        file = super().open(path, new=new)
        self._paths[file] = path
        self.log.append(("open", path, created))
        return file

    def create(self, path):
        file = super().create(path)
        self._paths[file] = path
        self.log.append(("open", path, True))
        return file

    def write(self, file, data):
        taken = super().write(file, data)
        self.log.append(("write", self._paths[file], data[:taken]))
        return taken

    def sync(self, file):
        super().sync(file)
        self.log.append(("sync", self._paths[file]))

    def replace(self, source, target):
        super().replace(source, target)
        self.log.append(("replace", source, target))

    def remove(self, path):
        super().remove(path)
        self.log.append(("remove", path))

    def sync_folder(self, folder):
        super().sync_folder(folder)
        self.log.append(("sync_folder", folder))


def crash_states(log) -> Iterator[tuple[str, dict[Path, bytes]]]:
    """Yield what may be on the disk after a power cut behind the operations in ``log``.

    Unsynced bytes are dropped, kept, cut anywhere in their last write, or zeros; names that were
    not synced are old or new, all of them alike.
    """
    safe, now = {}, {}  # path -> [bytes, how many of them are synced]
    for operation in log:
        if operation[0] == "sync_folder":
            safe = dict(now)
        else:
            _do(operation, now)
    for names, files in (("old names", safe), ("new names", now)):
        for how in ("dropped", "kept", "torn 1", "torn half", "torn last", "zeros"):
            yield f"{names}, {how}", {p: _left(*file, how) for p, file in files.items()}


def _do(operation, files):
    match operation:
        case ("open", path, True):
            files[path] = [b"", 0]
        case ("write", path, data):
            files[path][0] += data
        case ("sync", path):
            files[path][1] = len(files[path][0])
        case ("replace", source, target):
            files[target] = files.pop(source)
        case ("remove", path):
            files.pop(path, None)


def _left(data: bytes, synced: int, how: str) -> bytes:
    loose = data[synced:]
    match how:
        case "dropped":
            return data[:synced]
        case "kept":
            return data
        case "torn 1":
            return data[:synced] + loose[:1]
        case "torn half":
            return data[:synced] + loose[: len(loose) // 2]
        case "torn last":
            return data[:synced] + loose[:-1]
    return data[:synced] + bytes(len(loose))


class FailingDisk(UnsyncedDisk):
    """A disk whose n-th operation (from 0) fails; what comes after it works again."""

    def __init__(self, n, number=errno.EIO):
        self.left = n
        self.number = number
        self.failed = None
        self.after = []

    def _count(self, name, *what):
        if self.failed:
            self.after.append((name, *what))
        self.left -= 1
        if self.left == -1:
            self.failed = (name, *what)
            raise OSError(self.number, "injected")

    def open(self, path, *, new):
        self._count("open", path)
        return super().open(path, new=new)

    def create(self, path):
        self._count("create", path)
        return super().create(path)

    def write(self, file, data):
        self._count("write", file)
        return super().write(file, data)

    def sync(self, file):
        self._count("sync", file)
        super().sync(file)

    def replace(self, source, target):
        self._count("replace", target)
        super().replace(source, target)

    def remove(self, path):
        self._count("remove", path)
        super().remove(path)

    def sync_folder(self, folder):
        self._count("sync_folder", folder)
        super().sync_folder(folder)


class FullDisk(UnsyncedDisk):
    """A disk with room for so many bytes more; the last write is taken in part."""

    def __init__(self, room):
        self.room = room

    def write(self, file, data):
        if self.room == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        taken = super().write(file, data[: self.room])
        self.room -= taken
        return taken
