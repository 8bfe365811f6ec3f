"""A test under several conditions: joined to one report, and what the commands publish of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, Protocol, TypeAlias

from scara_iso.base.published import MERGED, publish
from scara_iso.comparison import Comparison
from scara_iso.diagnosis import Diagnosis, DiagnosisOfPoses
from scara_iso.iso9283 import (
    Analysis,
    ConditionAnalysis,
    Cycles,
    Finding,
    FolderAnalysis,
    OtherTests,
    Poses,
    WholeAnalysis,
)
from scara_iso.reporting.dossier import Dossier
from scara_iso.reporting.limits import ResultPart
from scara_iso.reporting.named_effects import Failure
from scara_iso.testfolder import Condition, UnderCondition, joined_analysis

OfTable: TypeAlias = Diagnosis | DiagnosisOfPoses | Comparison | Dossier


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
        part.called(pose): found
        for part, one in zip(parts, chapters, strict=True)
        for pose, found in one.dossier.diagnoses.items()
    }
    files = dict.fromkeys(file for one in chapters for file in one.dossier.provenance.files)
    return replace(
        first,
        analysis=joined_analysis(parts, missing),
        provenance=replace(first.provenance, files=tuple(files)),
        diagnoses=diagnoses,
        parts=tuple(map(_result_part, chapters)),
    )


def _result_part(chapter: Chapter) -> ResultPart:
    analysis = chapter.dossier.analysis
    labels = tuple(pose.label for pose in analysis.poses)
    return ResultPart(analysis.characteristics, labels, chapter.conditions)


class OfCondition(Protocol):
    """A condition and the parts of it that are missing."""

    @property
    def condition(self) -> Condition:
        """Velocity and load."""

    @property
    def missing(self) -> Sequence[str]:
        """Parts by name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionResult:
    """What a command gives of one condition."""

    velocity: float
    """Per cent of the rated one."""
    load: float
    """Per cent of the rated one."""
    missing: tuple[str, ...]
    """Parts that are not recorded."""
    result: OfTable
    """As of a table."""


@dataclass(frozen=True, kw_only=True)
class ConditionResults:
    """``diagnose``, ``compare`` or ``report`` of tests with several conditions."""

    schema: Literal["scara-iso/test-conditions/1"] = "scara-iso/test-conditions/1"
    """Name and number of this schema."""
    conditions: Annotated[tuple[ConditionResult, ...], ("minItems", 1)]
    """One for each velocity and load that has readings."""


@dataclass(frozen=True, kw_only=True)
class ResultsAndOtherTests(ConditionResults):
    """``report`` of a test with several conditions and tests beside them."""

    other_tests: OtherTests = field(metadata=MERGED)
    """Their figures, limits and findings."""


def published_conditions(
    conditions: Sequence[OfCondition],
    results: Sequence[OfTable],
    other_tests: OtherTests | None = None,
) -> ConditionResults:
    """Return what a command gives of each condition, and what is ``beside`` them."""
    each = tuple(
        publish(ConditionResult, one.condition, missing=tuple(one.missing), result=result)
        for one, result in zip(conditions, results, strict=True)
    )
    if other_tests:
        return ResultsAndOtherTests(conditions=each, other_tests=other_tests)
    return ConditionResults(conditions=each)


def published_folder(
    source: str,
    conditions: Sequence[OfCondition],
    analyses: Sequence[Analysis | None],
    other_tests: OtherTests,
) -> WholeAnalysis | FolderAnalysis:
    """Return what ``analyze`` says of a test's folder.

    With one condition it is that of a table, the figures ``beside`` among its own, else
    ``conditions`` holds an object for each, and what is beside them stands beside those.
    """
    only = analyses[0] if len(conditions) == 1 else None
    if only is not None:
        analyses = [other_tests.added_to(only)]
    found = [
        replace(analysis or _empty(source, one), missing=tuple(one.missing))
        for one, analysis in zip(conditions, analyses, strict=True)
    ]
    if len(found) == 1:
        missing = (*conditions[0].missing, *other_tests.missing)
        if only is not None or not other_tests:
            return replace(found[0], missing=missing)
        return replace(
            found[0],
            characteristics=other_tests.characteristics,
            limits=other_tests.limits,
            findings=other_tests.findings,
            missing=missing,
        )
    each = tuple(
        publish(ConditionAnalysis, one, velocity=at.condition.velocity, load=at.condition.load)
        for at, one in zip(conditions, found, strict=True)
    )
    return FolderAnalysis(source=found[0].source, conditions=each, other_tests=other_tests or None)


def _empty(source: str, one: OfCondition) -> WholeAnalysis:
    return WholeAnalysis(
        source=source,
        read_as=f"no part of the test, {one.condition}",
        notes=(),
        metadata={},
        cycles=Cycles(read=0, discarded=(), used=0),
        poses=Poses(),
        findings=(Finding("parts-missing", "warning", "no part is recorded"),),
    )
