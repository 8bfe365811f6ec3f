"""What commands publish of a test's folder: its conditions, and what was tested beside the poses.

Of several conditions ``diagnose``, ``compare`` and ``report`` write schema
``scara-iso/test-conditions/1``, and ``analyze`` its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, Protocol, TypeAlias

from scara_iso.base.published import publish
from scara_iso.comparison import PublishedComparison
from scara_iso.diagnosis import PosesDiagnosis, PublishedDiagnosis, TracedPosesDiagnosis
from scara_iso.iso9283 import (
    Analysis,
    Beside,
    BesidePoses,
    ConditionAnalysis,
    Finding,
    FolderAnalysis,
    FolderAndBeside,
    PublishedAnalysis,
    PublishedCycles,
    published_analysis,
    published_characteristic,
    published_finding,
    published_limit,
)
from scara_iso.reporting.published_dossier import PublishedReport
from scara_iso.testfolder import Condition

OfTable: TypeAlias = (
    PublishedDiagnosis
    | PosesDiagnosis
    | TracedPosesDiagnosis
    | PublishedComparison
    | PublishedReport
)


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

    schema: Literal["scara-iso/test-conditions/1"]
    """Name and number of this schema."""
    conditions: Annotated[tuple[ConditionResult, ...], ("minItems", 1)]
    """One for each velocity and load that has readings."""


@dataclass(frozen=True, kw_only=True)
class ResultsAndBeside(BesidePoses, ConditionResults):
    """``report`` of a test with several conditions and tests beside them."""


def published_condition(one: OfCondition, result: OfTable) -> ConditionResult:
    """Return what a command gives of one condition."""
    at, missing = one.condition, tuple(one.missing)
    return ConditionResult(velocity=at.velocity, load=at.load, missing=missing, result=result)


def published_conditions(
    conditions: Sequence[ConditionResult], beside: Beside | None = None
) -> ConditionResults:
    """Return what a command gives of each condition, and what is ``beside`` them."""
    found = ConditionResults(schema="scara-iso/test-conditions/1", conditions=tuple(conditions))
    if not beside:
        return found
    return publish(ResultsAndBeside, found, **_beside(beside))


def published_folder(
    source: str,
    conditions: Sequence[OfCondition],
    analyses: Sequence[Analysis | None],
    beside: Beside,
) -> PublishedAnalysis | FolderAnalysis:
    """Return what ``analyze`` says of a test's folder.

    With one condition it is that of a table, the figures ``beside`` among its own, else
    ``conditions`` holds an object for each, and what is beside them stands beside those.
    """
    if len(conditions) == 1 and analyses[0] is not None:
        analyses = [beside.added_to(analyses[0])]
    found = [
        replace(_analysed(source, one, analysis), missing=tuple(one.missing))
        for one, analysis in zip(conditions, analyses, strict=True)
    ]
    if len(found) == 1:
        alone = _beside(beside) if beside and analyses[0] is None else {}
        missing = (*conditions[0].missing, *beside.missing)
        return replace(found[0], **{**alone, "missing": missing})
    each = tuple(
        publish(ConditionAnalysis, document, velocity=at.velocity, load=at.load)
        for at, document in zip((one.condition for one in conditions), found, strict=True)
    )
    if not beside:
        return publish(FolderAnalysis, found[0], conditions=each)
    return publish(FolderAndBeside, found[0], conditions=each, **_beside(beside))


def _beside(beside: Beside) -> dict[str, Any]:
    """Return the keys of `BesidePoses`."""
    return {
        "characteristics": tuple(map(published_characteristic, beside.characteristics)),
        "limits": tuple(map(published_limit, beside.limits)),
        "conformity": beside.conformity,
        "findings": tuple(map(published_finding, beside.findings())),
        "missing": beside.missing,
    }


def _analysed(source: str, one: OfCondition, analysis: Analysis | None) -> PublishedAnalysis:
    if analysis is not None:
        return published_analysis(analysis)
    missing = Finding("parts-missing", "warning", "no part is recorded")
    return PublishedAnalysis(
        schema="scara-iso/analyze/2",
        unit="mm",
        source=source,
        read_as=f"no part of the test, {one.condition}",
        notes=(),
        metadata={},
        cycles=PublishedCycles(read=0, discarded=(), used=0),
        poses=(),
        characteristics=(),
        limits=(),
        conformity=None,
        deviations=(),
        findings=(published_finding(missing),),
    )
