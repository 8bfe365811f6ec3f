"""Everything that is known of a test, joined of its conditions, and what the commands publish."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, Protocol, TypeAlias, cast

from scara_iso.base.published import ALWAYS, INTERNAL, MERGED, fill, publish, published
from scara_iso.comparison import Comparison
from scara_iso.diagnosis import Diagnosis, DiagnosisOfPoses, FoundAtPoses
from scara_iso.iso9283 import (
    Analysis,
    Characteristic,
    ConditionAnalysis,
    Cycles,
    Finding,
    FolderAnalysis,
    OtherTests,
    Poses,
    WholeAnalysis,
)
from scara_iso.reporting.languages import ENGLISH
from scara_iso.reporting.named_effects import Failure
from scara_iso.reporting.shared.figures import UncertaintyLine, largest_of, uncertainty_budget
from scara_iso.reporting.shared.limits import ResultPart
from scara_iso.reporting.shared.stated import head
from scara_iso.reporting.signals import BOUGHT_BY
from scara_iso.robot import Backlash, Gearbox
from scara_iso.run import AxisKey, FloatArray, IntArray
from scara_iso.testfolder import Condition, joined_analysis, pose_under


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file that the report was made of, and the SHA-256 of its bytes in hex."""

    role: str
    """What it is to the report, such as ``table`` or ``model``."""
    name: str
    """Path or name of the file."""
    sha256: Annotated[str, ("pattern", "^[0-9a-f]{64}$")]
    """SHA-256 of its bytes, in hex."""

    @classmethod
    def of(cls, role: str, name: str, data: bytes) -> InputFile:
        """Return a file with the bytes ``data``."""
        return cls(role, name, hashlib.sha256(data).hexdigest())


@dataclass(frozen=True, slots=True)
class Restated:
    """What was stated for the report and not in the table; ``before`` is what it overrides."""

    key: str
    """Name of the field."""
    text: str
    """What it was given."""
    before: str | None
    """What the table stated; null for nothing."""

    def __str__(self) -> str:
        instead = "" if self.before is None else f" (in place of {self.before})"
        return f"{self.key}: {self.text}{instead}"


@dataclass(frozen=True, slots=True)
class Amendment:
    """Which report this one replaces, and why (ISO/IEC 17025:2017, 7.8.8)."""

    supersedes: str
    """Number of the report that it stands in place of."""
    reason: str
    """Why it does."""


@dataclass(frozen=True, slots=True)
class StatedField:
    """What is stated about the test in one field of the report's head."""

    field: str
    """Its name."""
    stated: str
    """What it says."""


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


@dataclass(frozen=True, slots=True)
class Provenance:
    """Files, program and command of a report, and what was stated for it alone."""

    files: tuple[InputFile, ...]
    """What the report was made of."""
    version: str
    """Of this program."""
    command: str
    """The call that made the report."""
    restated: tuple[Restated, ...] = ()
    """Fields that the call stated or overrode."""


Diagnoses = Mapping[str | None, Diagnosis | Failure]
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
    together: tuple[FoundAtPoses, ...] = field(default=(), metadata=INTERNAL)
    """The effects of all poses together."""
    gearboxes: Gearboxes = field(default_factory=dict, metadata=published("backlash", by=_by_joint))
    """As in `backlash`, by joint of the model."""
    amendment: Amendment | None = field(default=None, metadata=ALWAYS)
    """Which report it replaces; null where none."""
    parts: tuple[ResultPart, ...] = field(default=(), metadata=INTERNAL)
    """The results by condition, one without any; of several a pose is called by its part."""
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
            parts=self.parts or (ResultPart.of(self.analysis),),
            head=tuple(StatedField(name, text) for name, text in rows),
            uncertainty=uncertainty_budget(self.analysis),
            readings=PublishedReadings(
                line=run.lines,
                cycle=run.cycle,
                pose=None if run.pose is None else tuple(run.pose.tolist()),
                approach=None if run.direction is None else tuple(run.direction.tolist()),
                axes={name: axis.readings for name, axis in run.axes.items()},
                covariates=run.covariates,
            ),
        )

    def with_other_tests(self, other_tests: OtherTests, files: Sequence[InputFile] = ()) -> Dossier:
        """Return it with the tests beside the poses, read from ``files`` more."""
        if not other_tests:
            return self
        read = replace(self.provenance, files=(*self.provenance.files, *files))
        return replace(
            self,
            analysis=other_tests.added_to(self.analysis),
            provenance=read,
            parts=(*self.parts, ResultPart(_in_short(other_tests), ())),
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


OfTable: TypeAlias = Diagnosis | DiagnosisOfPoses | Comparison | Dossier


def joined_dossier(dossiers: Mapping[Condition, Dossier], missing: Sequence[str] = ()) -> Dossier:
    """Return one dossier of several conditions, as `joined_analysis` of their analyses."""
    every = list(dossiers.values())
    diagnoses: dict[str | None, Diagnosis | Failure] = {
        pose_under(at.name, pose): found
        for at, one in dossiers.items()
        for pose, found in one.diagnoses.items()
    }
    files = dict.fromkeys(file for one in every for file in one.provenance.files)
    return replace(
        every[0],
        analysis=joined_analysis({at.name: one.analysis for at, one in dossiers.items()}, missing),
        provenance=replace(every[0].provenance, files=tuple(files)),
        diagnoses=diagnoses,
        together=(),
        parts=tuple(ResultPart.of(one.analysis, at) for at, one in dossiers.items()),
    )


class _OfCondition(Protocol):
    @property
    def condition(self) -> Condition: ...
    @property
    def missing(self) -> Sequence[str]: ...


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
    conditions: Sequence[_OfCondition],
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
    conditions: Sequence[_OfCondition],
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


def _empty(source: str, one: _OfCondition) -> WholeAnalysis:
    return WholeAnalysis(
        source=source,
        read_as=f"no part of the test, {one.condition}",
        notes=(),
        metadata={},
        cycles=Cycles(read=0, discarded=(), used=0),
        poses=Poses(),
        findings=(Finding("parts-missing", "warning", "no part is recorded"),),
    )
