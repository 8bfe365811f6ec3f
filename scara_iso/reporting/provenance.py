"""How a report came to be, so that it can be made again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from scara_iso.origin import Origin
from scara_iso.reporting.blocks import Block, Facts, Text


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file that the report was made of, and the SHA-256 of its bytes in hex."""

    role: str
    """What it is to the report, such as ``table`` or ``model``."""
    name: str
    """Path or name of the file."""
    sha256: Annotated[str, ("pattern", "^[0-9a-f]{64}$")]
    """SHA-256 of its bytes, in hex."""


@dataclass(frozen=True, slots=True)
class Restated:
    """What was stated for the report and not in the table; ``before`` is what it overrides."""

    key: str
    """Name of the field."""
    text: str
    """What it was given."""
    before: str | None
    """What the table stated; null for nothing."""

    def __str__(self) -> str:
        instead = "" if self.before is None else f" (in place of {self.before})"
        return f"{self.key}: {self.text}{instead}"


@dataclass(frozen=True, slots=True)
class Provenance:
    """Files, program and command of a report, and what was stated for it alone."""

    files: tuple[InputFile, ...]
    """What the report was made of."""
    version: str
    """Of this program."""
    command: str
    """The call that made the report."""
    restated: tuple[Restated, ...] = ()
    """Fields that the call stated or overrode."""


def provenance(made: Provenance, origin: Origin) -> Iterator[Block]:
    """Yield what a report is made from, and how its table was understood."""
    rows = [
        row
        for file in made.files
        for row in ((file.role, file.name), (f"SHA-256 of the {file.role}", file.sha256))
    ]
    rows += [("program", f"scara-iso {made.version}"), ("command", made.command)]
    rows += [("stated for the report", str(one)) for one in made.restated]
    if origin.understood:
        rows.append(("the table was read as", origin.understood))
    yield Facts(tuple(rows))
    yield from (Text(note, "quiet") for note in origin.notes)
