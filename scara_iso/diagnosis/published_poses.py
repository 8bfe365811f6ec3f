"""What ``diagnose`` publishes of a test of several poses: schema ``scara-iso/diagnose/2``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias

from scara_iso.base.published import Interval, Probability, Size, publish
from scara_iso.diagnosis.joint_scatter.result import (
    FollowedInJoints,
    JointScatter,
    PoseLeftOut,
    ReachMap,
)
from scara_iso.diagnosis.poses_result import DiagnosisOfPoses, Separation
from scara_iso.diagnosis.published import (
    DiagnoseSchema,
    EffectFound,
    Errors,
    ForetoldRP,
    OfAxes,
    OfOnePose,
    StructureTested,
    errors,
    of_one_pose,
    with_interval,
)
from scara_iso.diagnosis.result import AtJoint, Found
from scara_iso.diagnosis.verdict import Rival

Place: TypeAlias = Literal[1, 2, 4, "along the arm"]
Correlation: TypeAlias = Annotated[float, ("minimum", -1), ("maximum", 1)]
Source: TypeAlias = Annotated[str, ("enum", ("joint 1", "joint 2", "dial", "neither"))]
OfPlane: TypeAlias = Mapping[Annotated[str, ("enum", ("X", "Y"))], Size]
_PLACES: Mapping[str, Place] = {
    "joint 1": 1,
    "joint 2": 2,
    "joint 4": 4,
    "along the arm": "along the arm",
}
_LEAST_PLACE = 0.001


@dataclass(frozen=True, kw_only=True)
class SizeAtJoint:
    """The size of an effect in its place."""

    value: float
    """In a joint, in the links (growth, of 1), or in an axis everywhere alike."""
    unit: Literal["rad", "1", "mm", "deg"]
    """Of it."""
    interval: Interval
    """95 %."""


@dataclass(frozen=True, kw_only=True)
class EffectAtPoses(EffectFound):
    """An effect that was found in a test of several poses."""

    joint: Place | None
    """Where in the arm; theta alike everywhere is joint 4 or its indicator."""
    direction: str | None
    """Its place; null where none is sure."""
    parameters: Mapping[str, float | str | tuple[int, ...] | Mapping[str, OfAxes]]
    """By name; sizes by pose and axis."""
    standard_errors: Mapping[str, Mapping[str, OfAxes]]
    """Standard error of each size, by pose and axis."""
    share: Mapping[str, OfAxes]
    """Of the variance of each axis at each pose."""
    poses: Annotated[tuple[str, ...], ("minItems", 1)]
    """At which it acts."""
    joint_candidates: tuple[Literal[1, 2], ...]
    """Joints that these poses do not tell apart."""
    size_at_joint: SizeAtJoint | None
    """Its size in its place."""
    places: Mapping[str, Probability]
    """How likely each is."""


@dataclass(frozen=True, kw_only=True)
class OfPose:
    """What an object is of."""

    pose: str
    """Its name."""


@dataclass(frozen=True, kw_only=True)
class PoseOfSeveral(OfOnePose, StructureTested, OfPose):
    """One pose of a test of several; what acts there stands in `effects` of the test."""


@dataclass(frozen=True, kw_only=True)
class AllPosesTogether(StructureTested, DiagnoseSchema):
    """What one search over all poses found."""

    effects: tuple[EffectAtPoses, ...]
    """In the order in which they were found."""
    candidates: tuple[Rival, ...]
    """Where it is `unexplained`: the nearest effects."""
    error: Errors
    """Measured minus predicted, over all poses."""
    joints_apart: Separation | None
    """How well the poses tell joint 1 from joint 2; null without the joints of every pose."""
    poses: Annotated[tuple[PoseOfSeveral, ...], ("minItems", 2)]
    """What is said of each."""


@dataclass(frozen=True, kw_only=True)
class ScatterOfSource:
    """A standard deviation."""

    value: Size
    """0 where the poses need none of it."""
    unit: Literal["rad", "mm"]
    """`rad` of a joint, else `mm`."""
    interval: tuple[Size, Size]
    """95 %."""
    share: float | None
    """Of the variance of X and Y, over the poses; null of `neither`."""


@dataclass(frozen=True, kw_only=True)
class CorrelationOfJoints:
    """How the joints scatter together."""

    value: Correlation
    """1: always to one side."""
    interval: tuple[Correlation, Correlation]
    """95 %."""
    p_value: Probability
    """Chance of as much in joints that scatter apart."""


@dataclass(frozen=True, kw_only=True)
class MisfitOfJoints:
    """Whether joints and dial are all that scatters."""

    ratio: Size
    """Variance of the poses about the fit over that of sampling: 1 by chance."""
    p_value: Probability
    """Chance of as much where joints and dial are all that scatters."""


@dataclass(frozen=True, kw_only=True)
class ForetoldPose:
    """A measured pose beside what the others foretell of it, for as many cycles."""

    measured: Size
    """RP in XY, radial, in mm."""
    effects_removed: Size
    """The same without the effects found, which the prediction does not hold."""
    predicted: ForetoldRP
    """From the other poses."""
    error: float | None
    """Predicted over `effects_removed`, less 1; null where nothing moved."""
    inside: bool
    """Whether `effects_removed` lies within the interval."""
    rms_before: OfPlane
    """About the means, in mm."""
    rms_after: OfPlane
    """Without the effects; of a pose held out, those of joints and dials found at the others."""


@dataclass(frozen=True, kw_only=True)
class PlaceOnMap:
    """A place in the reach."""

    x_mm: float
    """In the base frame."""
    y_mm: float
    """In the base frame."""
    RP: Size
    """Foretold there, radial in XY, in mm."""


@dataclass(frozen=True, kw_only=True)
class PublishedMap:
    """RP over the reach."""

    best: PlaceOnMap
    """Where RP is least."""
    worst: PlaceOnMap
    """Where RP is largest."""
    limit: float | None = None
    """RP in XY that is wanted, where one is."""
    share_kept: Probability | None = None
    """Of the reach at which it is kept."""


@dataclass(frozen=True, kw_only=True)
class FollowedSize:
    """How much a joint, a link or a dial follows a column."""

    value: float
    """In `unit`."""
    unit: str
    """Over that of the column, such as `rad/kg`."""
    interval: Interval
    """95 %."""


@dataclass(frozen=True, kw_only=True)
class FollowedColumn:
    """What follows a recorded column, traced to joints, links and dials."""

    effect: Literal["lost_motion", "compliance", "temperature"]
    """Of lost motion half of the distance of the approaches."""
    column: str
    """The recorded column."""
    misfit_p_value: Probability
    """Chance of poses that disagree as much where these sources are all."""
    sizes: Mapping[str, FollowedSize]
    """By joint, along the arm, X and Y everywhere: dial or datum."""


@dataclass(frozen=True, kw_only=True)
class TracedScatter:
    """Scatter traced to the joints, and RP at other poses from it."""

    joint_scatter: Mapping[Source, ScatterOfSource]
    """Standard deviation of each; `neither` acts in one direction at single poses."""
    joint_correlation: CorrelationOfJoints | None
    """Null where chance makes it."""
    joint_misfit: MisfitOfJoints
    """What joints and dial do not explain."""
    predicted_RP: Mapping[str, ForetoldRP]  # noqa: N815 - the standard's symbol
    """Radial in XY, of 30 cycles without effects, at poses that were not measured or held out."""
    left_out: Mapping[str, ForetoldPose]
    """Each measured pose, from the others."""
    left_out_rms: Size | None
    """Root mean square of the errors of the poses left out; null without any."""
    held_out: Mapping[str, ForetoldPose]
    """The pose that was held out from the beginning, if any."""
    map: PublishedMap | None = None
    """With a map or a limit asked for."""
    followed: tuple[FollowedColumn, ...] | None = None
    """What follows a recorded column, found or not."""


@dataclass(frozen=True, kw_only=True)
class NotesOfPoses:
    """What stands behind the poses."""

    notes: tuple[str, ...]
    """How the tables were read, and what could not be searched."""


@dataclass(frozen=True, kw_only=True)
class PosesDiagnosis(NotesOfPoses, AllPosesTogether):
    """``diagnose`` of several poses."""


@dataclass(frozen=True, kw_only=True)
class TracedPosesDiagnosis(NotesOfPoses, TracedScatter, AllPosesTogether):
    """``diagnose`` of several poses, with links and joints in the model."""


def published_poses_diagnosis(found: DiagnosisOfPoses) -> PosesDiagnosis | TracedPosesDiagnosis:
    """Return what ``diagnose`` says of several poses."""
    said: dict[str, Any] = {
        "schema": "scara-iso/diagnose/2",
        "unit": "mm",
        "effects": tuple(map(_at_poses, found.effects)),
        "error": errors(found),
        "joints_apart": found.separation,
        "poses": tuple(
            of_one_pose(PoseOfSeveral, one, pose=pose) for pose, one in found.poses.items()
        ),
    }
    traced = found.joint_scatter
    if traced is None:
        return publish(PosesDiagnosis, found, **said)
    followed = tuple(map(_followed, found.followed)) or None
    return publish(TracedPosesDiagnosis, found, **said, **_traced(traced), followed=followed)


def _at_poses(found: Found) -> EffectAtPoses:
    return publish(
        EffectAtPoses,
        found,
        joint=_PLACES.get(found.joint or ""),
        direction=found.place,
        size_at_joint=found.at_joint and _size(found.at_joint),
        places={name: p for name, p in found.places.items() if p >= _LEAST_PLACE},
    )


def _size(at: AtJoint) -> SizeAtJoint:
    half = 2 * at.standard_error
    return publish(SizeAtJoint, at, interval=(at.value - half, at.value + half))


def _traced(found: JointScatter) -> dict[str, Any]:
    """Return the fields of `TracedScatter`."""
    sources = found.sources.items()
    return {
        "joint_scatter": {name: with_interval(ScatterOfSource, one) for name, one in sources},
        "joint_correlation": found.together and with_interval(CorrelationOfJoints, found.together),
        "joint_misfit": MisfitOfJoints(ratio=found.misfit, p_value=found.misfit_p_value),
        "predicted_RP": {
            pose: with_interval(ForetoldRP, one) for pose, one in found.predicted_RP.items()
        },
        "left_out": {pose: _beside(one) for pose, one in found.left_out.items()},
        "left_out_rms": found.left_out_rms,
        "held_out": {pose: _beside(one) for pose, one in found.held_out.items()},
        "map": found.reach and _extremes(found.reach),
    }


def _followed(found: FollowedInJoints) -> FollowedColumn:
    sizes = {name: with_interval(FollowedSize, one) for name, one in found.sizes.items()}
    return publish(FollowedColumn, found, sizes=sizes)


def _beside(found: PoseLeftOut) -> ForetoldPose:
    return publish(ForetoldPose, found, predicted=with_interval(ForetoldRP, found.predicted))


def _extremes(reach: ReachMap) -> PublishedMap:
    kept = None if reach.limit is None else reach.share_kept
    return PublishedMap(
        best=_place(reach.best), worst=_place(reach.worst), limit=reach.limit, share_kept=kept
    )


def _place(found: tuple[float, float, float]) -> PlaceOnMap:
    return PlaceOnMap(**dict(zip(("x_mm", "y_mm", "RP"), found, strict=True)))
