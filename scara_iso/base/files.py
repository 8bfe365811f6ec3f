"""The one way a file that a user names is opened for reading: regular and of a bounded size.

A pipe or a device would wait or never end.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import Any, BinaryIO

from scara_iso.base.errors import DataError, NoInputError

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
