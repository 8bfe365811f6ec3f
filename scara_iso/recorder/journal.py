"""The raw file of a recording: appended to, locked, and safe when it says so."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Iterator
from pathlib import Path

from scara_iso.base.errors import CannotCreateError, ScaraIsoError, WriteError
from scara_iso.base.files import Disk, write_whole
from scara_iso.base.process import Later
from scara_iso.rawfile import FIRST, checksum, encode
from scara_iso.recorder.ports.port import Clock


class Journal:
    """Appends records; what was appended before `sync` returned survives a power cut.

    A write or sync that failed is never tried again: after a failed fsync the data may be gone
    even where the next one succeeds. Every later call raises the same `WriteError`. Opening
    raises `CannotCreateError` where the file is there already (``new``), is held by another
    recorder or cannot be created.
    """

    def __init__(self, path: Path, *, disk: Disk, clock: Clock, new: bool) -> None:
        self.path = path
        self._disk = disk
        self._clock = clock
        self.previous = FIRST
        """Checksum of the last whole line; who goes on with a file states it."""
        self.failed: WriteError | None = None
        try:
            self._file = disk.open(path, new=new)
        except OSError as error:
            raise _cannot_open(path, error) from error
        # Ends what a crash may have left of a line; an empty line means nothing.
        self._torn = not new
        try:
            disk.sync_folder(path.parent)
        except OSError as error:
            self.close()
            if not new:
                raise _lost(path, error) from error
            with contextlib.suppress(OSError):
                disk.remove(path)
            raise _cannot_open(path, error) from error

    def append(self, event: str, **fields: object) -> None:
        """Write a record; it is safe after the next `sync`."""
        record = {"event": event, "t": round(self._clock.now(), 6), "wall": self._clock.wall()}
        line = encode({**record, **fields, "prev": self.previous})
        with self._failing(), Later():  # a line that nobody knows of breaks the chain for ever
            data, self._torn = (b"\n" if self._torn else b"") + line, True
            write_whole(self._disk, self._file, data)
            self._torn, self.previous = False, checksum(line)

    def sync(self) -> None:
        """Return when every record is on the disk."""
        with self._failing():
            self._disk.sync(self._file)

    def close(self) -> None:
        """Close the file and give the lock back."""
        with contextlib.suppress(OSError):
            self._disk.close(self._file)

    @contextlib.contextmanager
    def _failing(self) -> Iterator[None]:
        if self.failed is not None:
            raise self.failed
        try:
            yield
        except OSError as error:
            self.failed = _lost(self.path, error)
            raise self.failed from error


def _lost(path: Path, error: OSError) -> WriteError:
    return WriteError(
        f"the disk failed ({error.strerror or error}); every reading announced as stored is safe",
        where=str(path),
        remedy="make room or use another disk, copy the raw file there, then "
        "record with `rebuild=True` or continue with `resume=True`",
    )


def _cannot_open(path: Path, error: OSError) -> ScaraIsoError:
    match error.errno:
        case errno.EEXIST:
            what, remedy = "exists already", "use another name, or `resume=True` to continue it"
        case errno.EAGAIN | errno.EACCES if isinstance(error, BlockingIOError):
            what, remedy = "another recorder is writing it", "end that one first"
        case _:
            what, remedy = f"cannot be created ({error.strerror})", "check folder and permissions"
    return CannotCreateError(what, where=str(path), remedy=remedy)
