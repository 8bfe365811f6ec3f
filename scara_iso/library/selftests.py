"""`selftest`: the references that come with the package, on the machine where it is used."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from scara_iso.base.disk import check_output
from scara_iso.library.killed import recorder_checks
from scara_iso.library.pages import check_page, write_page
from scara_iso.reporting import validation_document
from scara_iso.validation import Installation, ReferenceCheck, Validation, validate

PACKAGES = (
    "jinja2",
    "matplotlib",
    "numpy",
    "openpyxl",
    "pandas",
    "pyserial",
    "python-calamine",
    "rich",
    "scipy",
    "threadpoolctl",
    "tomlkit",
    "typer",
)
"""What the program stands on, as pyproject.toml names it."""


def selftest(
    to: str | Path | None = None, *, tell: Callable[[ReferenceCheck], None] | None = None
) -> Validation:
    """Return what this program makes of references, on this machine (ISO/IEC 17025 7.11.2).

    The paper's table, NIST's certified sets, units, a table with sums made elsewhere for every
    characteristic, the procedure's rules, recorded streams, a sample of scatter and of known
    effects, and a recorder that is killed. ``to`` also writes the record to sign (.html, .md,
    .csv, .xlsx, .pdf); ``tell`` hears each check as it is made. Raises `UsageError` for another
    ending, and as `write_file`.
    """
    if to is not None:
        check_page(Path(to))
        check_output(Path(to))
    checks = []
    for check in _every_check():
        checks.append(check)
        if tell is not None:
            tell(check)
    found = Validation(tuple(checks), _installation())
    if to is not None:
        write_page(validation_document(found), Path(to))
    return found


def _every_check() -> Iterator[ReferenceCheck]:
    yield from validate()
    yield from validate({"recorder": recorder_checks})


def _installation() -> Installation:
    from scara_iso import __version__

    return Installation(
        program=__version__,
        versions={"Python": platform.python_version(), **{n: _version(n) for n in PACKAGES}},
        platform=f"{platform.platform()} {platform.machine()}, {sys.implementation.name}",
        hashes={
            "program": _digest(".py"),
            "references": _digest("", "validation", "data"),
        },
    )


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


@dataclass(frozen=True, slots=True)
class _File:
    path: str
    data: bytes


def _digest(ending: str, *folder: str) -> str:
    """Return one SHA-256 of the names and bytes of the package's files with this ending."""
    total = sha256()
    for file in _files(files("scara_iso").joinpath(*folder), ""):
        if file.path.endswith(ending):
            total.update(f"{file.path}\0{len(file.data)}\0".encode() + file.data)
    return total.hexdigest()


def _files(folder: Traversable, above: str) -> Iterator[_File]:
    for one in sorted(folder.iterdir(), key=lambda found: found.name):
        if one.is_dir() and one.name != "__pycache__":
            yield from _files(one, f"{above}{one.name}/")
        elif one.is_file():
            yield _File(f"{above}{one.name}", one.read_bytes())
