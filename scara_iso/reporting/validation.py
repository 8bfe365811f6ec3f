"""The record of a validation: verdict, what differs, every reference, versions, a signature."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scara_iso.reporting.blocks import Block, Facts, Number, Report, Section, Signature, Table, Text
from scara_iso.reporting.dossier import Document
from scara_iso.validation import ReferenceCheck, Validation

_SCOPE = (
    "What is compared is this program on this machine with references that were made or certified "
    "elsewhere and came with it. It says nothing of the indicators, the bench and the people."
)
_SAID = {
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
    """Return the whole record."""
    return (
        Section("", (*_answer(found), Text(_SCOPE, "quiet"), *_machine(found), _SIGNATURE)),
        *(
            Section(heading, (_checks(checks),))
            for heading, checks in (
                (_SAID.get(group, group), [c for c in found.checks if c.group == group])
                for group in _groups(found)
            )
        ),
    )


def validation_brief(found: Validation) -> Report:
    """Return the answer, and what differs."""
    return (Section("", tuple(_answer(found))),)


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
            (_SAID.get(group, group), Number(len(checks)), Number(sum(c.passed for c in checks)))
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
        said = "do not use it for figures that are signed: install it anew, then report this"
        yield Text(said, "warn")


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
