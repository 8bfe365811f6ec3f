"""What commands publish beyond the fields of one result: reports, conditions, the demo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, Protocol, TypeAlias, cast

from scara_iso.base.published import MERGED, Size, publish
from scara_iso.comparison import Comparison
from scara_iso.diagnosis import (
    BacklashResult,
    Diagnosis,
    DiagnosisOfPoses,
)
from scara_iso.iso9283 import (
    Analysis,
    ConditionAnalysis,
    Cycles,
    Finding,
    FolderAnalysis,
    FolderAndOtherTests,
    Millimetres,
    OtherTests,
    Poses,
    WholeAnalysis,
)
from scara_iso.reporting.dossier import Amendment, Dossier
from scara_iso.reporting.figure_tables import UncertaintyLine, uncertainty_budget
from scara_iso.reporting.named_effects import Failure
from scara_iso.reporting.stated import InputFile, Restated, head
from scara_iso.robot import (
    PRINTED_DEVIATION_MM,
    PRINTED_FREE_PLAY_MM,
    PRINTED_RP_MM,
    PRINTED_XY_MM,
    Backlash,
)
from scara_iso.run import AxisKey, FloatArray, IntArray, Run
from scara_iso.testfolder import Condition


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedFigures:
    """What the paper prints."""

    RP: Mapping[AxisKey, Size]
    """By axis, of Table I: lengths in mm, theta in degrees."""
    RP_rss: Millimetres
    """Eq. 23."""
    deviation_mm: Millimetres
    """Eq. 21."""
    free_play_mm: Millimetres
    """Eq. 22."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedDemo:
    """The paper's Table I and first joint."""

    schema: Literal["scara-iso/demo/1"]
    """Name and number of this schema."""
    analysis: Analysis
    """Of Table I, as in `analyze`."""
    backlash: BacklashResult
    """Of the first joint, as in `backlash`."""
    printed: PrintedFigures
    """To be set beside those figures."""


def published_demo(table_1: Analysis, gear: Backlash) -> PublishedDemo:
    """Return what ``demo`` says of the paper's Table I and first joint."""
    return PublishedDemo(
        schema="scara-iso/demo/1",
        analysis=table_1,
        backlash=BacklashResult(gear, table_1.poses[0]),
        printed=PrintedFigures(
            RP=PRINTED_RP_MM,
            RP_rss=PRINTED_XY_MM,
            deviation_mm=PRINTED_DEVIATION_MM,
            free_play_mm=PRINTED_FREE_PLAY_MM,
        ),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedField:
    """What is stated about the test in one field of the report's head."""

    field: str
    """Its name."""
    stated: str
    """What it says."""


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


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedReadings:
    """The readings of the table, row by row."""

    line: IntArray | None
    """Of the file; null where it has none."""
    cycle: IntArray
    """Number of the cycle."""
    pose: tuple[str, ...] | None
    """Name of the pose; null without poses."""
    approach: tuple[str, ...] | None = None
    """Direction, where the table names it."""
    axes: Mapping[AxisKey, FloatArray]
    """By axis."""
    covariates: Mapping[str, FloatArray]
    """Other columns, by name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedReport:
    """``report`` of a table."""

    schema: Literal["scara-iso/report/1"]
    """Name and number of this schema."""
    head: tuple[StatedField, ...]
    """The fields of docs/report.md."""
    analysis: Analysis
    """As in `analyze`."""
    uncertainty: tuple[UncertaintyLine, ...]
    """Budget of a reading, by axis."""
    diagnoses: tuple[DiagnosedPose | UndiagnosedPose, ...]
    """As in `diagnose`, by pose."""
    backlash: tuple[BacklashAtJoint, ...]
    """As in `backlash`, by joint of the model."""
    readings: PublishedReadings
    """As they were read."""
    files: tuple[InputFile, ...]
    """What the report was made of."""
    restated: tuple[Restated, ...]
    """Fields that the call stated or overrode."""
    amendment: Amendment | None
    """Which report it replaces; null where none."""
    version: str
    """Of this program."""
    command: str
    """The call that made the report."""


def published_report(dossier: Dossier) -> PublishedReport:
    """Return what ``report`` says; its parts are those of the other commands."""
    analysis, made = dossier.analysis, dossier.provenance
    return PublishedReport(
        schema="scara-iso/report/1",
        head=tuple(
            StatedField(field=field, stated=text)
            for field, text in head(analysis.run, analysis.cycles).rows
        ),
        analysis=analysis,
        uncertainty=uncertainty_budget(analysis),
        diagnoses=tuple(_at_pose(pose, found) for pose, found in dossier.diagnoses.items()),
        backlash=tuple(
            BacklashAtJoint(joint=cast(Literal[1, 2], joint), backlash=gearbox.backlash(arm))
            for joint, (gearbox, arm) in dossier.gearboxes.items()
        ),
        readings=_readings(analysis.run),
        files=made.files,
        restated=made.restated,
        amendment=dossier.amendment,
        version=made.version,
        command=made.command,
    )


def _at_pose(pose: str | None, found: Diagnosis | Failure) -> DiagnosedPose | UndiagnosedPose:
    if isinstance(found, Failure):
        return UndiagnosedPose(pose=pose, error=found.message)
    return DiagnosedPose(pose=pose, diagnosis=found)


def _readings(run: Run) -> PublishedReadings:
    return PublishedReadings(
        line=run.lines,
        cycle=run.cycle,
        pose=None if run.pose is None else tuple(run.pose.tolist()),
        approach=None if run.direction is None else tuple(run.direction.tolist()),
        axes={name: axis.readings for name, axis in run.axes.items()},
        covariates=run.covariates,
    )


OfTable: TypeAlias = Diagnosis | DiagnosisOfPoses | Comparison | PublishedReport


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


def published_condition(one: OfCondition, result: OfTable) -> ConditionResult:
    """Return what a command gives of one condition."""
    at, missing = one.condition, tuple(one.missing)
    return ConditionResult(velocity=at.velocity, load=at.load, missing=missing, result=result)


def published_conditions(
    conditions: Sequence[ConditionResult], other_tests: OtherTests | None = None
) -> ConditionResults:
    """Return what a command gives of each condition, and what is ``beside`` them."""
    if other_tests:
        return ResultsAndOtherTests(conditions=tuple(conditions), other_tests=other_tests)
    return ConditionResults(conditions=tuple(conditions))


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
    if len(conditions) == 1 and analyses[0] is not None:
        analyses = [other_tests.added_to(analyses[0])]
    found = [
        replace(_analysed(source, one, analysis), missing=tuple(one.missing))
        for one, analysis in zip(conditions, analyses, strict=True)
    ]
    if len(found) == 1:
        missing = (*conditions[0].missing, *other_tests.missing)
        if analyses[0] is not None or not other_tests:
            return replace(found[0], missing=missing)
        return replace(
            found[0],
            characteristics=other_tests.characteristics,
            limits=other_tests.limits,
            findings=other_tests.findings,
            missing=missing,
        )
    each = tuple(
        publish(ConditionAnalysis, document, velocity=at.velocity, load=at.load)
        for at, document in zip((one.condition for one in conditions), found, strict=True)
    )
    if not other_tests:
        return FolderAnalysis(source=found[0].source, conditions=each)
    return FolderAndOtherTests(source=found[0].source, conditions=each, other_tests=other_tests)


def _analysed(source: str, one: OfCondition, analysis: Analysis | None) -> WholeAnalysis:
    if analysis is not None:
        return analysis
    return WholeAnalysis(
        source=source,
        read_as=f"no part of the test, {one.condition}",
        notes=(),
        metadata={},
        cycles=Cycles(read=0, discarded=(), used=0),
        poses=Poses(),
        findings=(Finding("parts-missing", "warning", "no part is recorded"),),
    )
