"""`selftest`: whether this program gives the references, on this machine."""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from hashlib import sha256
from importlib.metadata import requires, version
from pathlib import Path
from typing import TypeAlias

from scara_iso import __version__, reporting
from scara_iso.commands import output as out, references
from scara_iso.commands.options import Asked, option, takes_options_of
from scara_iso.commands.output import Answer
from scara_iso.reporting import Installation, ReferenceCheck, Validation, validation_document

Group: TypeAlias = Callable[[], Iterable[ReferenceCheck]]
GROUPS: Mapping[str, Group] = {
    "paper": references.paper_checks,
    "NIST StRD": references.nist_checks,
    "units": references.unit_checks,
    "characteristics": references.vector_checks,
    "procedure": references.rule_checks,
    "streams": references.stream_checks,
    "diagnosis": references.diagnosis_checks,
    "recorder": references.recorder_checks,
}


def validate(groups: Mapping[str, Group] = GROUPS) -> Iterator[ReferenceCheck]:
    """Yield every check of every group; an error ends its group and is itself a failed check."""
    for group, checks in groups.items():
        try:
            yield from checks()
        except Exception as error:  # noqa: BLE001 - whatever it is, the reference is not met
            text = f"{type(error).__name__}: {error}"
            yield ReferenceCheck(group, "the rest of this group", "", "no error", text)


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
        out.check_outputs([], [], pages=[Path(to)])
    checks = []
    for check in validate():
        checks.append(check)
        if tell is not None:
            tell(check)
    found = Validation(checks=tuple(checks), installation=_installation())
    if to is not None:
        out.write_page(validation_document(found), Path(to))
    return found


def _installation() -> Installation:
    needed = (re.match(r"[\w-]+", one) for one in requires("scara-iso") or () if "extra" not in one)
    packages = sorted(found[0] for found in needed if found)
    return Installation(
        program=__version__,
        versions={"Python": platform.python_version()} | {n: version(n) for n in packages},
        platform=f"{platform.platform()} {platform.machine()}, {sys.implementation.name}",
        hashes={"program": _digest(".py"), "references": _digest("", "commands", "data")},
    )


def _digest(ending: str, *folder: str) -> str:
    """Return one SHA-256 of the names and bytes of the package's files with this ending."""
    root, total = Path(__file__).parents[1].joinpath(*folder), sha256()
    for path in sorted(path for path in root.rglob(f"*{ending}") if path.is_file()):
        data = path.read_bytes()
        total.update(f"{path.relative_to(root).as_posix()}\0{len(data)}\0".encode() + data)
    return total.hexdigest()


@takes_options_of(
    selftest,
    "full",
    "json",
    to=option(
        "Record to sign, by its ending: .html .md .csv .xlsx .pdf.", "--report", kind=Path | None
    ),
)
def selftest_command(asked: Asked[Validation]) -> Answer:
    """Compare this installation with references: exit 0, or 1 naming what differs.

    For the record that ISO/IEC 17025 7.11.2 asks for before software is used.

    Example: scara-iso selftest --report validation.html
    """
    found = asked.result()
    code = 0 if found.verdict == "pass" else out.NOT_WITHIN_LIMITS
    return Answer(found, partial(reporting.validation_report, found), asked["to"], code=code)
