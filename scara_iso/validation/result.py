"""What a validation yields: each reference beside what this program makes of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from scara_iso.base.display import Displayed


@dataclass(frozen=True, slots=True)
class ReferenceCheck:
    """One reference and what was obtained in its place."""

    group: str
    """``NIST StRD``, ``streams`` and so on."""
    name: str
    """What is compared."""
    source: str
    """Where the reference is from."""
    expected: float | str
    """The reference."""
    obtained: float | str
    """What this program gives."""
    tolerance: float = 0.0
    """Of a number: how far apart both may lie, in its unit; 0 demands equality."""

    @property
    def passed(self) -> bool:
        """Whether the reference is met."""
        if isinstance(self.expected, str) or isinstance(self.obtained, str):
            return self.expected == self.obtained
        apart = abs(self.obtained - self.expected)
        return math.isfinite(self.obtained) and apart <= self.tolerance


@dataclass(frozen=True, slots=True)
class Installation:
    """What was validated, and on what: versions and SHA-256 sums."""

    program: str
    """Version of this program."""
    versions: Mapping[str, str]
    """Of Python and of each package, by name; ``not installed`` where it is not there."""
    platform: str
    """Operating system and processor."""
    hashes: Mapping[str, str]
    """SHA-256 of the program's files and of the references, by name."""


@dataclass(frozen=True, slots=True)
class Validation(Displayed):
    """Every reference check, and on what machine it was made."""

    checks: tuple[ReferenceCheck, ...]
    """In the order in which they were made."""
    installation: Installation
    """What was validated, and on what."""

    def __repr__(self) -> str:
        return f"<Validation: {self.verdict}, {len(self.checks)} references>"

    @property
    def differing(self) -> tuple[ReferenceCheck, ...]:
        """The references that are not met."""
        return tuple(check for check in self.checks if not check.passed)

    @property
    def verdict(self) -> str:
        """``pass`` where every reference is met, else ``fail``."""
        return "fail" if self.differing or not self.checks else "pass"
