"""What ``report`` publishes of a whole test: schema ``scara-iso/report/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, cast

from scara_iso.base.published import publish
from scara_iso.diagnosis import (
    BacklashOfModel,
    Diagnosis,
    PublishedDiagnosis,
    published_backlash,
    published_diagnosis,
)
from scara_iso.iso9283 import PublishedAnalysis, published_analysis
from scara_iso.reporting.dossier import Dossier
from scara_iso.reporting.front import Amendment
from scara_iso.reporting.named_effects import Failure
from scara_iso.reporting.stated import InputFile, Restated, head
from scara_iso.reporting.uncertainty import UncertaintyLine, uncertainty_budget
from scara_iso.run import AxisKey, FloatArray, IntArray, Run

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
