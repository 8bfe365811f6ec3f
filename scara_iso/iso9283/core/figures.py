"""The figures of a test: what each axis, plane, space and pose has, and how it is computed.

Lengths are in mm; theta is in degrees where it was given as an angle.

Results of several poses, found by number or by name.

How a figure is held against its limit, and what comes of it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Protocol, SupportsIndex, TypeAlias, TypeVar, overload

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.published import INTERNAL, Count, Interval, Size, Unit, fill, publish, published
from scara_iso.base.quantities import Dimension, Estimate, parse_number, within_half_a_turn
from scara_iso.iso9283.core.statistics import (
    largest_calibration,
    lengths,
    reading_uncertainty,
    repeatability,
    root_sum_of_squares,
    rp_interval,
    rss_interval,
    scatter_estimate,
    standard_deviation,
    three_sigma_interval,
)
from scara_iso.run import Axis, AxisKey, FloatArray, IntArray, Run


class Labelled(Protocol):
    """What belongs to a pose."""

    @property
    def label(self) -> str | None:
        """Name of the pose, None for the only one."""


OfPose = TypeVar("OfPose", bound=Labelled)


class Poses(tuple[OfPose, ...]):
    """The poses in their order: ``poses[0]`` and ``poses["P1"]``; `KeyError` for another name."""

    __slots__ = ()

    @overload
    def __getitem__(self, at: SupportsIndex | str) -> OfPose: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[OfPose, ...]: ...

    def __getitem__(self, at: SupportsIndex | str | slice) -> OfPose | tuple[OfPose, ...]:
        if not isinstance(at, str):
            return super().__getitem__(at)
        for pose in self:
            if pose.label == at:
                return pose
        there = ", ".join(pose.label for pose in self if pose.label is not None)
        said = f"there is {there}" if there else "the table names none, take poses[0]"
        raise KeyError(f"no pose {at!r}: {said}")


EVERY_LENGTH = ""
"""Key of a limit that holds for every repeatability of a length without a limit of its own."""


Limit: TypeAlias = float | str | tuple[float | str, float | str]
"""The largest value that is allowed, or the smallest and the largest; as text with a unit."""


class DecisionRule(Enum):
    """The rule by which a figure is held against its limit; the value is the word in outputs."""

    INTERVAL = "interval"
    """The figure's 95 % interval: proven inside, proven outside, or neither."""
    SIMPLE = "simple"
    """The figure alone, its uncertainty not counted: simple acceptance (JCGM 106, 8.2)."""


class Conformity(Enum):
    """Whether a limit is kept; the value is the word used in outputs."""

    PASS = "pass"  # noqa: S105 - no word to be kept
    FAIL = "fail"
    NOT_PROVABLE = "not-provable"


Millimetres = Annotated[float, ("unit", "mm"), ("minimum", 0)]


@dataclass(frozen=True, slots=True)
class Definition:
    """Another trade's word for repeatability, from the same readings."""

    name: str
    """``half range``, ``2 s`` and so on."""
    value: float
    """In the unit of the axis."""
    meaning: str
    """What it is, in words."""


@dataclass(frozen=True, slots=True)
class ThetaAngle:
    """A theta read as a length, turned into an angle by the radius of the contact."""

    radius_mm: Size
    """From the axis of theta to the contact [mm]."""
    RP_deg: Size
    """Eq. 2-6 on the angles."""
    three_sigma_deg: Size
    """ISO 9283 7.2.2: RP_a = +/- 3 S_a."""


def values_by_name(found: tuple[Definition, ...]) -> Mapping[str, float] | None:
    """Return the value of each definition, in the unit of the axis; None without any."""
    return {one.name: one.value for one in found} or None


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class AxisResult:
    """The figures of one axis at one pose; see paper eq. 2-6 for the symbols."""

    name: str = field(metadata=INTERNAL)
    """``X``, ``Y``, ``Z`` or ``theta``."""
    dimension: Dimension = field(metadata=INTERNAL)
    """Length or angle."""
    readings: FloatArray = field(repr=False, metadata=INTERNAL)
    """The readings that count, shape (n,), in `unit`."""
    unit: Unit
    """Of every figure here."""
    n: Count
    """Number of cycles that count."""
    mean: float
    """Barycentre: mean of the readings, eq. 2, in `unit`."""
    l_bar: Size
    """Mean distance of the readings from their mean, eq. 3 to 4, in `unit`."""
    S_l: Size
    """Standard deviation of these distances with n - 1, eq. 5, in `unit`."""
    RP: Size = field(init=False)
    """l_bar + 3 S_l, eq. 6, in `unit`; of an angle the standard's figure is `three_sigma`."""
    RP_interval: Interval | None = field(init=False)
    """95 %: chance, dial and calibration; None for fewer than five cycles, or where one reading
    carries the figure."""
    repeatability: Estimate = field(metadata=INTERNAL)
    """RP with its uncertainty."""
    three_sigma: Size = field(init=False)
    """Three sample standard deviations, in `unit`; ISO 9283's RP_a for an angle."""
    three_sigma_interval: Interval | None = field(init=False)
    """95 %, as of RP."""
    three_S: Estimate = field(metadata=INTERNAL)  # noqa: N815 - the standard's symbol
    """`three_sigma` with its uncertainty."""
    resolution: Size | None
    """Smallest step of the dial, in `unit`; None where not stated."""
    calibration: float | None = field(metadata=INTERNAL)
    """Standard uncertainty of the indicator, as its certificate states it."""
    uncertainty: Size | None
    """Standard uncertainty of one reading, in `unit`: resolution and indicator combined (GUM
    5.1.2)."""
    uncertainty_ratio: Size | None = field(init=False)
    """Uncertainty over RP; None where either is missing or RP is 0."""
    accuracy: float | None
    """AP: mean minus command pose, ISO 9283 7.2.1, in `unit`; None where no command pose is stated,
    or the dial's zero is not referred to it."""
    angle: ThetaAngle | None = None
    """Theta, read as a length, as an angle; not without ``theta_radius_mm``."""
    definitions: tuple[Definition, ...] = field(
        default=(), metadata=published(by=values_by_name, always=False)
    )
    """Where asked for: other words for repeatability, in the unit of the axis."""

    def __post_init__(self) -> None:
        RP, three_S = self.repeatability, self.three_S
        fill(self, RP=RP.value, RP_interval=RP.interval)
        fill(self, three_sigma=three_S.value, three_sigma_interval=three_S.interval)
        fill(self, uncertainty_ratio=_over(self.uncertainty, RP.value))

    @property
    def expanded_ratio(self) -> float | None:
        """U = 2 u over the figure (of an angle 3 S), as the 25 % rule compares them; or None."""
        figure = self.RP if self.dimension is Dimension.LENGTH else self.three_sigma
        ratio = _over(self.uncertainty, figure)
        return None if ratio is None else 2 * ratio


@dataclass(frozen=True, slots=True, kw_only=True)
class RadialResult:
    """Several lengths together, by the distance to the barycentre."""

    RP_radial: Millimetres = field(init=False)
    """l_bar + 3 S_l of the distances, ISO 9283 7.2.2."""
    RP_radial_interval: Interval | None = field(init=False)
    """95 %; None where so few cycles allow none."""
    repeatability: Estimate = field(metadata=INTERNAL)
    """RP_radial with its uncertainty."""
    l_bar: Millimetres
    """Mean distance to the barycentre."""
    S_l: Millimetres
    """Standard deviation of these distances, n - 1."""
    uncertainty: Millimetres | None
    """Standard, of one distance; None where an axis states none."""
    calibration: float | None = field(metadata=INTERNAL)
    """The indicators' part of `uncertainty`; None where none states one."""
    uncertainty_ratio: Size | None = field(init=False)
    """Uncertainty over RP_radial."""
    accuracy: Millimetres | None
    """AP, ISO 9283 7.2.1: distance from the command pose; None where that is not stated."""

    def __post_init__(self) -> None:
        found = self.repeatability
        fill(self, RP_radial=found.value, RP_radial_interval=found.interval)
        fill(self, uncertainty_ratio=_over(self.uncertainty, found.value))

    @property
    def RP(self) -> float:  # noqa: N802 - the standard's symbol
        """`RP_radial`, by the name that an axis has for it."""
        return self.RP_radial

    @property
    def RP_interval(self) -> Interval | None:  # noqa: N802
        """`RP_radial_interval`, likewise."""
        return self.RP_radial_interval

    @property
    def expanded_ratio(self) -> float | None:
        """U = 2 u over RP, as the 25 % rule compares them; or None."""
        return None if self.uncertainty_ratio is None else 2 * self.uncertainty_ratio


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneResult(RadialResult):
    """X and Y together: ISO 9283 7.2.2, and the paper's eq. 23."""

    RP_rss: Millimetres = field(init=False)
    """Root of the sum of squares of the axes' RP, paper eq. 23."""
    RP_rss_interval: Interval | None = field(init=False)
    """95 %, of RP_rss."""
    root_sum_of_squares: Estimate = field(metadata=INTERNAL)
    """RP_rss with its uncertainty."""

    def __post_init__(self) -> None:
        RadialResult.__post_init__(self)  # a class with slots is not its own super's
        found = self.root_sum_of_squares
        fill(self, RP_rss=found.value, RP_rss_interval=found.interval)


@dataclass(frozen=True, eq=False, slots=True)
class PoseResult:
    """One pose: its axes, and XY and XYZ where those axes are lengths."""

    label: str | None = field(metadata=published("pose"))
    """Its name; None without poses; `P1 from +x`, or `+x`, for one of several directions."""
    rows: IntArray = field(repr=False, metadata=INTERNAL)
    """Rows of the run that count, shape (n,), from 0."""
    cycle: IntArray = field(repr=False, metadata=INTERNAL)
    """Their cycle numbers, shape (n,)."""
    axes: Mapping[AxisKey, AxisResult]
    """By name."""
    XY: PlaneResult | None = None
    """Where X and Y are lengths."""
    XYZ: RadialResult | None = None
    """Where X, Y and Z are lengths."""
    missing: tuple[tuple[int, int], ...] = field(default=(), metadata=INTERNAL)
    """First and last number of each gap in the cycles."""

    @property
    def figures(self) -> Mapping[str, AxisResult | RadialResult]:
        """Axes, then XY and XYZ where they are there, by name."""
        radial = {"XY": self.XY, "XYZ": self.XYZ}
        return {**self.axes, **{name: found for name, found in radial.items() if found}}


def axis_result(run: Run, axis: Axis, pose: str | None, rows: IntArray) -> AxisResult:
    """Return the figures of one axis at a pose, by the rows that count."""
    readings = axis.readings[rows]
    positions = readings[np.newaxis, :]
    folded = repeatability(positions)
    mean, sigmas = float(folded.mean[0]), 3 * standard_deviation(readings)
    RP = scatter_estimate(rp_interval, folded.RP, positions, [axis])
    three_S = scatter_estimate(three_sigma_interval, sigmas, positions, [axis])
    radius = _theta_radius(run, axis)
    return AxisResult(
        name=axis.name,
        dimension=axis.dimension,
        unit=axis.dimension.value,
        readings=readings,
        n=len(readings),
        mean=mean,
        l_bar=float(folded.l_bar),
        S_l=float(folded.S_l),
        repeatability=RP,
        three_S=three_S,
        resolution=axis.resolution,
        uncertainty=reading_uncertainty(axis),
        calibration=axis.uncertainty,
        accuracy=_accuracy(run, axis, pose, mean),
        angle=None if radius is None else _theta_angle(RP, three_S, radius),
    )


def _over(uncertainty: float | None, figure: float) -> float | None:
    return None if uncertainty is None or figure == 0 else uncertainty / figure


def _accuracy(run: Run, axis: Axis, pose: str | None, mean: float) -> float | None:
    """Return mean minus command (7.2.1), where the dial's zero is referred to the command pose."""
    command = run.command_of(axis.name, pose)
    if command is None or not run.dial_zero_is_command:
        return None
    return within_half_a_turn(mean - command) if axis.unit == "deg" else mean - command


def _theta_radius(run: Run, axis: Axis) -> float | None:
    text = run.metadata.get("theta_radius_mm")
    if text is None or axis.name != "theta" or axis.dimension is not Dimension.LENGTH:
        return None
    radius = parse_number(text)
    if radius is None or radius <= 0:
        raise DataError(
            f"theta_radius_mm is {text!r}, not a length",
            where=run.origin.source,
            remedy="give the distance from the axis of rotation to the contact in mm",
        )
    return radius


def _theta_angle(RP: Estimate, three_S: Estimate, radius: float) -> ThetaAngle:
    # The paper gives theta as a length and no formula: arc over radius is decided here; chord and
    # tangent differ from it by less than 1e-4 of the figure below one degree.
    return ThetaAngle(radius, *(math.degrees(one.value / radius) for one in (RP, three_S)))


def radial_result(run: Run, names: str, pose: str | None, rows: IntArray) -> RadialResult | None:
    """Return the figures of ``XY`` or ``XYZ`` at a pose; None where they are not all lengths."""
    axes = lengths(run, names)
    if not axes:
        return None
    positions = np.stack([axis.readings[rows] for axis in axes])
    folded = repeatability(positions)
    parts = [u for u in map(reading_uncertainty, axes) if u is not None]
    return RadialResult(
        repeatability=scatter_estimate(rp_interval, folded.RP, positions, axes),
        l_bar=float(folded.l_bar),
        S_l=float(folded.S_l),
        # A distance to the barycentre is no less certain than its least certain axis.
        uncertainty=max(parts) if len(parts) == len(axes) else None,
        calibration=largest_calibration(axes),
        accuracy=_distance(run, axes, pose, folded.mean.tolist()),
    )


def plane_result(run: Run, pose: str | None, rows: IntArray) -> PlaneResult | None:
    """Return the figures of X and Y at a pose; None where they are not both lengths."""
    found, axes = radial_result(run, "XY", pose, rows), lengths(run, "XY")
    if found is None:
        return None
    positions = np.stack([axis.readings[rows] for axis in axes])
    figure = root_sum_of_squares(positions)
    rss = scatter_estimate(rss_interval, figure, positions, axes, clause="paper eq. 23")
    return publish(PlaneResult, found, root_sum_of_squares=rss)


def _distance(
    run: Run, axes: Sequence[Axis], pose: str | None, means: Sequence[float]
) -> float | None:
    offsets = [_accuracy(run, axis, pose, mean) for axis, mean in zip(axes, means, strict=True)]
    known = [offset for offset in offsets if offset is not None]
    return math.hypot(*known) if len(known) == len(offsets) else None
