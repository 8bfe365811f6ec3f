"""What ``analyze`` publishes of an analysis: schema ``scara-iso/analyze/2``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, cast

from scara_iso.base.published import Count, Interval, Size, publish
from scara_iso.iso9283.drift import DriftCourse, DriftFit
from scara_iso.iso9283.figures import (
    AxisFigures,
    AxisResult,
    Conformity,
    DecisionRule,
    Millimetres,
    PoseResult,
    SpaceFigures,
)
from scara_iso.iso9283.results import (
    Analysis,
    Characteristic,
    Finding,
    LimitCheck,
    Severity,
)
from scara_iso.run import FloatArray

AxisName = Literal["X", "Y", "Z", "theta"]
OfSeveral = Annotated[int, ("minimum", 2)]


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedAxis(AxisFigures):
    """The figures of one axis."""

    definitions: Mapping[str, float] | None = None
    """Where asked for: other words for repeatability, in the unit of the axis."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneFigures(SpaceFigures):
    """X and Y together."""

    RP_rss: Millimetres
    """Root of the sum of squares of the axes' RP, paper eq. 23."""
    RP_rss_interval: Interval | None
    """95 %, of RP_rss."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPose:
    """The figures of one pose."""

    pose: str | None
    """Its name; null without poses; `P1 from +x`, or `+x`, for one of several directions."""
    axes: Mapping[AxisName, PublishedAxis]
    """By name."""
    XY: PlaneFigures | None = None
    """Where X and Y are lengths."""
    XYZ: SpaceFigures | None = None
    """Where X, Y and Z are lengths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CharacteristicLimit:
    """A characteristic against its limit."""

    limit: Size
    """Largest value that is allowed, in the unit of the characteristic."""
    verdict: Conformity
    """Whether it is kept."""
    rule: DecisionRule
    """What decides: the 95 % interval, or the value alone."""
    lower: Size | None = None
    """Smallest value that is allowed, where the largest is not the only limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UncertaintyParts:
    """Standard uncertainties that `u` is made of, in the unit of the characteristic."""

    sampling: Size | None = None
    """Chance, the dial's rounding with it."""
    calibration: Size | None = None
    """Stated for the indicator."""
    reading: Size | None = None
    """Resolution and calibration, of a mean."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedCharacteristic:
    """One figure of the test."""

    code: str
    """`scara-iso explain CODE` explains it."""
    clause: str
    """Of ISO 9283, or an equation of the paper."""
    pose: str | None
    """Its name; two of them for a distance: `P1-P2`."""
    of: str
    """Axis, XY or XYZ; of a push test joint or reading, or `joint_1`, `joint_1 reading`."""
    value: float
    """In `unit`."""
    unit: Literal["mm", "deg", "h", "s", "mm/100 N", "N", "N m", "arcmin", "N m/arcmin"]
    """Of value, u, parts, interval and limit."""
    u: Size | None
    """Standard uncertainty; null without an interval."""
    parts: UncertaintyParts
    """What u is made of."""
    interval: Interval | None
    """95 %; null where so few readings allow none."""
    n: OfSeveral
    """Number of cycles, or of what else counts."""
    limit: CharacteristicLimit | None
    """Null where none was given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedLimit:
    """A figure against a limit that was given; lengths in mm, angles in degrees."""

    figure: str
    """With the code where it is no repeatability of a pose: `RD X`."""
    pose: str | None
    """Null for the only one."""
    RP: Size
    """The figure that decides."""
    interval: Interval | None
    """95 %, of RP."""
    limit: Size
    """Largest value that is allowed."""
    verdict: Conformity
    """Whether it is kept."""
    rule: DecisionRule
    """What decides: the 95 % interval, or the value alone."""
    interval_void: bool
    """Whether a drift voids the interval: the verdict holds only while the robot drifts so."""
    cycles_wanted: Annotated[int, ("minimum", 1)] | None
    """In one run, for a proof in 4 of 5 tests, were RP as read; null where decided or where no
    number would do; 100000: that many or more."""
    guard: Size | None
    """U = 2 u of the indicator."""
    inside: bool
    """RP is at most the limit, and at least the lower one."""
    clear: bool
    """RP is farther from the limit than `guard`."""
    lower: Size | None = None
    """Smallest value that is allowed, where the largest is not the only limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedFinding:
    """Something the user should know."""

    code: str
    """`scara-iso explain CODE` explains it."""
    severity: Severity
    """How much it weighs on the result."""
    axis: str | None
    """One axis, or several with a comma between them; null for all."""
    pose: str | None
    """Null for all, or for the only one."""
    message: str
    """What was found and what to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """A finding that departs from ISO 9283 or from good practice around it."""

    rule: str
    """What it departs from."""
    code: str
    """Of the finding."""
    message: str
    """Of the finding."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedFit:
    """The course as limit plus exponential."""

    time_constant_h: Annotated[float, ("unit", "h"), ("exclusiveMinimum", 0)]
    """Of all axes together."""
    time_constant_interval_h: tuple[float, float | None]
    """95 %; an end is null where the test bounds none."""
    steady: bool
    """A tenth of the drift is left before the test ends."""
    fitted: Mapping[str, FloatArray]
    """Mean of each block by the fit, by axis."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedCourse:
    """How one pose of a drift test moves, block by block."""

    pose: str | None
    """Its name."""
    visits: tuple[OfSeveral, ...]
    """Of each block."""
    time_h: FloatArray | None
    """Mean time of each block since the first visit, h; null without times."""
    mean: Mapping[str, FloatArray]
    """Of each block, by axis."""
    fit: PublishedFit | None
    """Null without a drift beyond chance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedCycles:
    """How many cycles each pose has; where gaps are allowed, of the pose with the fewest."""

    read: Count
    """Cycles in the table."""
    discarded: tuple[int, ...]
    """Numbers of the cycles that were left out."""
    used: Count
    """Cycles that count."""


@dataclass(frozen=True, kw_only=True)  # without slots: bases are joined, the head's keys first
class Head:
    """What the object of ``analyze`` begins with."""

    schema: Literal["scara-iso/analyze/2"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    source: str
    """The file, or the folder of a test."""


@dataclass(frozen=True, kw_only=True)
class Analysed:
    """Readings and what was found in them, beside where they came from."""

    read_as: str
    """How the file was understood."""
    notes: tuple[str, ...]
    """What was met and not used."""
    metadata: Mapping[str, str]
    """What the file states."""
    cycles: PublishedCycles
    """For each pose."""
    poses: tuple[PublishedPose, ...]
    """None where no part of a test's folder is recorded."""
    characteristics: tuple[PublishedCharacteristic, ...]
    """Every figure of the test, by clause."""
    limits: tuple[PublishedLimit, ...]
    """One for each figure that was held against a limit."""
    conformity: Conformity | None
    """Of all limits together, the gravest; null where none was given. The exit code is 0 for `pass`
    and null, else 1."""
    deviations: tuple[Deviation, ...]
    """Findings that name a rule."""
    findings: tuple[PublishedFinding, ...]
    """What the checks say."""
    missing: tuple[str, ...] | None = None
    """Of a test's folder: parts that are not recorded."""


@dataclass(frozen=True, kw_only=True)
class PublishedAnalysis(Analysed, Head):
    """``analyze`` of a table, or of a test's folder with one condition."""

    drift: tuple[PublishedCourse, ...] | None = None
    """Of a drift test (7.6) only: the course of each pose."""


@dataclass(frozen=True, kw_only=True)
class ConditionAnalysis(Analysed):
    """What one condition of a test's folder would give by itself."""

    velocity: float
    """Per cent of the rated one."""
    load: float
    """Per cent of the rated one."""


@dataclass(frozen=True, kw_only=True)
class FolderAnalysis(Head):
    """``analyze`` of a test's folder with several conditions."""

    conditions: Annotated[tuple[ConditionAnalysis, ...], ("minItems", 2)]
    """One for each velocity and load."""


@dataclass(frozen=True, kw_only=True)
class BesidePoses:
    """The tests beside the poses: drift and push tests."""

    characteristics: tuple[PublishedCharacteristic, ...]
    """Their figures."""
    limits: tuple[PublishedLimit, ...]
    """One for each figure that was held against a limit."""
    conformity: Conformity | None
    """Of these limits together, the gravest; null where none was given."""
    findings: tuple[PublishedFinding, ...]
    """What the checks say."""
    missing: tuple[str, ...]
    """Parts that are not recorded."""


@dataclass(frozen=True, kw_only=True)
class FolderAndBeside(BesidePoses, FolderAnalysis):
    """``analyze`` of a test's folder with several conditions and tests beside them."""


def published_analysis(analysis: Analysis) -> PublishedAnalysis:
    """Return what ``analyze`` says."""
    run = analysis.run
    return PublishedAnalysis(
        schema="scara-iso/analyze/2",
        unit="mm",
        source=run.origin.source,
        read_as=run.origin.understood,
        notes=run.origin.notes,
        metadata=run.metadata,
        cycles=publish(PublishedCycles, analysis.cycles),
        poses=tuple(map(published_pose, analysis.poses)),
        characteristics=tuple(map(published_characteristic, analysis.characteristics)),
        drift=None if analysis.drift is None else tuple(map(_course, analysis.drift)),
        limits=tuple(map(published_limit, analysis.limits)),
        conformity=analysis.conformity,
        deviations=tuple(publish(Deviation, one, message=one.said) for one in analysis.deviations),
        findings=tuple(map(published_finding, analysis.findings)),
    )


def published_pose(found: PoseResult) -> PublishedPose:
    """Return the figures of a pose."""
    return PublishedPose(
        pose=found.label,
        axes={cast(AxisName, name): _axis(axis) for name, axis in found.axes.items()},
        XY=None if found.XY is None else publish(PlaneFigures, found.XY),
        XYZ=None if found.XYZ is None else publish(SpaceFigures, found.XYZ),
    )


def _axis(found: AxisResult) -> PublishedAxis:
    defined = {one.name: one.value for one in found.definitions}
    return publish(PublishedAxis, found, definitions=defined or None)


def published_characteristic(found: Characteristic) -> PublishedCharacteristic:
    """Return a characteristic with its estimate and its limit."""
    of, limit = found.estimate, found.limit
    return publish(
        PublishedCharacteristic,
        of,
        code=found.code,
        pose=found.pose,
        of=found.of,
        parts=UncertaintyParts(**of.parts),
        limit=limit and publish(CharacteristicLimit, limit, rule=limit.decision),
    )


def published_limit(found: LimitCheck) -> PublishedLimit:
    """Return a figure against its limit."""
    return publish(PublishedLimit, found, rule=found.decision)


def published_finding(found: Finding) -> PublishedFinding:
    """Return a finding, its advice in the message."""
    return publish(PublishedFinding, found, message=found.said)


def _course(found: DriftCourse) -> PublishedCourse:
    return PublishedCourse(
        pose=found.pose.label,
        visits=tuple(map(len, found.visits)),
        time_h=found.hours,
        mean=found.means,
        fit=None if found.fit is None else _fit(found.fit),
    )


def _fit(found: DriftFit) -> PublishedFit:
    interval, steady = found.interval_h, found.is_steady
    return publish(PublishedFit, found, time_constant_interval_h=interval, steady=steady)


PUBLISHED = (PublishedAnalysis, FolderAnalysis, FolderAndBeside)
"""The objects of ``analyze``."""
