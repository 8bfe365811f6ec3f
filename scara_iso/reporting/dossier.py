"""The test report on paper: page 1 decides, figures and diagnosis follow, then all else.

The dossier is everything that is known of a test, and what ``report`` publishes of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, cast

from scara_iso.base.published import ALWAYS, INTERNAL, MERGED, fill, published
from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import (
    Analysis,
    Characteristic,
    Finding,
    OtherTests,
    PoseResult,
    not_measured,
    poses_in_cycles,
)
from scara_iso.reporting.analysis import (
    FORCE_LOOP,
    as_deviation,
    cycles_in_words,
    findings,
    is_force_loop,
    subject_of,
)
from scara_iso.reporting.appendix import appendix, at_pose, of_part, other_readings
from scara_iso.reporting.backlash import backlash_report
from scara_iso.reporting.blocks import Block, Document, Section, Signature, Text
from scara_iso.reporting.diagnosis import diagnosis_report
from scara_iso.reporting.digits import words
from scara_iso.reporting.figures import (
    UncertaintyLine,
    budget_blocks,
    largest_of,
    uncertainty_budget,
)
from scara_iso.reporting.languages import ENGLISH, in_parts, labels_of, translated
from scara_iso.reporting.limits import RULES, ResultPart, conformity, result_tables
from scara_iso.reporting.named_effects import Failure, diagnosis_in_words, interpretation
from scara_iso.reporting.pictures import (
    courses,
    drift_pictures,
    planes,
    predictions,
    push_picture,
)
from scara_iso.reporting.signals import BOUGHT_BY, push_report
from scara_iso.reporting.stated import (
    Amendment,
    InputFile,
    Provenance,
    PublishedReadings,
    StatedField,
    conditions,
    head,
    method,
    not_stated,
    parties,
    provenance,
    published_readings,
    remarks,
    stated_field,
)
from scara_iso.robot import Backlash, Gearbox

SCOPE = (
    "The results relate only to the item tested (ISO/IEC 17025:2017, 7.8.2.1 l). The report is "
    "copied in full only, unless the laboratory agrees."
)
_MOST_LINES = 8
_MOST_MISSING = 4
_MOST_NAMED = 4
Diagnoses = Mapping[str | None, Diagnosis | Failure]
"""By pose."""
Gearboxes = Mapping[int, tuple[Gearbox, float | None]]
"""By the number of the joint, with the reach from it to the tool [m] where it is known."""


@dataclass(frozen=True, kw_only=True)
class AtPose:
    """Where a diagnosis is of."""

    pose: str | None
    """Its name; null for the only one."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DiagnosedPose(AtPose):
    """``diagnose`` of one pose of a report."""

    diagnosis: Diagnosis = field(metadata=MERGED)


@dataclass(frozen=True, kw_only=True)
class UndiagnosedPose(AtPose):
    """A pose that could not be diagnosed."""

    error: str
    """Why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BacklashAtJoint:
    """``backlash`` of one joint of the model."""

    joint: Literal[1, 2]
    """Number of the joint."""
    backlash: Backlash = field(metadata=MERGED)


def _by_pose(diagnoses: Diagnoses) -> tuple[DiagnosedPose | UndiagnosedPose, ...]:
    return tuple(
        UndiagnosedPose(pose=pose, error=found.message)
        if isinstance(found, Failure)
        else DiagnosedPose(pose=pose, diagnosis=found)
        for pose, found in diagnoses.items()
    )


def _by_joint(gearboxes: Gearboxes) -> tuple[BacklashAtJoint, ...]:
    return tuple(
        BacklashAtJoint(joint=cast(Literal[1, 2], joint), backlash=gearbox.backlash(arm))
        for joint, (gearbox, arm) in gearboxes.items()
    )


@dataclass(frozen=True, slots=True)
class Dossier:
    """Everything that is known of a test: ``report`` of a table."""

    analysis: Analysis
    """As in `analyze`."""
    provenance: Provenance = field(metadata=MERGED)
    """What the report was made of, and by which command."""
    diagnoses: Diagnoses = field(default_factory=dict, metadata=published(by=_by_pose))
    """As in `diagnose`, by pose."""
    gearboxes: Gearboxes = field(default_factory=dict, metadata=published("backlash", by=_by_joint))
    """As in `backlash`, by joint of the model."""
    amendment: Amendment | None = field(default=None, metadata=ALWAYS)
    """Which report it replaces; null where none."""
    parts: tuple[ResultPart, ...] = field(default=(), metadata=INTERNAL)
    """The results by condition, where there are several; a pose is then called by its part."""
    other_tests: OtherTests = field(default_factory=OtherTests, metadata=INTERNAL)
    """The tests beside the poses; their figures and findings are in `analysis` too."""
    language: str = field(default=ENGLISH, metadata=INTERNAL)
    """Of the labels: one of `known_languages`."""
    schema: Literal["scara-iso/report/1"] = field(default="scara-iso/report/1", init=False)
    """Name and number of this schema."""
    head: tuple[StatedField, ...] = field(init=False, repr=False)
    """The fields of docs/report.md."""
    uncertainty: tuple[UncertaintyLine, ...] = field(init=False, repr=False)
    """Budget of a reading, by axis."""
    readings: PublishedReadings = field(init=False, repr=False, compare=False)
    """As they were read."""

    def __post_init__(self) -> None:
        run, rows = self.analysis.run, head(self.analysis.run, self.analysis.cycles).rows
        fill(
            self,
            head=tuple(StatedField(name, text) for name, text in rows),
            uncertainty=uncertainty_budget(self.analysis),
            readings=published_readings(run),
        )

    def with_other_tests(self, other_tests: OtherTests, files: Sequence[InputFile] = ()) -> Dossier:
        """Return it with the tests beside the poses, read from ``files`` more."""
        if not other_tests:
            return self
        labels = [pose.label for pose in self.analysis.poses]
        parts = self.parts or (ResultPart(self.analysis.characteristics, labels),)
        read = replace(self.provenance, files=(*self.provenance.files, *files))
        return replace(
            self,
            analysis=other_tests.added_to(self.analysis),
            provenance=read,
            parts=(*parts, ResultPart(_in_short(other_tests), ())),
            other_tests=other_tests,
        )


def _in_short(other_tests: OtherTests) -> tuple[Characteristic, ...]:
    """Return what belongs on page 1: what is held against a limit, and the figures of the whole."""
    drift = [] if other_tests.drift is None else list(other_tests.drift.characteristics)
    shown = [largest_of(drift, code) for code in dict.fromkeys(one.code for one in drift)]
    pushed = [one for one in other_tests.characteristics if one not in drift]
    of_joints = any(not one.of.endswith("reading") for one in pushed)
    shown += [
        one
        for one in pushed
        if one.code in BOUGHT_BY and not (of_joints and one.of.endswith("reading"))
    ]
    return tuple(
        one for one in other_tests.characteristics if one in shown or one.limit is not None
    )


def front_page(dossier: Dossier) -> Iterator[Block]:
    """Yield who tested what for whom, the result, the rule, what deviates, what was found."""
    analysis, amendment, run = dossier.analysis, dossier.amendment, dossier.analysis.run
    yield Text(_subject(analysis), "strong")
    simulated = run.metadata.get("simulated")
    measured = f"SIMULATED readings ({simulated}): no robot was measured"
    yield Text(measured if simulated else "", "bad")
    if amendment is not None:
        superseded = f"This report supersedes report {amendment.supersedes}."
        yield Text(f"{superseded} Reason: {amendment.reason}", "strong")
    yield from parties(run)
    loop = f"{FORCE_LOOP}: RP counts what the force moves"
    yield Text(loop if is_force_loop(analysis) else "", "bad")
    yield from conformity(analysis)
    labels = [pose.label for pose in analysis.poses]
    parts = dossier.parts or [ResultPart(analysis.characteristics, labels)]
    yield from result_tables(parts)
    decision = analysis.limits[0].decision if analysis.limits else None
    yield Text(RULES[decision] if decision else "No limit was given: nothing is decided.")
    yield Text(f"Method: {method(run)}. {cycles_in_words(analysis)}")
    yield from _deviations(analysis)
    yield Text(_remarks(analysis), "warn")
    yield Text(_found(dossier.diagnoses))
    yield Text(_missing(not_stated(run)), "quiet")
    yield Text(SCOPE, "quiet")
    authorized = stated_field(run, "authorized by")
    name = f"name, signature: {authorized}" if authorized else "name, signature"
    yield Signature(("place, date", name))


def _missing(names: Sequence[str]) -> str:
    """Return what nobody stated, of many the first."""
    more = len(names) - _MOST_MISSING
    rest = f" and {more} more, under Conditions and instruments" if more > 1 else ""
    named = ", ".join(names[: _MOST_MISSING if rest else None])
    return f"Not stated: {named}{rest}." if names else ""


def _subject(analysis: Analysis) -> str:
    serial = stated_field(analysis.run, "serial number")
    item, of = stated_field(analysis.run, "item"), f", serial {serial}" if serial else ""
    what = "Static compliance" if is_force_loop(analysis) else "Repeatability"
    if not item:
        return f"{what} by ISO 9283:1998. Robot: not stated{of}"
    return f"{what} of {item}{of}, by ISO 9283:1998"


def _deviations(analysis: Analysis) -> Iterator[Text]:
    """Yield one line for each rule that the test departs from."""
    by_rule: dict[str, list[Finding]] = {}
    for finding in analysis.deviations:
        by_rule.setdefault(finding.rule, []).append(finding)
    yield Text("Deviations:" if by_rule else "", "strong")
    for rule, found in sorted(by_rule.items())[:_MOST_LINES]:
        text = list(dict.fromkeys(subject_of(one) + one.message for one in found))
        more = f", and {len(text) - 1} more in the appendix" if len(text) > 1 else ""
        yield Text(f"{as_deviation(text[0], rule)}{more}")
    left = len(by_rule) - _MOST_LINES
    yield Text(f"and {left} more in the appendix" if left > 0 else "")


def _remarks(analysis: Analysis) -> str:
    """Return in one line which other warnings there are, by what they are about."""
    by_code: dict[str, list[str]] = {}
    for one in analysis.findings:
        if one.severity != "info" and not one.rule:
            places = by_code.setdefault(one.code, [])
            places += filter(None, [" ".join(part for part in (one.pose, one.axis) if part)])
    parts = [f"{words(code)}{_at(places)}" for code, places in by_code.items()]
    return f"Warnings, explained in the appendix: {'; '.join(parts)}." if parts else ""


def _at(places: Sequence[str]) -> str:
    more = f" and {len(places) - _MOST_NAMED} more" if len(places) > _MOST_NAMED else ""
    return f" ({', '.join(places[:_MOST_NAMED])}{more})" if places else ""


def _found(diagnoses: Diagnoses) -> str:
    """Return in one sentence what else than scatter is in the readings: an interpretation."""
    poses: dict[str, list[str]] = {}
    for pose, found in diagnoses.items():
        poses.setdefault(diagnosis_in_words(found), []).append(pose or "")
    parts = []
    for what, at in poses.items():
        named = ", ".join(at) if len(at) <= _MOST_NAMED else f"{len(at)} poses"
        parts.append(f"at {named} {what}" if len(diagnoses) > 1 else what)
    measured = "The figures above are the measured ones; nothing was taken out of them."
    return f"Interpretation: {'; '.join(parts)}. {measured}" if parts else ""


def document(dossier: Dossier) -> Document:
    """Return the whole report of a test, its labels in the language of the dossier."""
    run, labels = dossier.analysis.run, labels_of(dossier.language)
    number = stated_field(run, "report number")
    of_readings = f"of the readings {dossier.provenance.files[0].sha256[:8]}"
    title = f"Test report {number or of_readings}"
    sections = (*_sections(dossier), Section("", (Text(f"End of {title}", "quiet"),)))
    return Document(
        in_parts(title, labels),
        tuple(translated(sections, labels)),
        dossier,
        simulated=bool(run.metadata.get("simulated")) or dossier.other_tests.simulated,
        language=dossier.language,
    )


def _sections(dossier: Dossier) -> Iterator[Section]:
    analysis, found, others = dossier.analysis, dossier.diagnoses, dossier.other_tests
    yield Section("", tuple(front_page(dossier)))
    if analysis.block is None:
        yield Section("Figures", (*planes(analysis), *courses(analysis)), new_page=True)
    yield from drift_pictures(analysis)
    yield from () if others.drift is None else drift_pictures(others.drift)
    for name, pushed in others.pushes.items():
        shown = (block for section in push_report(pushed) for block in section.blocks)
        yield Section(of_part("Push test", name), (*shown, push_picture(pushed)))
    if found:
        diagnosed = {pose: d for pose, d in found.items() if isinstance(d, Diagnosis)}
        blocks = (*interpretation(found), *predictions(diagnosed, analysis.poses))
        yield Section("Diagnosis: opinions and interpretations", blocks)
    lacking = ", ".join(not_stated(analysis.run))
    missing = Text(f"Not stated: {lacking}" if lacking else "", "quiet")
    stated = (*conditions(analysis.run, analysis.cycles), missing, *_struck(analysis))
    yield Section("Conditions and instruments", stated)
    yield Section("Uncertainty budget", tuple(budget_blocks(analysis)))
    first, *rest = _appendix(dossier)
    yield replace(first, heading=f"Appendix: {first.heading}", new_page=True)
    yield from rest


def _appendix(dossier: Dossier) -> Iterator[Section]:
    analysis, made = dossier.analysis, dossier.provenance
    for section in findings(analysis, advice=False):
        if section.blocks:
            heading = section.heading[:1].upper() + section.heading[1:]
            yield replace(section, heading=heading)
    yield from appendix(analysis, [*_diagnoses(dossier), *_gears(dossier)])
    yield from other_readings(dossier.other_tests)
    of_the_standard = [one for one in not_measured(analysis) if one.clause[0].isdigit()]
    of_the_standard.sort(key=lambda one: [*map(int, re.findall(r"\d+", one.clause))])
    missing = "; ".join(f"{one.clause} {one.name}" for one in of_the_standard)
    yield Section("Not measured, by clause of ISO 9283:1998", (Text(f"{missing}."),))
    yield Section("Provenance", tuple(provenance(made, analysis.run.origin)))


def _diagnoses(dossier: Dossier) -> Iterator[Section]:
    """Yield the figures of the diagnoses; their words stand before."""
    for pose in poses_in_cycles(dossier.analysis):
        one = dossier.diagnoses.get(pose.label)
        for section in diagnosis_report(one) if isinstance(one, Diagnosis) else ():
            if section.depth == "detail":
                yield Section(at_pose(f"Diagnosis: {section.heading}", pose), section.blocks)


def _gears(dossier: Dossier) -> Iterator[Section]:
    poses: Sequence[PoseResult] = poses_in_cycles(dossier.analysis)
    actual = poses[0] if len(poses) == 1 else None
    for joint, (gearbox, arm) in dossier.gearboxes.items():
        opening, *others = backlash_report(gearbox.backlash(arm), actual)
        reach = (
            "" if arm is None else f"Joint to tool: {arm:g} m, the arm stretched, as in the paper."
        )
        blocks = (*opening.blocks[1:], Text(reach, "quiet"))
        yield Section(f"Backlash of joint {joint}", blocks)
        for section in others:
            named = section.heading and f"Backlash of joint {joint}: {section.heading}"
            yield Section(named, section.blocks)


def _struck(analysis: Analysis) -> Iterator[Block]:
    """Yield what the recording says was struck, with its reasons, and its other remarks."""
    line = remarks(analysis.run)
    struck: Iterable[str] = [text for kind, text in line if kind == "struck"]
    others = [f"{kind}: {text}" for kind, text in line if kind != "struck"]
    headed = {
        "Readings that were struck and taken again:": struck,
        "Remarks of the recording:": others,
    }
    for heading, lines in headed.items():
        if lines:
            yield Text(heading, "strong")
            yield from map(Text, lines)
