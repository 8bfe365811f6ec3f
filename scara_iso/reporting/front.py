"""Page 1 of a report: it decides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import Analysis, Finding
from scara_iso.reporting.analysis import as_deviation, cycles_said, force_loop, is_force_loop
from scara_iso.reporting.blocks import Block, Signature, Text
from scara_iso.reporting.digits import words
from scara_iso.reporting.limits import GRAVER, RULES, conformity
from scara_iso.reporting.named_effects import Failure, diagnosis_in_words
from scara_iso.reporting.result_table import ResultPart, result_tables
from scara_iso.reporting.stated import method, not_stated, parties, stated_field

SCOPE = (
    "The results relate only to the item tested (ISO/IEC 17025:2017, 7.8.2.1 l). The report is "
    "copied in full only, unless the laboratory agrees."
)
_MOST_LINES = 8
_MOST_MISSING = 4
_MOST_NAMED = 4


@dataclass(frozen=True, slots=True)
class Amendment:
    """Which report this one replaces, and why (ISO/IEC 17025:2017, 7.8.8)."""

    supersedes: str
    """Number of the report that it stands in place of."""
    reason: str
    """Why it does."""


def front_page(
    analysis: Analysis,
    diagnoses: Mapping[str | None, Diagnosis | Failure],
    amendment: Amendment | None,
    parts: Sequence[ResultPart] = (),
) -> Iterator[Block]:
    """Yield who tested what for whom, the result, the rule, what deviates, what was found.

    ``parts`` are the results by condition, where there are several.
    """
    run = analysis.run
    yield Text(_subject(analysis), "strong")
    if run.metadata.get("simulated"):
        yield Text(
            f"SIMULATED readings ({run.metadata['simulated']}): no robot was measured", "bad"
        )
    if amendment is not None:
        yield Text(
            f"This report supersedes report {amendment.supersedes}. Reason: {amendment.reason}",
            "strong",
        )
    yield from (facts for facts in parties(run) if facts.rows)
    yield from force_loop(analysis)
    yield from conformity(analysis)
    labels = [pose.label for pose in analysis.poses]
    yield from result_tables(parts or [ResultPart(analysis.characteristics, labels)])
    yield Text(_rule(analysis))
    yield Text(f"Method: {method(run)}. {cycles_said(analysis)}")
    yield from _deviations(analysis)
    yield from _remarks(analysis)
    yield from _found(diagnoses)
    yield from _missing(not_stated(run))
    yield Text(SCOPE, "quiet")
    authorized = stated_field(run, "authorized by")
    name = f"name, signature: {authorized}" if authorized else "name, signature"
    yield Signature(("place, date", name))


def _missing(names: Sequence[str]) -> Iterator[Text]:
    """Yield what nobody stated, of many the first."""
    if not names:
        return
    more = len(names) - _MOST_MISSING
    rest = f" and {more} more, under Conditions and instruments" if more > 1 else ""
    named = ", ".join(names[: _MOST_MISSING if rest else None])
    yield Text(f"Not stated: {named}{rest}.", "quiet")


def _subject(analysis: Analysis) -> str:
    run = analysis.run
    serial = stated_field(run, "serial number")
    item = stated_field(run, "item")
    what = "Static compliance" if is_force_loop(analysis) else "Repeatability"
    if not item:
        return f"{what} by ISO 9283:1998. Robot: not stated{serial and f', serial {serial}'}"
    return f"{what} of {item}{f', serial {serial}' if serial else ''}, by ISO 9283:1998"


def _rule(analysis: Analysis) -> str:
    if not analysis.limits:
        return "No limit was given: nothing is decided."
    planar = any(check.figure == "XY" for check in analysis.limits)
    return RULES[analysis.limits[0].decision] + (f" {GRAVER}" if planar else "")


def _deviations(analysis: Analysis) -> Iterator[Text]:
    """Yield one line for each rule that the test departs from."""
    by_rule: dict[str, list[Finding]] = {}
    for finding in analysis.deviations:
        by_rule.setdefault(finding.rule, []).append(finding)
    if not by_rule:
        return
    yield Text("Deviations:", "strong")
    for rule, found in sorted(by_rule.items())[:_MOST_LINES]:
        said = list(dict.fromkeys(_where(one) + one.message for one in found))
        more = f", and {len(said) - 1} more in the appendix" if len(said) > 1 else ""
        yield Text(f"{as_deviation(said[0], rule)}{more}")
    if len(by_rule) > _MOST_LINES:
        yield Text(f"and {len(by_rule) - _MOST_LINES} more in the appendix")


def _remarks(analysis: Analysis) -> Iterator[Text]:
    """Yield in one line which other warnings there are, by what they are about."""
    by_code: dict[str, list[str]] = {}
    for finding in analysis.findings:
        if finding.severity != "info" and not finding.rule:
            at = " ".join(part for part in (finding.pose, finding.axis) if part)
            by_code.setdefault(finding.code, []).append(at)
    said = [f"{words(code)}{_at(places)}" for code, places in by_code.items()]
    if said:
        yield Text(f"Warnings, explained in the appendix: {'; '.join(said)}.", "warn")


def _at(places: list[str]) -> str:
    named = [place for place in places if place]
    more = f" and {len(named) - _MOST_NAMED} more" if len(named) > _MOST_NAMED else ""
    return f" ({', '.join(named[:_MOST_NAMED])}{more})" if named else ""


def _poses(labels: list[str]) -> str:
    many = len(labels) > _MOST_NAMED
    return f"at {len(labels)} poses" if many else f"at {', '.join(labels)}"


def _where(finding: Finding) -> str:
    at = ", ".join(part for part in (finding.pose, finding.axis) if part)
    return f"{at}: " if at else ""


def _found(diagnoses: Mapping[str | None, Diagnosis | Failure]) -> Iterator[Text]:
    """Yield in one sentence what else than scatter is in the readings: an interpretation."""
    poses: dict[str, list[str]] = {}
    for pose, found in diagnoses.items():
        poses.setdefault(diagnosis_in_words(found), []).append(pose or "")
    if not poses:
        return
    several = len(diagnoses) > 1
    said = [f"{_poses(at)} {what}" if several else what for what, at in poses.items()]
    yield Text(
        f"Interpretation: {'; '.join(said)}. The figures above are the measured ones; nothing was "
        "taken out of them."
    )
