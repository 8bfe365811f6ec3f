"""The test report on paper: page 1 decides, figures and diagnosis follow, then all else."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import (
    Analysis,
    Characteristic,
    Finding,
    OtherTests,
    PushResult,
    not_measured,
    poses_in_cycles,
)
from scara_iso.reporting.analysis import (
    as_deviation,
    cycles_in_words,
    findings,
    force_loop,
    is_force_loop,
)
from scara_iso.reporting.appendix import appendix, at_pose, raw_data
from scara_iso.reporting.blocks import (
    Block,
    Document,
    Figure,
    Number,
    Section,
    Signature,
    Table,
    Text,
    words,
)
from scara_iso.reporting.diagnosis import diagnosis_report
from scara_iso.reporting.figure_tables import budget_blocks
from scara_iso.reporting.languages import ENGLISH, in_parts, labels_of, translated
from scara_iso.reporting.limits import RULES, ResultPart, conformity, result_tables
from scara_iso.reporting.named_effects import Failure, diagnosis_in_words, interpretation
from scara_iso.reporting.picture_data import Chart, Curve
from scara_iso.reporting.pictures import courses, drift_pictures, largest_of, planes, predictions
from scara_iso.reporting.signals import BOUGHT_BY, push_report
from scara_iso.reporting.stated import (
    InputFile,
    Provenance,
    conditions,
    method,
    not_stated,
    parties,
    provenance,
    remarks,
    stated_field,
)
from scara_iso.robot import Gearbox
from scara_iso.testfolder import UnderCondition, joined_analysis

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
    yield Text(f"Method: {method(run)}. {cycles_in_words(analysis)}")
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
    return RULES[analysis.limits[0].decision]


def _deviations(analysis: Analysis) -> Iterator[Text]:
    """Yield one line for each rule that the test departs from."""
    by_rule: dict[str, list[Finding]] = {}
    for finding in analysis.deviations:
        by_rule.setdefault(finding.rule, []).append(finding)
    if not by_rule:
        return
    yield Text("Deviations:", "strong")
    for rule, found in sorted(by_rule.items())[:_MOST_LINES]:
        text = list(dict.fromkeys(_where(one) + one.message for one in found))
        more = f", and {len(text) - 1} more in the appendix" if len(text) > 1 else ""
        yield Text(f"{as_deviation(text[0], rule)}{more}")
    if len(by_rule) > _MOST_LINES:
        yield Text(f"and {len(by_rule) - _MOST_LINES} more in the appendix")


def _remarks(analysis: Analysis) -> Iterator[Text]:
    """Yield in one line which other warnings there are, by what they are about."""
    by_code: dict[str, list[str]] = {}
    for finding in analysis.findings:
        if finding.severity != "info" and not finding.rule:
            at = " ".join(part for part in (finding.pose, finding.axis) if part)
            by_code.setdefault(finding.code, []).append(at)
    parts = [f"{words(code)}{_at(places)}" for code, places in by_code.items()]
    if parts:
        yield Text(f"Warnings, explained in the appendix: {'; '.join(parts)}.", "warn")


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
    many = len(diagnoses) > 1
    parts = [f"{_poses(at)} {what}" if many else what for what, at in poses.items()]
    yield Text(
        f"Interpretation: {'; '.join(parts)}. The figures above are the measured ones; nothing was "
        "taken out of them."
    )


def in_short(other_tests: OtherTests) -> tuple[Characteristic, ...]:
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


def other_test_sections(other_tests: OtherTests) -> Iterator[Section]:
    """Yield the course of the drift test, and what each push test came to."""
    if other_tests.drift is not None:
        yield from drift_pictures(other_tests.drift)
    for name, found in other_tests.pushes.items():
        blocks = tuple(block for section in push_report(found) for block in section.blocks)
        yield Section(_titled("Push test", name), (*blocks, _picture(found)))


def _picture(found: PushResult) -> Figure:
    """Return the picture of the loops: what the dial showed over the force."""
    loop = found.loop
    curve = Curve("readings, in their order", loop.force, loop.reading)
    chart = Chart("force [N]", "mm", (curve,), {})
    return Figure(chart, "Loops of the push test", "the width at no force is the hysteresis")


def other_test_readings(other_tests: OtherTests) -> Iterator[Section]:
    """Yield the conditions and every reading of these tests."""
    if (drift := other_tests.drift) is not None:
        checks = tuple(facts for facts in conditions(drift.run, drift.cycles) if facts.rows)
        yield Section("Conditions of the drift test", checks)
        for pose in drift.poses:
            yield Section("Raw data of the drift test", tuple(raw_data(drift, pose)))
    for name, found in other_tests.pushes.items():
        yield Section(_titled("Raw data of the push test", name), (_steps(found),))


def _titled(title: str, name: str) -> str:
    joint = name.partition("-")[2]
    return f"{title} of {joint}" if joint else title


def _steps(found: PushResult) -> Table:
    loop = found.loop
    pairs = zip(loop.force.tolist(), loop.reading.tolist(), strict=True)
    rows = tuple(
        (Number(k), Number(force, ".12g"), Number(reading, ".12g"))
        for k, (force, reading) in enumerate(pairs, 1)
    )
    return Table(("step", "force [N]", "reading [mm]"), rows)


@dataclass(frozen=True, slots=True)
class Dossier:
    """Everything that is known of a test, to be reported.

    ``diagnoses`` by pose; ``gearboxes`` by the number of the joint, with the distance from the
    joint to the tool [m] where the model gives it.
    """

    analysis: Analysis
    """Figures and findings."""
    provenance: Provenance
    """What the report was made of, and by which command."""
    diagnoses: Mapping[str | None, Diagnosis | Failure] = field(default_factory=dict)
    """By pose."""
    gearboxes: Mapping[int, tuple[Gearbox, float | None]] = field(default_factory=dict)
    """By the number of the joint, with the reach from it to the tool [m] where it is known."""
    amendment: Amendment | None = None
    """Which report it replaces."""
    parts: tuple[ResultPart, ...] = ()
    """The results by condition, where there are several; a pose is then called by its part."""
    other_tests: OtherTests = field(default_factory=OtherTests)
    """The tests beside the poses; their figures and findings are in `analysis` too."""
    language: str = ENGLISH
    """Of the labels: one of `known_languages`."""

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
            parts=(*parts, ResultPart(in_short(other_tests), ())),
            other_tests=other_tests,
        )


def document(dossier: Dossier) -> Document:
    """Return the whole report of a test, its labels in the language of the dossier."""
    run, labels = dossier.analysis.run, labels_of(dossier.language)
    title = _title(dossier)
    sections = (*_sections(dossier), Section("", (Text(f"End of {title}", "quiet"),)))
    simulated = bool(run.metadata.get("simulated")) or dossier.other_tests.simulated
    shown = tuple(translated(sections, labels))
    shown_title = in_parts(title, labels)
    return Document(shown_title, shown, dossier, simulated=simulated, language=dossier.language)


def _title(dossier: Dossier) -> str:
    """Return the number of the report, or what identifies it in its place."""
    number = stated_field(dossier.analysis.run, "report number")
    readings = dossier.provenance.files[0].sha256[:8]
    return f"Test report {number}" if number else f"Test report of the readings {readings}"


def _sections(dossier: Dossier) -> Iterator[Section]:
    analysis, found = dossier.analysis, dossier.diagnoses
    yield Section("", tuple(front_page(analysis, found, dossier.amendment, dossier.parts)))
    if analysis.block is None:
        yield Section("Figures", (*planes(analysis), *courses(analysis)), new_page=True)
    yield from drift_pictures(analysis)
    yield from other_test_sections(dossier.other_tests)
    if found:
        diagnosed = {pose: d for pose, d in found.items() if isinstance(d, Diagnosis)}
        pictures = predictions(diagnosed, analysis.poses)
        parts = (*interpretation(found), *pictures)
        yield Section("Diagnosis: opinions and interpretations", parts)
    checks = tuple(facts for facts in conditions(analysis.run, analysis.cycles) if facts.rows)
    lacking = [
        Text(f"Not stated: {', '.join(names)}", "quiet")
        for names in (not_stated(analysis.run),)
        if names
    ]
    yield Section("Conditions and instruments", (*checks, *lacking, *_struck(analysis)))
    yield Section("Uncertainty budget", tuple(budget_blocks(analysis)))
    every = [
        *(_capital(section) for section in findings(analysis, advice=False)),
        *appendix(analysis, _diagnoses(analysis, found), dossier.gearboxes),
        *other_test_readings(dossier.other_tests),
        Section("Not measured, by clause of ISO 9283:1998", (Text(_not_measured(analysis)),)),
        Section("Provenance", tuple(provenance(dossier.provenance, analysis.run.origin))),
    ]
    first = replace(every[0], heading=f"Appendix: {every[0].heading}", new_page=True)
    yield from (first, *every[1:])


def _diagnoses(
    analysis: Analysis, found: Mapping[str | None, Diagnosis | Failure]
) -> Iterator[Section]:
    """Yield the figures of the diagnoses; their words stand before."""
    for pose in poses_in_cycles(analysis):
        one = found.get(pose.label)
        for section in diagnosis_report(one) if isinstance(one, Diagnosis) else ():
            if section.depth == "detail":
                heading = at_pose(f"Diagnosis: {section.heading}", pose)
                yield Section(heading, section.blocks)


def _not_measured(analysis: Analysis) -> str:
    of_the_standard = [one for one in not_measured(analysis) if one.clause[0].isdigit()]
    found = sorted(of_the_standard, key=lambda one: [*map(int, re.findall(r"\d+", one.clause))])
    return "; ".join(f"{one.clause} {one.name}" for one in found) + "."


def _capital(section: Section) -> Section:
    return replace(section, heading=section.heading[:1].upper() + section.heading[1:])


def _struck(analysis: Analysis) -> Iterator[Block]:
    """Yield what the recording says was struck, with its reasons, and its other remarks."""
    line = remarks(analysis.run)
    struck = [text for kind, text in line if kind == "struck"]
    if struck:
        yield Text("Readings that were struck and taken again:", "strong")
        yield from map(Text, struck)
    others = [f"{kind}: {text}" for kind, text in line if kind != "struck"]
    if others:
        yield Text("Remarks of the recording:", "strong")
        yield from map(Text, others)


@dataclass(frozen=True, slots=True)
class Chapter:
    """What was measured under one condition.

    ``name`` is that of the condition, as the parts have it (``v50-l100``); ``conditions`` are the
    columns that tell it from others, such as ``{"velocity": "50 %"}``.
    """

    name: str
    conditions: Mapping[str, str]
    dossier: Dossier


def joined_dossier(chapters: Sequence[Chapter], missing: Sequence[str] = ()) -> Dossier:
    """Return one dossier of several conditions, as `joined_analysis` of their analyses."""
    parts = [UnderCondition(one.name, one.dossier.analysis) for one in chapters]
    first = chapters[0].dossier
    diagnoses: dict[str | None, Diagnosis | Failure] = {
        one.called(pose): found
        for one, chapter in zip(parts, chapters, strict=True)
        for pose, found in chapter.dossier.diagnoses.items()
    }
    files = [file for one in chapters for file in one.dossier.provenance.files]
    return replace(
        first,
        analysis=joined_analysis(parts, missing),
        provenance=replace(first.provenance, files=tuple(dict.fromkeys(files))),
        diagnoses=diagnoses,
        parts=tuple(_result_part(one) for one in chapters),
    )


def _result_part(chapter: Chapter) -> ResultPart:
    analysis = chapter.dossier.analysis
    labels = tuple(pose.label for pose in analysis.poses)
    return ResultPart(analysis.characteristics, labels, chapter.conditions)
