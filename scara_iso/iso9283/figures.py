"""The figures of a test: what each axis, plane, space and pose has, and how it is computed.

Lengths are in mm; theta is in degrees where it was given as an angle.

Results of several poses, found by number or by name.

How a figure is held against its limit, and what comes of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Protocol, SupportsIndex, TypeAlias, TypeVar, overload

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.published import Count, Interval, Size, Unit
from scara_iso.base.quantities import Dimension, Estimate, parse_number, within_half_a_turn
from scara_iso.iso9283.cycles import Rows
from scara_iso.iso9283.statistics import (
    SamplingInterval,
    repeatability,
    root_sum_of_squares,
    rp_interval,
    rss_interval,
    standard_deviation,
    three_sigma_interval,
)
from scara_iso.iso9283.uncertainty import (
    largest_calibration,
    reading_uncertainty,
    scatter_estimates,
)
from scara_iso.run import Axis, FloatArray, IntArray, Run, step_of


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


Limit: TypeAlias = float | tuple[float, float]
"""The largest value that is allowed, or the smallest and the largest."""


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


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class AxisFigures:
    """What is published of one indicator axis at one pose; see paper eq. 2-6 for the symbols."""

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
    RP: Size
    """l_bar + 3 S_l, eq. 6, in `unit`."""
    RP_interval: Interval | None
    """95 %: chance, dial and calibration; None for fewer than five cycles, or where one reading
    carries the figure."""
    three_sigma: Size
    """Three sample standard deviations, in `unit`; ISO 9283's RP_a for an angle."""
    three_sigma_interval: Interval | None
    """95 %, as of RP."""
    resolution: Size | None
    """Smallest step of the dial, in `unit`; None where not stated."""
    uncertainty: Size | None
    """Standard uncertainty of one reading, in `unit`: resolution and indicator combined (GUM
    5.1.2)."""
    uncertainty_ratio: Size | None
    """Uncertainty over RP; None where either is missing or RP is 0."""
    accuracy: float | None
    """AP: mean minus command pose, ISO 9283 7.2.1, in `unit`; None where no command pose is stated,
    or the dial's zero is not referred to it."""
    angle: ThetaAngle | None = None
    """Theta, read as a length, as an angle; not without ``theta_radius_mm``."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class AxisResult(AxisFigures):
    """One indicator axis at one pose, with what its figures are made of."""

    name: str
    """``X``, ``Y``, ``Z`` or ``theta``."""
    dimension: Dimension
    """Length or angle."""
    readings: FloatArray = field(repr=False)
    """The readings that count, shape (n,), in `unit`."""
    repeatability: Estimate
    """RP with its uncertainty."""
    three_S: Estimate  # noqa: N815 - the standard's symbol
    """Likewise three sample standard deviations."""
    calibration: float | None
    """Standard uncertainty of the indicator, as its certificate states it."""
    definitions: tuple[Definition, ...] = ()
    """Other definitions of repeatability, where they were asked for."""

    @property
    def expanded_ratio(self) -> float | None:
        """U = 2 u over the figure (of an angle 3 S), as the 25 % rule compares them; or None."""
        figure = self.RP if self.dimension is Dimension.LENGTH else self.three_sigma
        return None if self.uncertainty is None or figure == 0 else 2 * self.uncertainty / figure


@dataclass(frozen=True, slots=True, kw_only=True)
class SpaceFigures:
    """Several lengths together, by the distance to the barycentre."""

    RP_radial: Millimetres
    """l_bar + 3 S_l of the distances, ISO 9283 7.2.2."""
    RP_radial_interval: Interval | None
    """95 %; null where so few cycles allow none."""
    l_bar: Millimetres
    """Mean distance to the barycentre."""
    S_l: Millimetres
    """Standard deviation of these distances, n - 1."""
    uncertainty: Millimetres | None
    """Standard, of one distance; null where an axis states none."""
    uncertainty_ratio: Size | None
    """Uncertainty over RP_radial."""
    accuracy: Millimetres | None
    """AP, ISO 9283 7.2.1: distance from the command pose; null where that is not stated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RadialResult(SpaceFigures):
    """Several length axes together: ISO 9283 7.2.2, and the paper's eq. 23 for the plane."""

    repeatability: Estimate
    """RP_radial with its uncertainty."""
    root_sum_of_squares: Estimate | None
    """Of the axes' RP, eq. 23; None in space."""
    calibration: float | None
    """The indicators' part of `uncertainty`; None where none states one."""

    @property
    def RP(self) -> float:  # noqa: N802 - the standard's symbol
        """`RP_radial`, by the name that an axis has for it."""
        return self.RP_radial

    @property
    def RP_interval(self) -> Interval | None:  # noqa: N802
        """`RP_radial_interval`, likewise."""
        return self.RP_radial_interval

    @property
    def RP_rss(self) -> float | None:  # noqa: N802
        """Value of `root_sum_of_squares`."""
        return None if self.root_sum_of_squares is None else self.root_sum_of_squares.value

    @property
    def RP_rss_interval(self) -> Interval | None:  # noqa: N802
        """95 %, of `root_sum_of_squares`."""
        return None if self.root_sum_of_squares is None else self.root_sum_of_squares.interval

    @property
    def expanded_ratio(self) -> float | None:
        """U = 2 u over RP, as the 25 % rule compares them; or None."""
        return None if self.uncertainty_ratio is None else 2 * self.uncertainty_ratio


@dataclass(frozen=True, eq=False, slots=True)
class PoseResult:
    """One pose: its axes, and XY and XYZ where those axes are lengths."""

    label: str | None
    """Name of the pose; None where the table names none."""
    rows: IntArray = field(repr=False)
    """Rows of the run that count, shape (n,), from 0."""
    cycle: IntArray = field(repr=False)
    """Their cycle numbers, shape (n,)."""
    axes: Mapping[str, AxisResult]
    """By name."""
    XY: RadialResult | None
    """In the plane; None without X and Y as lengths."""
    XYZ: RadialResult | None
    """In space; None without X, Y and Z as lengths."""
    missing: tuple[tuple[int, int], ...] = ()
    """First and last number of each gap in the cycles."""

    @property
    def figures(self) -> Mapping[str, AxisResult | RadialResult]:
        """Axes, then XY and XYZ where they are there, by name."""
        radial = {"XY": self.XY, "XYZ": self.XYZ}
        return {**self.axes, **{name: found for name, found in radial.items() if found}}


def axis_results(run: Run, axis: Axis, chosen: Rows) -> list[AxisResult]:
    """Return the figures of one axis at each pose."""
    readings = axis.readings[chosen.rows]
    positions = readings[:, np.newaxis, :]
    folded = repeatability(positions)
    RP = _estimates(rp_interval, folded.RP, positions, [axis])
    spread = 3 * standard_deviation(readings)
    three_S = _estimates(three_sigma_interval, spread, positions, [axis])
    radius = _theta_radius(run, axis)
    uncertainty = reading_uncertainty(axis)
    return [
        AxisResult(
            name=axis.name,
            dimension=axis.dimension,
            unit=axis.dimension.value,
            readings=readings[k],
            n=readings.shape[1],
            mean=float(folded.mean[k, 0]),
            l_bar=float(folded.l_bar[k]),
            S_l=float(folded.S_l[k]),
            repeatability=RP[k],
            RP=RP[k].value,
            RP_interval=RP[k].interval,
            three_S=three_S[k],
            three_sigma=three_S[k].value,
            three_sigma_interval=three_S[k].interval,
            resolution=axis.resolution,
            uncertainty=uncertainty,
            uncertainty_ratio=_ratio(uncertainty, RP[k].value),
            calibration=axis.uncertainty,
            accuracy=_accuracy(run, axis, chosen.poses[k], float(folded.mean[k, 0])),
            angle=_theta_angle(RP[k].value, three_S[k].value, radius),
        )
        for k in range(len(readings))
    ]


def _ratio(uncertainty: float | None, RP: float) -> float | None:
    return None if uncertainty is None or RP == 0 else uncertainty / RP


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
            f"theta_radius_mm is {text!r}",
            where=run.origin.source,
            remedy="give the distance from the axis of rotation to the contact in mm",
        )
    return radius


def _theta_angle(RP: float, three_sigma: float, radius: float | None) -> ThetaAngle | None:
    if radius is None:
        return None
    # The paper gives theta as a length and no formula: arc over radius is decided here; chord and
    # tangent differ from it by less than 1e-4 of the figure below one degree.
    return ThetaAngle(radius, math.degrees(RP / radius), math.degrees(three_sigma / radius))


def radial_results(run: Run, chosen: Rows, names: str) -> Sequence[RadialResult | None]:
    """Return the figures of ``XY`` or ``XYZ`` at each pose; None where they are not all lengths."""
    axes = [run.axes[name] for name in names if name in run.axes]
    if len(axes) < len(names) or any(axis.dimension is not Dimension.LENGTH for axis in axes):
        return [None] * len(chosen.poses)
    positions = np.stack([axis.readings[chosen.rows] for axis in axes], axis=1)
    folded = repeatability(positions)
    RP = _estimates(rp_interval, folded.RP, positions, axes)
    offsets = [
        [_accuracy(run, axis, pose, mean) for axis, mean in zip(axes, means, strict=True)]
        for pose, means in zip(chosen.poses, folded.mean.tolist(), strict=True)
    ]
    parts = [u for u in map(reading_uncertainty, axes) if u is not None]
    # A distance to the barycentre is no less certain than its least certain axis.
    uncertainty = max(parts) if len(parts) == len(axes) else None
    rss = _estimates(
        rss_interval, root_sum_of_squares(positions), positions, axes, clause="paper eq. 23"
    )
    return [
        RadialResult(
            repeatability=RP[k],
            RP_radial=RP[k].value,
            RP_radial_interval=RP[k].interval,
            l_bar=float(folded.l_bar[k]),
            S_l=float(folded.S_l[k]),
            root_sum_of_squares=rss[k] if names == "XY" else None,
            uncertainty=uncertainty,
            uncertainty_ratio=_ratio(uncertainty, RP[k].value),
            calibration=largest_calibration(axes),
            accuracy=_distance(offsets[k]),
        )
        for k in range(len(positions))
    ]


def _distance(offsets: Sequence[float | None]) -> float | None:
    known = [offset for offset in offsets if offset is not None]
    return math.hypot(*known) if len(known) == len(offsets) else None


def _estimates(
    interval: SamplingInterval,
    figures: FloatArray,
    positions: FloatArray,
    axes: Sequence[Axis],
    *,
    clause: str = "7.2.2",
) -> list[Estimate]:
    return scatter_estimates(
        interval,
        figures,
        positions,
        steps=[step_of(axis) for axis in axes],
        calibration=largest_calibration(axes),
        unit=axes[0].unit,
        clause=clause,
    )
