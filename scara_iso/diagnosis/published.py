"""What ``diagnose`` publishes of one pose: schema ``scara-iso/diagnose/2``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, Protocol, TypeAlias, TypeVar

from scara_iso.base.published import Probability, Size, publish
from scara_iso.diagnosis.result import (
    Diagnosis,
    Error,
    Flag,
    Foretold,
    Found,
    Learned,
    Repeatabilities,
    Series,
    Shares,
    UnexplainedCourse,
)
from scara_iso.diagnosis.reversals import Reversal, RunReversals
from scara_iso.diagnosis.sweeps import GearDiagnosis, GearFound
from scara_iso.diagnosis.verdict import Rival, Verdict
from scara_iso.run import AXES, AxisKey

if TYPE_CHECKING:
    from scara_iso.diagnosis.poses_result import DiagnosisOfPoses

Figure: TypeAlias = Annotated[str, ("enum", (*AXES, "XY", "XYZ"))]
"""An axis, or radial in the plane and in space."""
RPs: TypeAlias = Mapping[Figure, Size]
OfAxes: TypeAlias = Mapping[AxisKey, float]
Told = TypeVar("Told")


class Estimated(Protocol):
    """What has the ends of an interval."""

    @property
    def low(self) -> float:
        """Lower end."""

    @property
    def high(self) -> float:
        """Upper end."""


@dataclass(frozen=True, kw_only=True)
class DiagnoseSchema:
    """The head of the object."""

    schema: Literal["scara-iso/diagnose/2"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""


@dataclass(frozen=True, kw_only=True)
class StructureTested:
    """Whether there is structure, and whether effects explain it."""

    verdict: Verdict
    """What the residual holds."""
    p_value: Probability
    """Chance of structure as strong in scatter alone."""
    p_value_at_floor: bool
    """No shuffle or simulation was as far: the chance is at most the p-value."""


@dataclass(frozen=True, kw_only=True)
class EffectFound:
    """An effect that was found; sizes are those of its place."""

    effect: str
    """Its name; `scara-iso explain EFFECT` explains it."""
    axes: tuple[AxisKey, ...]
    """Axes that it moves."""
    joint: int | str | None
    """Where it acts."""
    direction: str | None
    """That its movement lies along; null where none is sure."""
    angles: Mapping[str, Annotated[float, ("unit", "deg")]]
    """Between its movement and each direction of the geometry."""
    parameters: Mapping[str, Any]
    """Parameters by name; `tau_s`, `period_s` where `time_s` was recorded."""
    standard_errors: Mapping[str, Any]
    """Standard error of each size."""
    p_value: Probability
    """Chance of structure as strong in scatter alone."""
    p_value_at_floor: bool
    """No shuffle or simulation was as far: the chance is at most the p-value."""
    probability: Probability
    """Posterior, among the catalogue and the unknown."""
    share: Mapping[str, Any]
    """Of the variance that it takes."""
    rivals: tuple[Rival, ...]
    """Other effects that fit as well, likeliest first."""
    cause: str
    """What usually causes it."""
    confirm_by: str
    """The experiment that confirms it."""
    unidentified: tuple[str, ...]
    """Parameters that the data do not determine, one line each."""


@dataclass(frozen=True, kw_only=True)
class EffectOnAxes(EffectFound):
    """An effect that was found at one pose."""

    joint: Literal[1, 2] | None
    """Along whose movement it lies; null along none."""
    parameters: Mapping[str, float | str | tuple[int, ...] | OfAxes]
    """By name; sizes by axis; `tau_s`, `period_s` where `time_s` was recorded."""
    standard_errors: Mapping[str, OfAxes]
    """Standard error of each size, by axis."""
    share: OfAxes
    """Of the variance of each axis; those of all effects add up to `shares`."""


@dataclass(frozen=True, kw_only=True)
class EffectsOnAxes:
    """What was found at one pose."""

    effects: tuple[EffectOnAxes, ...]
    """In the order in which they were found."""


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Measured minus predicted, root mean square by axis."""

    before: Error
    """By the model as it was."""
    after: Error
    """By the model with the effects found."""


@dataclass(frozen=True, kw_only=True)
class ForetoldRP:
    """RP that a test will measure."""

    value: Size
    """Expected."""
    interval: tuple[Size, Size]
    """95 %, of what the test measures."""


ByFigure: TypeAlias = Mapping[Figure, ForetoldRP]


@dataclass(frozen=True, kw_only=True)
class OfUnseenCycles:
    """RP of cycles that the fit did not see."""

    of: str
    """Which: those of the second table, or every other one, the model from the rest."""
    cycles: int
    """How many."""
    measured: RPs
    """Of their readings."""
    model_before: RPs
    """Of what the model as it was predicts there."""
    completed: ByFigure
    """As the completed model foretells it for as many cycles."""


@dataclass(frozen=True, kw_only=True)
class RepeatabilityOfModel:
    """RP measured, predicted, and without the effects: by axis, `XY` and `XYZ` (radial)."""

    measured: RPs
    """Of the readings."""
    model_before: RPs
    """Of what the model as it was predicts, which has no scatter."""
    model_after: RPs
    """Of what the model with the effects predicts."""
    with_effect_removed: RPs
    """Of the readings with the effects subtracted."""
    completed: ByFigure
    """Of a new test of 30 cycles, by the completed model: effects, scatter and rounding."""
    unseen: OfUnseenCycles | None
    """Null where there are too few cycles to leave half of them out."""


@dataclass(frozen=True, kw_only=True)
class OfOnePose:
    """What is said of one pose beside its effects."""

    candidates: tuple[Rival, ...]
    """Where it is `unexplained`: the nearest effects."""
    courses: tuple[UnexplainedCourse, ...]
    """Where it is `unexplained`: how it goes."""
    learned: Learned | None
    """Where it is `unexplained`: the course that the completed model holds, about its mean."""
    error: Errors
    """Measured minus predicted, before and after."""
    repeatability: RepeatabilityOfModel
    """RP measured, predicted, and without the effects."""
    shares: Mapping[AxisKey, Shares]
    """Of each axis' variance."""
    series: Series
    """Readings and predictions over the cycles."""
    flags: tuple[Flag, ...]
    """Readings that are apart from the others."""
    notes: tuple[str, ...]
    """What could not be searched or told, and what was written to a model."""


@dataclass(frozen=True, kw_only=True)
class GearErrors:
    """Measured minus predicted of reversals, root mean square."""

    rms: Size
    """In the unit of the reversals."""
    held_out_rms: Size | None
    """Each payload, or reversal, left out in turn; null where there is one only."""


@dataclass(frozen=True, kw_only=True)
class GearErrorsOfModel:
    """The errors of both models of the gear."""

    before: GearErrors
    """By eq. 16."""
    after: GearErrors
    """By eq. 16 with the effects found."""


@dataclass(frozen=True, kw_only=True)
class PublishedGear(StructureTested):
    """What the two-inertia model leaves of measured reversals."""

    effects: tuple[GearFound, ...]
    """At most two; both act together and share `probability` and `rivals` (`a+b`)."""
    candidates: tuple[Rival, ...]
    """Where it is `unexplained`: the nearest effects."""
    error: GearErrorsOfModel
    """Measured minus predicted, before and after."""


@dataclass(frozen=True, kw_only=True)
class ReversalsOfRun:
    """The reversals of a run, by payload."""

    reversals: tuple[Reversal, ...]
    """One for each axis and payload."""
    mirrored: bool
    """The load rests on the other side than in the model, so that sizes were compared."""
    missing: tuple[str, ...]
    """Fields that the model lacks."""
    notes: tuple[str, ...]
    """What was left out or not tried."""


@dataclass(frozen=True, kw_only=True)
class NoVerdict:
    """The model lacks what the comparison needs."""

    verdict: None
    """Always null: the fields `missing` are needed."""


@dataclass(frozen=True, kw_only=True)
class GearOfRun(ReversalsOfRun, PublishedGear):
    """The reversals of a run against the gears of the model, in mm."""


@dataclass(frozen=True, kw_only=True)
class ReversalsAlone(ReversalsOfRun, NoVerdict):
    """The reversals of a run where the model lacks what the comparison needs."""


@dataclass(frozen=True, kw_only=True)
class PublishedDiagnosis(OfOnePose, EffectsOnAxes, StructureTested, DiagnoseSchema):
    """``diagnose`` of one pose."""

    gear: GearOfRun | ReversalsAlone | None = None
    """With a model and the columns `approach` and `payload_kg`: the reversals."""


@dataclass(frozen=True, kw_only=True)
class OfTable:
    """What a row is of."""

    table: str
    """The file."""


@dataclass(frozen=True, kw_only=True)
class DiagnosedTable(PublishedDiagnosis, OfTable):
    """``diagnose`` of one of several unrelated tables."""


@dataclass(frozen=True, kw_only=True)
class RefusedTable(OfTable):
    """A table that could not be diagnosed."""

    error: str
    """Why."""


@dataclass(frozen=True, kw_only=True)
class DiagnosedTables:
    """``diagnose`` of several unrelated tables."""

    schema: Literal["scara-iso/diagnose-many/1"]
    """Name and number of this schema."""
    tables: Annotated[tuple[DiagnosedTable | RefusedTable, ...], ("minItems", 1)]
    """As they were named."""


OnePose = TypeVar("OnePose", bound=OfOnePose)
Whole = TypeVar("Whole", bound=PublishedDiagnosis)
Gear = TypeVar("Gear", bound=PublishedGear)


def published_diagnosis(found: Diagnosis) -> PublishedDiagnosis:
    """Return what ``diagnose`` says of one pose."""
    return _of_diagnosis(PublishedDiagnosis, found)


def published_tables(tables: Sequence[str], found: Sequence[Diagnosis | str]) -> DiagnosedTables:
    """Return what ``diagnose`` says of tables: of each its diagnosis, or why there is none."""
    return DiagnosedTables(
        schema="scara-iso/diagnose-many/1",
        tables=tuple(
            RefusedTable(table=table, error=one)
            if isinstance(one, str)
            else _of_diagnosis(DiagnosedTable, one, table=table)
            for table, one in zip(tables, found, strict=True)
        ),
    )


def _of_diagnosis(kind: type[Whole], found: Diagnosis, **given: str) -> Whole:
    return of_one_pose(
        kind,
        found,
        schema="scara-iso/diagnose/2",
        unit="mm",
        effects=tuple(map(_on_axes, found.effects)),
        gear=None if found.reversals is None else _of_run(found.reversals),
        **given,
    )


def of_one_pose(kind: type[OnePose], found: Diagnosis, **given: Any) -> OnePose:
    """Return what is said of one pose, and ``given``."""
    return publish(
        kind, found, error=errors(found), repeatability=_repeatability(found.repeatability), **given
    )


def errors(found: Diagnosis | DiagnosisOfPoses) -> Errors:
    """Return the errors of the model as it was and with the effects."""
    return Errors(before=found.error_before, after=found.error_after)


def _repeatability(found: Repeatabilities) -> RepeatabilityOfModel:
    unseen = found.unseen
    return publish(
        RepeatabilityOfModel,
        found,
        completed=_foretold(found.completed),
        unseen=unseen and publish(OfUnseenCycles, unseen, completed=_foretold(unseen.completed)),
    )


def _foretold(told: Mapping[str, Foretold]) -> dict[str, ForetoldRP]:
    return {name: with_interval(ForetoldRP, one) for name, one in told.items()}


def with_interval(kind: type[Told], found: Estimated, **given: object) -> Told:
    """Return a published class of a result with its ends as an interval."""
    return publish(kind, found, interval=(found.low, found.high), **given)


def _on_axes(found: Found) -> EffectOnAxes:
    joint = int(found.joint[-1]) if found.joint in ("joint 1", "joint 2") else None
    return publish(EffectOnAxes, found, joint=joint, direction=found.joint)


def _of_run(found: RunReversals) -> GearOfRun | ReversalsAlone:
    if found.gear is None:
        return publish(ReversalsAlone, found, verdict=None)
    return of_gear(
        GearOfRun,
        found.gear,
        **{name: getattr(found, name) for name in ("reversals", "mirrored", "missing", "notes")},
    )


def of_gear(kind: type[Gear], found: GearDiagnosis, **given: Any) -> Gear:
    """Return what the model leaves of measured reversals, and ``given``."""
    error = GearErrorsOfModel(
        before=GearErrors(rms=found.rms_before, held_out_rms=found.held_out_before),
        after=GearErrors(rms=found.rms_after, held_out_rms=found.held_out_after),
    )
    return publish(kind, found, error=error, **given)
