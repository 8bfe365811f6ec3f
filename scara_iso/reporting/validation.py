"""The record of a validation: verdict, what differs, every reference, versions, a signature."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from scara_iso.base.display import Displayed
from scara_iso.base.published import publish
from scara_iso.reporting.blocks import (
    Block,
    Document,
    Facts,
    Number,
    Report,
    Section,
    Signature,
    Table,
    Text,
)


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


_SCOPE = (
    "What is compared is this program on this machine with references that were made or certified "
    "elsewhere and came with it. It says nothing of the indicators, the bench and the people."
)
_WORDING = {
    "paper": "the paper's Table I and first joint",
    "NIST StRD": "NIST's certified sets",
    "units": "units and displays",
    "characteristics": "every characteristic, summed up elsewhere",
    "procedure": "which cycles count, and limits",
    "streams": "recorded streams of the dialects",
    "diagnosis": "scatter alone, and known effects",
    "recorder": "a recorder that is killed",
}


def validation_document(found: Validation) -> Document:
    """Return the record to sign."""
    title = f"Validation of scara-iso {found.installation.program}"
    end = Section("", (Text(f"End of {title}", "quiet"),))
    return Document(title, (*validation_report(found), end))


def validation_report(found: Validation) -> Report:
    """Return the whole record: the answer with what differs, then every reference."""
    groups = {g: [check for check in found.checks if check.group == g] for g in _groups(found)}
    return (
        Section("", tuple(_answer(found))),
        Section("", (Text(_SCOPE, "quiet"), *_machine(found), _SIGNATURE), depth="detail"),
        *(
            Section(_WORDING.get(group, group), (_checks(checks),), depth="detail")
            for group, checks in groups.items()
        ),
    )


_SIGNATURE = Signature(("place, date", "validated by: name, signature"))


def _groups(found: Validation) -> list[str]:
    return list(dict.fromkeys(check.group for check in found.checks))


def _answer(found: Validation) -> Iterator[Block]:
    bad = found.differing
    if found.verdict == "pass":
        yield Text(f"PASS: all {len(found.checks)} references are met", "good")
    else:
        yield Text(f"FAIL: {len(bad)} of {len(found.checks)} references are not met", "bad")
    yield Table(
        ("references", "compared", "met"),
        tuple(
            (_WORDING.get(group, group), Number(len(checks)), Number(sum(c.passed for c in checks)))
            for group, checks in (
                (group, [c for c in found.checks if c.group == group]) for group in _groups(found)
            )
        ),
    )
    for check in bad:
        yield Text(
            f"{check.group}, {check.name}: {check.obtained} instead of {check.expected}"
            f"{f' within {check.tolerance:.1g}' if check.tolerance else ''}",
            "bad",
        )
    if bad:
        text = "do not use it for figures that are signed: install it anew, then report this"
        yield Text(text, "warn")


def _machine(found: Validation) -> Iterator[Block]:
    on = found.installation
    rows = [("program", f"scara-iso {on.program}"), ("machine", on.platform)]
    rows += [(f"SHA-256 of the {name}", digest) for name, digest in on.hashes.items()]
    yield Facts(tuple(rows), "what was validated")
    yield Facts(tuple(on.versions.items()), "versions")


def _checks(checks: Sequence[ReferenceCheck]) -> Table:
    return Table(
        ("what", "expected", "obtained", "within", "verdict", "source"),
        tuple(
            (
                check.name,
                _value(check.expected),
                _value(check.obtained),
                Number(check.tolerance, ".1e") if check.tolerance else "equal",
                "met" if check.passed else "NOT MET",
                check.source,
            )
            for check in checks
        ),
    )


def _value(found: float | str) -> Number | str:
    return found if isinstance(found, str) else Number(found, ".10g")
