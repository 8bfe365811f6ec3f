"""What was meant by the name of a file that is to be written, and stands where one is read."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scara_iso.base.errors import NoInputError
from scara_iso.render import endings

_READ_TOO = (".csv", ".json", ".xlsx")
_NO_COMMAND = re.compile(r"No such command '(.+?)'")
_EXTRA = re.compile(r"unexpected extra argument\S* \((\S+)\)")


def to_write(error: NoInputError, arguments: Sequence[str], command: Any) -> str:
    """Return what to do where a word behind command and table is no file but ends as a report."""
    name = error.where
    words = [word for word in arguments if not word.startswith("-")]
    if name not in words[2:] or _exists(name) or Path(name).suffix in _READ_TOO:
        return ""
    return _with_option(name, command)


def as_output(complaint: str, command: Any) -> str:
    """Return likewise what to do where the parser has no place for an argument."""
    found = _EXTRA.search(complaint)
    return _with_option(found[1], command) if found else ""


def as_table(complaint: str) -> str:
    """Return what to do where a file or a folder stands in place of a command."""
    found = _NO_COMMAND.match(complaint)
    there = found is not None and _exists(found[1])
    return f"to analyze it: scara-iso analyze {shlex.quote(found[1])}" if found and there else ""


def _with_option(name: str, command: Any) -> str:
    writes = any("-o" in param.opts for param in getattr(command, "params", ()))
    known = Path(name).suffix.lower() in (*endings(), ".dfq")
    return f"did you mean -o {name}?" if writes and known else ""


def _exists(name: str) -> bool:
    """Say whether a file is there; a name that is too long is none."""
    return os.path.exists(name)  # noqa: PTH110
