"""What ``selftest`` publishes of a validation: schema ``scara-iso/selftest/1``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from scara_iso.base.published import publish
from scara_iso.validation.result import ReferenceCheck, Validation


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedCheck:
    """One reference and what was obtained in its place."""

    group: str
    """`NIST StRD`, `streams` and so on."""
    name: str
    """What is compared."""
    source: str
    """Where the reference is from."""
    expected: float | str
    """The reference."""
    obtained: float | str
    """What this program gives; `nan` and `inf` as text."""
    tolerance: float
    """Of a number: how far apart both may lie, in its unit; 0 demands equality."""
    passed: bool
    """Whether the reference is met."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferingCheck:
    """A reference that is not met."""

    group: str
    """`NIST StRD`, `streams` and so on."""
    name: str
    """What is compared."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedHashes:
    """SHA-256 of the files."""

    program: str
    """Of the program's."""
    references: str
    """Of the references'."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedValidation:
    """``selftest`` of this installation."""

    schema: Literal["scara-iso/selftest/1"]
    """Name and number of this schema."""
    verdict: Literal["pass", "fail"]
    """Whether every reference is met; the exit code is 0 or 1."""
    checks: tuple[PublishedCheck, ...]
    """In the order in which they were made."""
    differing: tuple[DifferingCheck, ...]
    """The references that are not met."""
    program: str
    """Version of this program."""
    versions: Mapping[str, str]
    """Of Python and of each package, by name; `not installed` where it is not there."""
    platform: str
    """Operating system and processor."""
    hashes: PublishedHashes
    """Of what was validated, and by what."""


def published_validation(found: Validation) -> PublishedValidation:
    """Return what ``selftest`` says."""
    return publish(
        PublishedValidation,
        found.installation,
        schema="scara-iso/selftest/1",
        verdict=found.verdict,
        checks=tuple(map(_check, found.checks)),
        differing=tuple(publish(DifferingCheck, one) for one in found.differing),
        hashes=PublishedHashes(**found.installation.hashes),
    )


def _check(found: ReferenceCheck) -> PublishedCheck:
    obtained = found.obtained
    if isinstance(obtained, float) and not math.isfinite(obtained):
        obtained = str(obtained)
    return publish(PublishedCheck, found, obtained=obtained)
