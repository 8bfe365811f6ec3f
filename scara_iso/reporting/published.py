"""What commands publish beyond the fields of one result: reports, conditions, the demo, ports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, Protocol, TypeAlias, cast

from scara_iso.base.published import Size, publish
from scara_iso.comparison import PublishedComparison
from scara_iso.diagnosis import (
    BacklashOfModel,
    Diagnosis,
    PosesDiagnosis,
    PublishedBacklash,
    PublishedDiagnosis,
    TracedPosesDiagnosis,
    published_backlash,
    published_diagnosis,
)
from scara_iso.iso9283 import (
    Analysis,
    Beside,
    BesidePoses,
    ConditionAnalysis,
    Finding,
    FolderAnalysis,
    FolderAndBeside,
    Millimetres,
    PublishedAnalysis,
    PublishedCycles,
    published_analysis,
    published_characteristic,
    published_finding,
    published_limit,
)
from scara_iso.recorder import Device, Dialect, Reading
from scara_iso.reporting.dossier import Amendment, Dossier
from scara_iso.reporting.figure_tables import UncertaintyLine, uncertainty_budget
from scara_iso.reporting.named_effects import Failure
from scara_iso.reporting.recording import Probe
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
    analysis: PublishedAnalysis
    """Of Table I, as in `analyze`."""
    backlash: PublishedBacklash
    """Of the first joint, as in `backlash`."""
    printed: PrintedFigures
    """To be set beside those figures."""


def published_demo(table_1: Analysis, gear: Backlash) -> PublishedDemo:
    """Return what ``demo`` says of the paper's Table I and first joint."""
    return PublishedDemo(
        schema="scara-iso/demo/1",
        analysis=published_analysis(table_1),
        backlash=published_backlash(gear, table_1.poses[0]),
        printed=PrintedFigures(
            RP=PRINTED_RP_MM,
            RP_rss=PRINTED_XY_MM,
            deviation_mm=PRINTED_DEVIATION_MM,
            free_play_mm=PRINTED_FREE_PLAY_MM,
        ),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPorts:
    """``ports``."""

    schema: Literal["scara-iso/ports/1"]
    """Name and number of this schema."""
    ports: tuple[Device, ...]
    """By name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedDialect:
    """What a family of indicators speaks."""

    instruments: str
    """Makers and models."""
    line: str
    """Settings of the serial line."""
    sends_unit: bool
    """Whether a reading names its unit."""
    confidence: Literal["high", "medium", "low"]
    """How sure the source is."""
    source: str
    """Document that states it."""
    unverified: tuple[str, ...]
    """What no source states: the user checks it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedDialects:
    """``ports`` of the dialects."""

    schema: Literal["scara-iso/dialects/1"]
    """Name and number of this schema."""
    dialects: Mapping[str, PublishedDialect]
    """By key."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbedReading:
    """A reading as a dialect understands it."""

    value: str
    """As sent."""
    unit: str | None
    """Null where it is not sent."""
    channel: str | None
    """Of a box with several gauges."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedProbe:
    """``ports`` listening to one."""

    schema: Literal["scara-iso/probe/1"]
    """Name and number of this schema."""
    port: str
    """Its address."""
    line: str
    """Settings of the serial line."""
    seconds: Annotated[float, ("unit", "s"), ("minimum", 0)]
    """How long it was listened to."""
    received: Annotated[str, ("pattern", "^([0-9a-f]{2})*$")]
    """Bytes in hexadecimal."""
    dialects: Mapping[str, tuple[ProbedReading, ...]]
    """Those that understand every line, by key, with what they read."""
    diagnosis: str | None
    """Of a wrong parity."""


def published_dialects(found: Mapping[str, Dialect]) -> PublishedDialects:
    """Return what is said of dialects."""
    said = {key: publish(PublishedDialect, one, line=str(one.line)) for key, one in found.items()}
    return PublishedDialects(schema="scara-iso/dialects/1", dialects=said)


def published_probe(probe: Probe) -> PublishedProbe:
    """Return what a port sent."""
    return PublishedProbe(
        schema="scara-iso/probe/1",
        port=probe.port,
        line=probe.line,
        seconds=probe.seconds,
        received=probe.received.hex(),
        dialects={
            key: tuple(
                publish(ProbedReading, one, value=one.text)
                for one in probe.events[key]
                if isinstance(one, Reading)
            )
            for key in probe.matches()
        },
        diagnosis=probe.diagnosis(),
    )


Joint = Literal[1, 2]


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


@dataclass(frozen=True, kw_only=True)
class DiagnosedPose(PublishedDiagnosis, AtPose):
    """``diagnose`` of one pose of a report."""


@dataclass(frozen=True, kw_only=True)
class UndiagnosedPose(AtPose):
    """A pose that could not be diagnosed."""

    error: str
    """Why."""


@dataclass(frozen=True, kw_only=True)
class OfJoint:
    """Where a gear is."""

    joint: Joint
    """Number of the joint."""


@dataclass(frozen=True, kw_only=True)
class BacklashAtJoint(BacklashOfModel, OfJoint):
    """``backlash`` of one joint of the model."""


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
    analysis: PublishedAnalysis
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
        analysis=published_analysis(analysis),
        uncertainty=uncertainty_budget(analysis),
        diagnoses=tuple(_at_pose(pose, found) for pose, found in dossier.diagnoses.items()),
        backlash=tuple(
            publish(
                BacklashAtJoint,
                published_backlash(gearbox.backlash(arm)),
                joint=cast(Joint, joint),
            )
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
    return publish(DiagnosedPose, published_diagnosis(found), pose=pose)


def _readings(run: Run) -> PublishedReadings:
    return PublishedReadings(
        line=run.lines,
        cycle=run.cycle,
        pose=None if run.pose is None else tuple(run.pose.tolist()),
        approach=None if run.direction is None else tuple(run.direction.tolist()),
        axes={name: axis.readings for name, axis in run.axes.items()},
        covariates=run.covariates,
    )


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
