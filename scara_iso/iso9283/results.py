"""What an analysis yields: frozen figures with their units, and findings about them.

Lengths are in mm; theta is in degrees where it was given as an angle. No result prints, plots or
converts itself: `report` says it and `render` shows it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from scara_iso.frames import make_frame
from scara_iso.iso9283.by_name import Poses
from scara_iso.iso9283.conformity import Conformity, DecisionRule
from scara_iso.quantities import Dimension, Estimate
from scara_iso.run import FloatArray, IntArray, Run

if TYPE_CHECKING:
    import pandas as pd

Severity = Literal["error", "warning", "info"]
Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Definition:
    """Another trade's word for repeatability, from the same readings."""

    name: str
    value: float
    meaning: str


@dataclass(frozen=True, slots=True)
class ThetaAngle:
    """A theta read as a length, turned into an angle by the radius of the contact."""

    radius_mm: float
    RP_deg: float
    """Eq. 2-6 on the angles."""
    three_sigma_deg: float
    """ISO 9283 7.2.2: RP_a = +/- 3 S_a."""


@dataclass(frozen=True, eq=False, slots=True)
class AxisResult:
    """One indicator axis at one pose; see paper eq. 2-6 for the symbols."""

    name: str
    dimension: Dimension
    readings: FloatArray = field(repr=False)
    """The readings that count, shape (n,), in `unit`."""
    mean: float
    l_bar: float
    S_l: float
    repeatability: Estimate
    """l_bar + 3 S_l, eq. 6."""
    three_S: Estimate  # noqa: N815 - the standard's symbol
    """Three sample standard deviations; ISO 9283's RP_a for an angle."""
    resolution: float | None
    uncertainty: float | None
    """Standard uncertainty of one reading: resolution and indicator combined (GUM 5.1.2)."""
    calibration: float | None
    """Standard uncertainty of the indicator, as its certificate states it."""
    accuracy: float | None = None
    """Mean minus command pose, ISO 9283 7.2.1; None where no command pose is stated, or the dial's
    zero is not referred to it."""
    angle: ThetaAngle | None = None
    definitions: tuple[Definition, ...] = ()

    @property
    def RP(self) -> float:  # noqa: N802 - the standard's symbol
        """Value of `repeatability`."""
        return self.repeatability.value

    @property
    def RP_interval(self) -> Interval | None:  # noqa: N802
        """95 %: chance, dial and calibration.

        None for fewer than five cycles, or where one reading carries the figure.
        """
        return self.repeatability.interval

    @property
    def three_sigma(self) -> float:
        """Value of `three_S`."""
        return self.three_S.value

    @property
    def three_sigma_interval(self) -> Interval | None:
        """Likewise, of `three_S`."""
        return self.three_S.interval

    @property
    def n(self) -> int:
        """Number of cycles that count."""
        return len(self.readings)

    @property
    def unit(self) -> str:
        """Unit of every figure here: ``mm`` or ``deg``."""
        return self.dimension.value

    @property
    def uncertainty_ratio(self) -> float | None:
        """Uncertainty over RP; None where either is missing or RP is 0."""
        return None if self.uncertainty is None or self.RP == 0 else self.uncertainty / self.RP

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
    S_l: float
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
    rows: IntArray = field(repr=False)
    """Rows of the run that count, shape (n,), from 0."""
    cycle: IntArray = field(repr=False)
    """Their cycle numbers, shape (n,)."""
    axes: Mapping[str, AxisResult]
    XY: RadialResult | None
    XYZ: RadialResult | None
    missing: tuple[tuple[int, int], ...] = ()
    """First and last number of each gap in the cycles."""

    @property
    def figures(self) -> Mapping[str, AxisResult | RadialResult]:
        """Axes, then XY and XYZ where they are there, by name."""
        radial = {"XY": self.XY, "XYZ": self.XYZ}
        return {**self.axes, **{name: found for name, found in radial.items() if found}}


@dataclass(frozen=True, slots=True)
class Cycles:
    """How many cycles each pose has in the table, which were left out, how many count.

    Where gaps are allowed: of the pose with the fewest.
    """

    read: int
    discarded: tuple[int, ...]
    used: int
    all_count: bool = False
    """Whether it is stated that every row counts: none was discarded, here or before."""


@dataclass(frozen=True, slots=True)
class Measured:
    """The figures of a run, before anything is said about them."""

    run: Run
    cycles: Cycles
    poses: Poses


@dataclass(frozen=True, slots=True)
class Finding:
    """Something the user should know; ``rule`` names what the test departs from, if it does."""

    code: str
    severity: Severity
    message: str
    axis: str | None = None
    pose: str | None = None
    rule: str = ""
    voids_interval: bool = False
    """Whether the 95 % interval of its axis and pose, and of what is made of it, does not hold."""


@dataclass(frozen=True, slots=True)
class LimitCheck:
    """One figure against a limit that the user gave; lengths in mm, angles in degrees."""

    figure: str
    """``X``, ``XY`` and so on, with the code where it is no repeatability of a pose: ``RD X``."""
    code: str
    """Of the characteristic."""
    RP: float
    """Value of the characteristic."""
    limit: float
    guard: float | None
    """Expanded uncertainty U = 2 u of the indicator; None where not known."""
    pose: str | None
    interval: Interval | None
    """95 %, of `RP`."""
    decision: DecisionRule
    cycles_wanted: int | None
    """Cycles with which 4 of 5 tests of Gaussian scatter would prove it, were RP as read; None
    where it is proven, or where no number of cycles would."""
    interval_void: bool = False
    """Whether a finding says that the interval does not hold: then it proves nothing inside."""

    @property
    def inside(self) -> bool:
        """Whether RP is at most the limit."""
        return self.limit >= self.RP

    @property
    def clear(self) -> bool:
        """Whether RP is farther from the limit than the indicator's U."""
        return self.guard is not None and abs(self.limit - self.RP) >= self.guard

    @property
    def verdict(self) -> Conformity:
        """What the rule of `decision` makes of it."""
        if self.decision is DecisionRule.SIMPLE:
            return Conformity.PASS if self.inside else Conformity.FAIL
        if self.interval is None or self.interval[0] <= self.limit < self.interval[1]:
            return Conformity.NOT_PROVABLE
        if self.interval[0] > self.limit:
            return Conformity.FAIL
        return Conformity.PASS


@dataclass(frozen=True, slots=True)
class Characteristic:
    """One figure of the test, by its code, where and of what; see `characteristics`."""

    code: str
    pose: str | None
    """Label, or two of them: ``P1-P2``; None for a run of one pose."""
    of: str
    """``X``, ``XY``, ``theta`` and so on."""
    estimate: Estimate
    limited_by: tuple[str, ...] = ()
    """Names by which a limit of it can be given; the first that is given holds."""
    reading_u: float | None = None
    """Standard uncertainty of one reading."""
    calibration: float | None = None
    """The part of it that the certificate states."""
    between: tuple[str | None, ...] = ()
    """Labels of the poses, where there are several."""
    limit: LimitCheck | None = None

    @property
    def name(self) -> str:
        """How it is called where it is held against a limit."""
        return self.of if self.of in self.limited_by else f"{self.code} {self.of}"


@dataclass(frozen=True, slots=True)
class Analysis:
    """Everything that `scara_iso.analyze` finds in a run."""

    run: Run
    cycles: Cycles
    poses: Poses
    """By number or by name: ``poses[0]``, ``poses["P1"]``."""
    findings: tuple[Finding, ...]
    limits: tuple[LimitCheck, ...] = ()
    characteristics: tuple[Characteristic, ...] = ()

    def __repr__(self) -> str:
        of_it = self.run.origin.source or "a run"
        used = f"{len(self.poses)} pose(s), {self.cycles.used} cycles"
        return f"<Analysis of {of_it}: {used}, {len(self.findings)} findings>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: a row for each pose and figure (X, .., XY, XYZ), NaN where none.

        Columns: pose, figure, unit (of all that follow), n, mean, l_bar, S_l, RP, RP_low and
        RP_high (95 %), RP_rss (eq. 23), three_sigma, accuracy (7.2.1), uncertainty (standard).
        """
        rows = [_row(pose, *found) for pose in self.poses for found in pose.figures.items()]
        columns = {name: [row[name] for row in rows] for name in rows[0]}
        return make_frame(columns, {"source": self.run.origin.source})

    @property
    def conformity(self) -> Conformity | None:
        """The verdict on the whole: fail where one limit fails, pass where all are kept.

        None where no limit was given. A whole that passes has passed each one, so that the risk of
        a wrong pass is that of one figure.
        """
        found = {check.verdict for check in self.limits}
        order = (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS)
        return next((verdict for verdict in order if verdict in found), None)

    @property
    def deviations(self) -> tuple[Finding, ...]:
        """The findings that are deviations from ISO 9283 or from good practice around it."""
        return tuple(finding for finding in self.findings if finding.rule)


def _row(pose: PoseResult, figure: str, found: AxisResult | RadialResult) -> dict[str, Any]:
    numbers = ("mean", "l_bar", "S_l", "RP", "RP_rss", "three_sigma", "accuracy", "uncertainty")
    low, high = found.RP_interval or (None, None)
    stated = {name: getattr(found, name, None) for name in numbers}
    stated |= {"RP_low": low, "RP_high": high}
    return {
        "pose": pose.label,
        "figure": figure,
        "unit": found.unit if isinstance(found, AxisResult) else Dimension.LENGTH.value,
        "n": len(pose.cycle),
        **{name: math.nan if value is None else value for name, value in stated.items()},
    }
