"""What one search over all poses of a test says, and what their scatter comes from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import numpy as np

from scara_iso.base.displayed import Plotted
from scara_iso.base.published import (
    ALWAYS,
    INTERNAL,
    MERGED,
    Interval,
    Probability,
    Size,
    fill,
    publish,
    published,
)
from scara_iso.diagnosis.result import (
    DiagnoseSchema,
    Diagnosis,
    Errors,
    Foretold,
    FoundAtPoses,
    OfOnePose,
)
from scara_iso.diagnosis.verdict import Rival, StructureTested
from scara_iso.robot import DeclaredEffect
from scara_iso.run import FloatArray, make_frame

if TYPE_CHECKING:
    import pandas as pd


Correlation: TypeAlias = Annotated[float, ("minimum", -1), ("maximum", 1)]
Source: TypeAlias = Annotated[str, ("enum", ("joint 1", "joint 2", "dial", "neither"))]
OfPlane: TypeAlias = Mapping[Annotated[str, ("enum", ("X", "Y"))], Size]
_ALIKE = 9
"""Decimal places [mm] from which places of a ring about the base do not differ."""
_WIDTH = 3.92
"""Standard deviations in a 95 % interval."""


@dataclass(frozen=True, slots=True)
class SourceOfScatter:
    """A standard deviation."""

    value: Size
    """0 where the poses need none of it."""
    unit: Annotated[str, ("enum", ("rad", "mm"))]
    """`rad` of a joint, else `mm`."""
    interval: tuple[Size, Size]
    """95 %; from 0 where nothing speaks against none."""
    share: float | None = field(default=None, metadata=ALWAYS)
    """Of the variance of X and Y, over the poses, what joints do together halved between them; null
    of `neither`."""


@dataclass(frozen=True, slots=True)
class JointCorrelation:
    """How the joints scatter together."""

    value: Correlation
    """1: always to one side."""
    interval: tuple[Correlation, Correlation]
    """95 %."""
    p_value: Probability
    """Chance of as much in joints that scatter apart."""


@dataclass(frozen=True, slots=True)
class Misfit:
    """Whether joints and dial are all that scatters."""

    ratio: Size
    """Variance of the poses about the fit over that of sampling: 1 by chance."""
    p_value: Probability
    """Chance of as much where joints and dial are all that scatters."""


@dataclass(frozen=True, slots=True)
class PoseLeftOut:
    """A measured pose beside what the others foretell of it, for as many cycles."""

    measured: Size
    """RP in XY (7.2.2), in mm."""
    effects_removed: Size
    """The same without the effects found, which the prediction does not hold."""
    predicted: Foretold
    """From the other poses."""
    rms_before: OfPlane
    """About the means, in mm."""
    rms_after: OfPlane
    """Without the effects; of a pose held out, those of joints and dials found at the others."""
    error: float | None = field(init=False)
    """Predicted over `effects_removed`, less 1; null where nothing moved."""
    inside: bool = field(init=False)
    """Whether `effects_removed` lies within the interval."""

    def __post_init__(self) -> None:
        removed, (low, high) = self.effects_removed, self.predicted.interval
        error = self.predicted.value / removed - 1 if removed else None
        fill(self, error=error, inside=low <= removed <= high)


@dataclass(frozen=True, slots=True)
class PlaceOnMap:
    """A place in the reach."""

    x_mm: float
    """In the base frame."""
    y_mm: float
    """In the base frame."""
    RP: Size
    """Foretold there, radial in XY, in mm."""


@dataclass(frozen=True, eq=False, slots=True)
class ReachMap:
    """RP over the reach: a square of cells, nan where the arm does not come [mm]."""

    x: FloatArray = field(metadata=INTERNAL)
    """Middle of the columns, shape (m,)."""
    y: FloatArray = field(metadata=INTERNAL)
    """Middle of the rows, shape (k,)."""
    RP: FloatArray = field(metadata=INTERNAL)
    """Expected, shape (k, m)."""
    low: FloatArray = field(metadata=INTERNAL)
    """Lower end, likewise."""
    high: FloatArray = field(metadata=INTERNAL)
    """Upper end, likewise."""
    poses: Mapping[str, tuple[float, float]] = field(metadata=INTERNAL)
    """Where the poses are from which it is made: x, y."""
    best: PlaceOnMap = field(init=False)
    """Where RP is least."""
    worst: PlaceOnMap = field(init=False)
    """Where RP is largest."""
    limit: float | None = None
    """RP in XY that is wanted, where one is."""
    share_kept: Probability | None = field(init=False, default=None)
    """Of the reach at which it is kept, seen from above."""

    def __post_init__(self) -> None:
        RP = self.RP.round(_ALIKE)
        fill(self, best=self._at(np.nanargmin(RP)), worst=self._at(np.nanargmax(RP)))
        if self.limit is not None:
            fill(self, share_kept=float(np.nanmean(self.kept)))

    @property
    def kept(self) -> FloatArray:
        """Where the limit is kept: 1 where the upper end is at most that, else 0, nan outside."""
        limit = np.nan if self.limit is None else self.limit
        return np.asarray(np.where(np.isnan(self.high), np.nan, self.high <= limit))

    def _at(self, cell: np.intp) -> PlaceOnMap:
        row, column = divmod(int(cell), len(self.x))
        return PlaceOnMap(*map(float, (self.x[column], self.y[row], self.RP[row, column])))


@dataclass(frozen=True, slots=True)
class SizeInJoint:
    """How much a joint, a link or a dial follows a column."""

    value: float
    """In `unit`."""
    unit: str
    """`rad` of a joint, 1 of the growth of the links, `mm` of a dial; over that of the column, such
    as `rad/kg`."""
    interval: Interval
    """95 %."""


@dataclass(frozen=True, eq=False, slots=True)
class FollowedInJoints:
    """What follows a recorded column, traced to joints, links and dials."""

    effect: Annotated[str, ("enum", ("lost_motion", "compliance", "temperature"))]
    """Of lost motion half of the distance of the approaches."""
    column: str
    """The recorded column."""
    sizes: Mapping[str, SizeInJoint]
    """By joint, along the arm, X and Y everywhere: dial or datum."""
    misfit_p_value: Probability
    """Chance of poses that disagree as much where these sources are all."""


@dataclass(frozen=True, eq=False, slots=True)
class JointScatter:
    """Scatter traced to the joints, and RP at other poses from it."""

    sources: Mapping[Source, SourceOfScatter] = field(metadata=published("joint_scatter"))
    """Standard deviation of each; `neither` acts in one direction at single poses."""
    predicted_RP: Mapping[str, Foretold]  # noqa: N815 - the standard's symbol
    """Radial in XY, of 30 cycles without effects, at poses that were not measured or held out."""
    left_out: Mapping[str, PoseLeftOut]
    """Each measured pose, from the others."""
    held_out: Mapping[str, PoseLeftOut]
    """The pose that was held out from the beginning, if any."""
    together: JointCorrelation | None = field(metadata=published("joint_correlation"))
    """Null where chance makes it: the joints are then taken to scatter apart."""
    misfit: Misfit = field(metadata=published("joint_misfit"))
    """What joints and dial do not explain."""
    notes: tuple[str, ...] = field(default=(), metadata=INTERNAL)
    """What could not be told, one line each."""
    reach: ReachMap | None = field(default=None, metadata=published("map"))
    """With a map or a limit asked for."""
    left_out_rms: Size | None = field(init=False)
    """Root mean square of the errors of the poses left out; null without any."""

    def __post_init__(self) -> None:
        errors = [one.error for one in self.left_out.values() if one.error is not None]
        fill(self, left_out_rms=float(np.sqrt(np.mean(np.square(errors)))) if errors else None)

    @property
    def left_out_chance(self) -> float:
        """What the intervals say of that error: mostly the chance of the cycles at the pose."""
        predicted = [one.predicted for one in self.left_out.values()]
        widths = [(one.interval[1] - one.interval[0]) / one.value for one in predicted]
        return float(np.sqrt(np.mean(np.square(widths)))) / _WIDTH


@dataclass(frozen=True, eq=False, kw_only=True)
class PoseOfSeveral(OfOnePose):
    """One pose of a test of several; what acts there stands in `effects` of the test."""

    pose: str
    """Its name."""


def _each(poses: Mapping[str, Diagnosis]) -> Annotated[tuple[PoseOfSeveral, ...], ("minItems", 2)]:
    return tuple(publish(PoseOfSeveral, one, pose=pose) for pose, one in poses.items())


def _any_of(followed: tuple[FollowedInJoints, ...]) -> tuple[FollowedInJoints, ...] | None:
    return followed or None


def rms_by_axis(values: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Return the root mean square of each axis' values."""
    squares: dict[str, list[float]] = {}
    for axis, value in values:
        squares.setdefault(axis, []).append(value**2)
    return {axis: float(np.sqrt(np.mean(own))) for axis, own in squares.items()}


@dataclass(frozen=True, slots=True)
class Separation:
    """How well the poses of a test tell joint 1 from joint 2."""

    angle_deg: float
    """Between the movements of all axes, beside their scatter: 90 is best, 0 not at all."""
    observability_index: float
    """Smaller over larger singular value of the joints' movements (Nahvi and Hollerbach 1996)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DiagnosisOfPoses(StructureTested, DiagnoseSchema, Plotted):
    """``diagnose`` of several poses: what one search over all of them found."""

    poses: Mapping[str, Diagnosis] = field(metadata=published(by=_each))
    """What is said of each."""
    effects: tuple[FoundAtPoses, ...]
    """In the order in which they were found."""
    candidates: tuple[Rival, ...]
    """Where it is `unexplained`: the nearest effects."""
    error: Errors
    """Measured minus predicted, over all poses."""
    separation: Separation | None = field(
        default=None, metadata=published("joints_apart", always=True)
    )
    """How well the poses tell joint 1 from joint 2; null without the joints of every pose."""
    notes: tuple[str, ...] = ()
    """How the tables were read, and what could not be searched."""
    courses: tuple[FloatArray, ...] = field(default=(), metadata=INTERNAL)
    """Over the cycles, of each effect found, shape (n, k) for a known course, (n, 0) for none."""
    followed: tuple[FollowedInJoints, ...] = field(
        default=(), metadata=published(by=_any_of, always=False)
    )
    """What follows a recorded column, found or not."""
    joint_scatter: JointScatter | None = field(default=None, metadata=MERGED)
    """With links and joints in the model."""

    @property
    def scatter(self) -> dict[str, float]:
        """Standard deviation of each axis beside effects and rounding: of all poses, in rms."""
        return rms_by_axis(pair for one in self.poses.values() for pair in one.scatter.items())

    def __getitem__(self, at: int | str) -> Diagnosis:
        """Return the diagnosis of a pose by its number or its name."""
        if not isinstance(at, str):
            return list(self.poses.values())[at]
        if at not in self.poses:
            raise KeyError(f"no pose {at!r}: there is {', '.join(self.poses)}")
        return self.poses[at]

    def __repr__(self) -> str:
        named = ", ".join(f"{pose} {one.verdict.value}" for pose, one in self.poses.items())
        return f"<DiagnosisOfPoses: {named}>"

    def to_frame(self) -> pd.DataFrame:
        """Return the series of every pose below each other, as `Diagnosis.to_frame`, by pose."""
        frames = [one.to_frame() for one in self.poses.values()]
        counts = [len(frame) for frame in frames]
        columns = {
            str(name): np.concatenate([frame[name].to_numpy() for frame in frames])
            for name in frames[0]
        }
        poses = np.repeat(np.array(list(self.poses)), counts)
        return make_frame({"pose": poses, **columns}, {"verdict": self.verdict.value})


def declared_in_arm(found: FoundAtPoses) -> DeclaredEffect | None:
    """Return an effect of all poses as one that a model declares: in its joint, or in an axis.

    None where it is sure of neither: a model knows no effect of one pose alone.
    """
    at, place = found.at_joint, found.place or ""
    if at is None:
        return None
    axis = "theta" if place == "joint 4" else place.removesuffix(" everywhere")
    shape: dict[str, Any] = {
        k: v
        for k, v in found.parameters.items()
        if k not in at.parameters and not isinstance(v, tuple)
    }
    sizes = {name: {axis: value} for name, value in at.parameters.items()}
    return DeclaredEffect(found.effect, {**shape, **sizes})
