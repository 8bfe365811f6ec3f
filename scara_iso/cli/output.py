"""How every command writes: one JSON line, or a report on the terminal."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scara_iso.errors import CannotCreateError, WriteError

if TYPE_CHECKING:
    from scara_iso.report.blocks import Report


@dataclass(slots=True)
class Settings:
    """The general options of one call of the program."""

    debug: bool = False
    no_color: bool = False
    arguments: tuple[str, ...] = ()


settings = Settings()
_BESIDE_A_RECORDING = {".html", ".md", ".xlsx", ".json", ".pdf"}
"""Endings of a report, which is no table: it may bear a recording's name."""


def write_json(document: Mapping[str, Any]) -> None:
    """Write one JSON object on a line of standard output."""
    from scara_iso.render.json import to_text

    sys.stdout.write(f"{to_text(document)}\n")


def write_report(report: Report) -> None:
    """Write a report on standard output."""
    from scara_iso.render.terminal import open_console, show

    show(report, open_console(sys.stdout, no_color=settings.no_color))


def write_text(text: str, path: Path | None) -> None:
    """Write ``text`` to a file, or to standard output where there is none.

    A terminal is shown what it should not obey.
    """
    from scara_iso.report.words import printable

    if path is None and sys.stdout.isatty():
        sys.stdout.write("\n".join(map(printable, text.split("\n"))))
    elif path is None:
        sys.stdout.write(text)
    else:
        write_bytes(text.encode("utf-8", "backslashreplace"), path)


def _of_a_recording(path: Path) -> bool:
    """Say whether writing here would replace a recording's table, raw file or manifest."""
    if path.name.endswith((".raw.jsonl", ".manifest.json")):
        return path.exists()
    return (
        path.suffix.lower() not in _BESIDE_A_RECORDING and path.with_suffix(".raw.jsonl").exists()
    )


def write_bytes(content: bytes, path: Path) -> None:
    """Write a file; `CannotCreateError` where it cannot be, `WriteError` where that fails."""
    if _of_a_recording(path):
        raise CannotCreateError(
            "holds a recording", where=str(path), remedy="name another file, or remove it yourself"
        )
    try:
        file = path.open("wb")
    except OSError as error:
        raise CannotCreateError(
            f"cannot be written: {error.strerror}", where=str(path), remedy="name another place"
        ) from error
    try:
        with file:
            file.write(content)
    except OSError as error:
        raise WriteError(f"cannot be written: {error.strerror}", where=str(path)) from error
