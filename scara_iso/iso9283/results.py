"""What an analysis yields: its characteristics, what is held against limits, and findings.

Lengths are in mm; theta is in degrees where it was given as an angle. No result prints, plots or
converts itself: `report` says it and `render` shows it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from scara_iso.base.display import Displayed
from scara_iso.base.published import Interval
from scara_iso.base.quantities import Dimension, Estimate
from scara_iso.iso9283.figures import (
    AxisResult,
    Conformity,
    DecisionRule,
    PoseResult,
    Poses,
    RadialResult,
)
from scara_iso.run import IntArray, Run, frame_of, or_nan

if TYPE_CHECKING:
    import pandas as pd

    from scara_iso.iso9283.drift import DriftCourse

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True, slots=True)
class Cycles:
    """How many cycles each pose has in the table, which were left out, how many count.

    Where gaps are allowed: of the pose with the fewest.
    """

    read: int
    """Cycles in the table."""
    discarded: tuple[int, ...]
    """Numbers of the cycles that were left out."""
    used: int
    """Cycles that count."""
    all_count: bool = False
    """Whether it is stated that every row counts: none was discarded, here or before."""


@dataclass(frozen=True, slots=True)
class Measured:
    """The figures of a run, before anything is said about them."""

    run: Run
    cycles: Cycles
    poses: Poses[PoseResult]
    block: IntArray | None = field(default=None, repr=False, compare=False)
    """Of a drift test (7.6): the block of each row, from 0, shape (rows,); None for another."""
    drift: tuple[DriftCourse, ...] | None = field(default=None, repr=False, compare=False)
    """Likewise: the course of each pose."""
    robots: tuple[Measured, ...] = ()
    """The same program on other robots."""
    codes: frozenset[str] = frozenset()
    """Of the characteristics that it gives; known to the checks."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Something the user should know; ``rule`` names what the test departs from, if it does."""

    code: str
    """Name of the check; `explain` takes it."""
    severity: Severity
    """How much it weighs on the result."""
    message: str
    """What was found and what to do, in a sentence."""
    axis: str | None = None
    """The axis that it is about; None for all."""
    pose: str | None = None
    """Label of the pose that it is about; None for all, or for the only one."""
    rule: str = ""
    voids_interval: bool = False
    """Whether the 95 % interval of its axis and pose, and of what is made of it, does not hold."""
    advice: str = ""
    """What to do about it, for who runs the program; a report to a customer leaves it out."""

    @property
    def said(self) -> str:
        """The message with its advice."""
        return f"{self.message}; {self.advice}" if self.advice else self.message


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
    """Largest value that is allowed."""
    guard: float | None
    """Expanded uncertainty U = 2 u of the indicator; None where not known."""
    pose: str | None
    """Label; None for the only pose."""
    interval: Interval | None
    """95 %, of `RP`."""
    decision: DecisionRule
    """The rule that decides."""
    cycles_wanted: int | None
    """Cycles with which 4 of 5 tests of Gaussian scatter would prove it, were RP as read; None
    where it is proven, or where no number of cycles would."""
    unit: str = "mm"
    """Of figure, limit and interval."""
    lower: float | None = None
    """Smallest value that is allowed; None where only the largest is given."""
    interval_void: bool = False
    """Whether a drift voids the interval: the verdict holds only while the robot drifts so."""

    @property
    def inside(self) -> bool:
        """Whether RP is at most the limit, and at least the lower one."""
        return self.limit >= self.RP and (self.lower is None or self.RP >= self.lower)

    @property
    def clear(self) -> bool:
        """Whether RP is farther from the limit than the indicator's U."""
        return self.guard is not None and abs(self.limit - self.RP) >= self.guard

    @property
    def verdict(self) -> Conformity:
        """What the rule of `decision` makes of it."""
        if self.decision is DecisionRule.SIMPLE:
            return Conformity.PASS if self.inside else Conformity.FAIL
        if self.interval is None:
            return Conformity.NOT_PROVABLE
        low, high = self.interval
        least = -math.inf if self.lower is None else self.lower
        if low > self.limit or high < least:
            return Conformity.FAIL
        return Conformity.PASS if least <= low and high <= self.limit else Conformity.NOT_PROVABLE


def gravest(checks: Iterable[LimitCheck]) -> Conformity | None:
    """Return fail where one limit fails, pass where all are kept, None where there is none."""
    found = {check.verdict for check in checks}
    order = (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS)
    return next((verdict for verdict in order if verdict in found), None)


@dataclass(frozen=True, slots=True)
class Characteristic:
    """One figure of the test, by its code, where and of what; see `characteristics`."""

    code: str
    """``RP``, ``AP``, ``RD`` and so on."""
    pose: str | None
    """Label, or two of them: ``P1-P2``; None for a run of one pose."""
    of: str
    """``X``, ``XY``, ``theta`` and so on."""
    estimate: Estimate
    """Value with unit, uncertainty and interval."""
    limited_by: tuple[str, ...] = ()
    """Names by which a limit of it can be given; the first that is given holds."""
    reading_u: float | None = None
    """Standard uncertainty of one reading."""
    calibration: float | None = None
    """The part of it that the certificate states."""
    between: tuple[str | None, ...] = ()
    """Labels of the poses, where there are several."""
    limit: LimitCheck | None = None
    """What it makes of its limit; None where none was given."""
    of_means: bool = False
    """Whether its interval shrinks evenly with the root of the cycles, as that of a mean."""
    half_width: bool = False
    """Whether the figure is the half of a width: ``± 3 S``."""
    counted: str = "cycles"
    """What ``n`` of the estimate counts."""

    @property
    def name(self) -> str:
        """How it is called where it is held against a limit."""
        return self.of if self.of in self.limited_by else f"{self.code} {self.of}"


@dataclass(frozen=True, slots=True)
class Analysis(Displayed):
    """Everything that `scara_iso.analyze` finds in a run."""

    run: Run
    """The readings that were analysed, angles unwrapped."""
    cycles: Cycles
    """Which of them count."""
    poses: Poses[PoseResult]
    """By number or by name: ``poses[0]``, ``poses["P1"]``."""
    findings: tuple[Finding, ...]
    """What the checks say, in the order of their files."""
    limits: tuple[LimitCheck, ...] = ()
    """One for each figure that was held against a limit."""
    characteristics: tuple[Characteristic, ...] = ()
    """Every figure of the test, by clause."""
    block: IntArray | None = field(default=None, repr=False, compare=False)
    """Of a drift test, as in `Measured`."""
    drift: tuple[DriftCourse, ...] | None = field(default=None, repr=False, compare=False)
    """Of a drift test: the course of each pose by block; None for another."""

    def __repr__(self) -> str:
        of_it = self.run.origin.source or "a run"
        used = f"{len(self.poses)} pose(s), {self.cycles.used} cycles"
        return f"<Analysis of {of_it}: {used}, {len(self.findings)} findings>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: a row for each pose and figure (X, .., XY, XYZ), NaN where none.

        Columns: pose (None where the table names none), figure, unit (of all that follow), n, mean,
        l_bar, S_l, RP, RP_low and RP_high (95 %), RP_rss (eq. 23), three_sigma, accuracy (7.2.1),
        uncertainty (standard).
        """
        rows = [_row(pose, *found) for pose in self.poses for found in pose.figures.items()]
        return frame_of(rows, {"source": self.run.origin.source})

    @property
    def conformity(self) -> Conformity | None:
        """The verdict on the whole: fail where one limit fails, pass where all are kept.

        None where no limit was given. A whole that passes has passed each one, so that the risk of
        a wrong pass is that of one figure.
        """
        return gravest(self.limits)

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
        **{name: or_nan(value) for name, value in stated.items()},
    }


def poses_in_cycles(test: Measured | Analysis) -> Poses[PoseResult]:
    """Return the poses that were visited in cycles: a drift test has none, and so no RP."""
    return test.poses if test.block is None else Poses()


def limit_names(code: str, pose: str | None, of: str) -> tuple[str, ...]:
    """Return the names of a limit: of one pose, then of all; an angle has its own, ``AP_a``."""
    named = f"{code}_a" if of == "theta" else code
    return (named,) if pose is None else (f"{named}:{pose}", named)
