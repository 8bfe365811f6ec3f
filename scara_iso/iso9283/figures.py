"""The figures of a test, frozen: of each axis, of plane and space, of each pose.

Lengths are in mm; theta is in degrees where it was given as an angle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from scara_iso.published import Count, Interval, Size, Unit
from scara_iso.quantities import Dimension, Estimate
from scara_iso.run import FloatArray, IntArray


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


@dataclass(frozen=True, slots=True)
class RadialResult:
    """Several length axes together: ISO 9283 7.2.2, and the paper's eq. 23 for the plane."""

    repeatability: Estimate
    """l_bar + 3 S_l of the distances to the barycentre."""
    l_bar: float
    """Mean distance to the barycentre [mm]."""
    S_l: float
    """Standard deviation of these distances, n - 1 [mm]."""
    root_sum_of_squares: Estimate | None
    """Of the axes' RP, eq. 23; None in space."""
    uncertainty: float | None
    """Standard uncertainty of a distance to the barycentre; None where an axis states none."""
    calibration: float | None
    """The indicators' part of it; None where none states one."""
    accuracy: float | None
    """Distance from the command pose to the barycentre, 7.2.1."""

    @property
    def RP(self) -> float:  # noqa: N802 - the standard's symbol
        """Value of `repeatability`."""
        return self.repeatability.value

    @property
    def RP_interval(self) -> Interval | None:  # noqa: N802
        """95 %, as of an axis."""
        return self.repeatability.interval

    @property
    def RP_rss(self) -> float | None:  # noqa: N802
        """Value of `root_sum_of_squares`."""
        return None if self.root_sum_of_squares is None else self.root_sum_of_squares.value

    @property
    def RP_rss_interval(self) -> Interval | None:  # noqa: N802
        """95 %, of `root_sum_of_squares`."""
        return None if self.root_sum_of_squares is None else self.root_sum_of_squares.interval

    @property
    def uncertainty_ratio(self) -> float | None:
        """Uncertainty over RP; None where either is missing or RP is 0."""
        return None if self.uncertainty is None or self.RP == 0 else self.uncertainty / self.RP

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
