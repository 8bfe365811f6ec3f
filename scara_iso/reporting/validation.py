"""The record of a validation: verdict, what differs, every reference, versions, a signature."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

from scara_iso.base.displayed import Displayed
from scara_iso.base.published import MERGED, fill, publish, published
from scara_iso.reporting.shared.blocks import (
    Block,
    Columns,
    Document,
    Facts,
    Report,
    Section,
    Signature,
    Table,
    Text,
    ended,
    note,
)
from scara_iso.reporting.shared.digits import Number


def _finite(obtained: float | str) -> float | str:
    is_number = isinstance(obtained, str) or math.isfinite(obtained)
    return obtained if is_number else str(obtained)


@dataclass(frozen=True, slots=True)
class ReferenceCheck:
    """One reference and what was obtained in its place."""

    group: str
    """`NIST StRD`, `streams` and so on."""
    name: str
    """What is compared."""
    source: str
    """Where the reference is from."""
    expected: float | str
    """The reference."""
    obtained: float | str = field(metadata=published(by=_finite))
    """What this program gives; `nan` and `inf` as text."""
    tolerance: float = 0.0
    """Of a number: how far apart both may lie, in its unit; 0 demands equality."""
    passed: bool = field(init=False)
    """Whether the reference is met."""

    def __post_init__(self) -> None:
        fill(self, passed=self._is_met())

    def _is_met(self) -> bool:
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
    """Of Python and of each package, by name; `not installed` where it is not there."""
    platform: str
    """Operating system and processor."""
    hashes: Mapping[Annotated[str, ("enum", ("program", "references"))], str]
    """SHA-256 of the program's files and of the references."""


@dataclass(frozen=True, slots=True)
class DifferingCheck:
    """A reference that is not met."""

    group: str
    """`NIST StRD`, `streams` and so on."""
    name: str
    """What is compared."""


def _named(checks: Sequence[ReferenceCheck]) -> tuple[DifferingCheck, ...]:
    return tuple(publish(DifferingCheck, one) for one in checks)


@dataclass(frozen=True, kw_only=True)
class Validation(Displayed):
    """``selftest`` of this installation."""

    schema: Literal["scara-iso/selftest/1"] = "scara-iso/selftest/1"
    """Name and number of this schema."""
    checks: tuple[ReferenceCheck, ...]
    """In the order in which they were made."""
    installation: Installation = field(metadata=MERGED)
    """What was validated, and on what."""
    differing: tuple[ReferenceCheck, ...] = field(init=False, metadata=published(by=_named))
    """The references that are not met."""
    verdict: Literal["pass", "fail"] = field(init=False)
    """Whether every reference is met; the exit code is 0 or 1."""

    def __post_init__(self) -> None:
        differing = tuple(check for check in self.checks if not check.passed)
        verdict = "fail" if differing or not self.checks else "pass"
        fill(self, differing=differing, verdict=verdict)

    def __repr__(self) -> str:
        return f"<Validation: {self.verdict}, {len(self.checks)} references>"


_WORDING = {
    "paper": "the paper's Table I and first joint",
    "NIST StRD": "NIST's certified sets",
    "units": "units and displays",
    "characteristics": "every characteristic, summed up elsewhere",
    "procedure": "which cycles count, and limits",
    "streams": "recorded streams of indicators",
    "diagnosis": "scatter alone, and known effects",
    "recorder": "a recorder that is killed",
}


def validation_document(found: Validation) -> Document:
    """Return the record to sign."""
    title = f"Validation of scara-iso {found.installation.program}"
    return Document(title, ended(validation_report(found), title))


def validation_report(found: Validation) -> Report:
    """Return the whole record: the answer with what differs, then every reference."""
    groups: dict[str, list[ReferenceCheck]] = {}
    for check in found.checks:
        groups.setdefault(_WORDING.get(check.group, check.group), []).append(check)
    columns: Columns[tuple[str, list[ReferenceCheck]]] = {
        "references": lambda row: row[0],
        "compared": lambda row: len(row[1]),
        "met": lambda row: sum(one.passed for one in row[1]),
    }
    on = found.installation
    hashes = [(f"SHA-256 of the {name}", digest) for name, digest in on.hashes.items()]
    machine = (("program", f"scara-iso {on.program}"), ("machine", on.platform), *hashes)
    validated = (
        Text(note("validation"), "quiet"),
        Facts(machine, "what was validated"),
        Facts(tuple(on.versions.items()), "versions"),
        Signature(("place, date", "validated by: name, signature")),
    )
    verdict, *differing = _answer(found)
    return (
        Section("", (verdict, Table.of(groups.items(), columns), *differing)),
        Section("", validated, depth="detail"),
        *(Section(name, (_checks(checks),), depth="detail") for name, checks in groups.items()),
    )


def _answer(found: Validation) -> Iterator[Block]:
    count, bad = len(found.checks), found.differing
    if found.verdict == "pass":
        yield Text(f"PASS: all {count} references are met", "good")
    else:
        yield Text(f"FAIL: {len(bad)} of {count} references are not met", "bad")
    for check in bad:
        within = f" within {check.tolerance:.1g}" if check.tolerance else ""
        instead = f"{check.obtained} instead of {check.expected}{within}"
        yield Text(f"{check.group}, {check.name}: {instead}", "bad")
    text = "Do not sign figures of this installation: install the program again, then report this"
    yield Text(text if bad else "", "warn")


def _checks(checks: Sequence[ReferenceCheck]) -> Table:
    columns: Columns[ReferenceCheck] = {
        "what": lambda one: one.name,
        "expected": lambda one: _value(one.expected),
        "obtained": lambda one: _value(one.obtained),
        "within": lambda one: Number(one.tolerance, ".1e") if one.tolerance else "equal",
        "verdict": lambda one: "met" if one.passed else "NOT MET",
        "source": lambda one: one.source,
    }
    return Table.of(checks, columns)


def _value(found: float | str) -> Number | str:
    return found if isinstance(found, str) else Number(found, ".10g")
