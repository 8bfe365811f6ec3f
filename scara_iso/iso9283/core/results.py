"""What an analysis yields: its characteristics, what is held against limits, and findings.

Lengths are in mm; theta is in degrees where it was given as an angle. No result prints, plots or
converts itself: `report` says it and `render` shows it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

from scara_iso.base.displayed import Displayed
from scara_iso.base.published import (
    ALWAYS,
    INTERNAL,
    MERGED,
    Count,
    Interval,
    Size,
    fill,
    publish,
    published,
    row_of,
)
from scara_iso.base.quantities import Dimension, Estimate
from scara_iso.iso9283.core.drift import DriftCourse
from scara_iso.iso9283.core.figures import AxisResult, Conformity, DecisionRule, PoseResult, Poses
from scara_iso.run import IntArray, Run, frame_of

if TYPE_CHECKING:
    import pandas as pd

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True, slots=True)
class Cycles:
    """How many cycles each pose has in the table, which were left out, how many count.

    Where gaps are allowed: of the pose with the fewest.
    """

    read: Count
    """Cycles in the table."""
    discarded: tuple[int, ...]
    """Numbers of the cycles that were left out."""
    used: Count
    """Cycles that count."""
    all_count: bool = field(default=False, metadata=INTERNAL)
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
    """Name of the check; `scara-iso explain CODE` explains it."""
    severity: Severity
    """How much it weighs on the result."""
    message: str = field(metadata=INTERNAL)
    """What was found, in a sentence."""
    axis: str | None = field(default=None, metadata=ALWAYS)
    """One axis, or several with a comma between them; None for all."""
    pose: str | None = field(default=None, metadata=ALWAYS)
    """Label of the pose; None for all, or for the only one."""
    rule: str = field(default="", metadata=INTERNAL)
    voids_interval: bool = field(default=False, metadata=INTERNAL)
    """Whether the 95 % interval of its axis and pose, and of what is made of it, does not hold."""
    advice: str = field(default="", metadata=INTERNAL)
    """What to do about it, for who runs the program; a report to a customer leaves it out."""
    in_short: str = field(default="", metadata=INTERNAL)
    """What to do about it in a few words, such as an option of this table."""
    in_full: str = field(init=False, repr=False, metadata=published("message"))
    """What was found and what to do."""

    def __post_init__(self) -> None:
        fill(self, in_full="; ".join(part for part in (self.message, self.advice) if part))


Findings: TypeAlias = Iterator[Finding]


@dataclass(frozen=True, slots=True)
class Deviation:
    """A finding that departs from ISO 9283 or from good practice around it."""

    rule: str
    """What it departs from."""
    code: str
    """Of the finding."""
    message: str
    """Of the finding."""


@dataclass(frozen=True, slots=True)
class LimitCheck:
    """One figure against a limit that the user gave; lengths in mm, angles in degrees."""

    figure: str
    """``X``, ``XY``, ``XY_eq23`` and so on, with the code where it is no repeatability of a pose:
    ``RD X``."""
    code: str = field(metadata=INTERNAL)
    """Of the characteristic."""
    RP: Size
    """The figure that decides."""
    limit: Size
    """Largest value that is allowed."""
    guard: Size | None
    """Expanded uncertainty U = 2 u of the indicator; None where not known."""
    pose: str | None
    """Label; None for the only pose."""
    interval: Interval | None
    """95 %, of `RP`."""
    decision: DecisionRule = field(metadata=published("rule"))
    """What decides: the 95 % interval, or the value alone."""
    cycles_wanted: Annotated[int, ("minimum", 1)] | None
    """In one run, for a proof in 4 of 5 tests, were RP as read; None where decided or where no
    number would do; 100000: that many or more."""
    unit: str = field(default="mm", metadata=INTERNAL)
    """Of figure, limit and interval."""
    lower: Size | None = None
    """Smallest value that is allowed, where the largest is not the only limit."""
    interval_void: bool = False
    """Whether a drift voids the interval: the verdict holds only while the robot drifts so."""
    inside: bool = field(init=False)
    """RP is at most the limit, and at least the lower one."""
    clear: bool = field(init=False)
    """RP is farther from the limit than `guard`."""
    verdict: Conformity = field(init=False)
    """Whether it is kept, by the rule."""

    def __post_init__(self) -> None:
        inside = self.limit >= self.RP and (self.lower is None or self.RP >= self.lower)
        clear = self.guard is not None and abs(self.limit - self.RP) >= self.guard
        fill(self, inside=inside, clear=clear)
        fill(self, verdict=self._verdict())

    def _verdict(self) -> Conformity:
        if self.decision is DecisionRule.SIMPLE:
            return Conformity.PASS if self.inside else Conformity.FAIL
        if self.interval is None:
            return Conformity.NOT_PROVABLE
        low, high = self.interval
        least = -math.inf if self.lower is None else self.lower
        if low > self.limit or high < least:
            return Conformity.FAIL
        return Conformity.PASS if least <= low and high <= self.limit else Conformity.NOT_PROVABLE


@dataclass(frozen=True, slots=True)
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


def of_characteristic(found: LimitCheck | None) -> CharacteristicLimit | None:
    """Return what a characteristic publishes of its limit."""
    return None if found is None else publish(CharacteristicLimit, found, rule=found.decision)


def gravest(verdicts: Iterable[Conformity]) -> Conformity | None:
    """Return fail where one limit fails, pass where all are kept, None where there is none."""
    order = (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS)
    return min(verdicts, key=order.index, default=None)


@dataclass(frozen=True, slots=True)
class Characteristic:
    """One figure of the test, by its code, where and of what; see `characteristics`."""

    code: str
    """`scara-iso explain CODE` explains it."""
    pose: str | None
    """Label, or two of them for a distance: ``P1-P2``; None for a run of one pose."""
    of: str
    """Axis, XY or XYZ; of a push test joint or reading, or ``joint_1``, ``joint_1 reading``."""
    estimate: Estimate = field(metadata=MERGED)
    """Value with unit, uncertainty and interval."""
    limited_by: tuple[str, ...] = field(default=(), metadata=INTERNAL)
    """Names by which a limit of it can be given; the first that is given holds."""
    reading_u: float | None = field(default=None, metadata=INTERNAL)
    """Standard uncertainty of one reading."""
    calibration: float | None = field(default=None, metadata=INTERNAL)
    """The part of it that the certificate states."""
    between: tuple[str | None, ...] = field(default=(), metadata=INTERNAL)
    """Labels of the poses, where there are several."""
    limit: LimitCheck | None = field(
        default=None, metadata=published(by=of_characteristic, always=True)
    )
    """What it makes of its limit; None where none was given."""
    of_means: bool = field(default=False, metadata=INTERNAL)
    """Whether its interval shrinks evenly with the root of the cycles, as that of a mean."""
    half_width: bool = field(default=False, metadata=INTERNAL)
    """Whether the figure is the half of a width: ``± 3 S``."""
    counted: str = field(default="cycles", metadata=INTERNAL)
    """What ``n`` of the estimate counts."""

    @property
    def name(self) -> str:
        """How it is called where it is held against a limit."""
        of_it = (name for name in self.limited_by if name.startswith(self.of))
        return next(of_it, f"{self.code} {self.of}")


Characteristics: TypeAlias = Iterator[Characteristic]


def deviations(found: tuple[Finding, ...]) -> tuple[Deviation, ...]:
    """Return what is published of findings that name a rule."""
    return tuple(Deviation(one.rule, one.code, one.in_full) for one in found)


@dataclass(frozen=True, kw_only=True)  # without slots: bases are joined, the head's keys first
class Head:
    """What the object of ``analyze`` begins with."""

    schema: Literal["scara-iso/analyze/2"] = "scara-iso/analyze/2"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
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
    cycles: Cycles
    """For each pose."""
    poses: Poses[PoseResult]
    """By number or by name: ``poses[0]``, ``poses["P1"]``. None where no part of a test's folder is
    recorded."""
    characteristics: tuple[Characteristic, ...] = ()
    """Every figure of the test, by clause."""
    limits: tuple[LimitCheck, ...] = ()
    """One for each figure that was held against a limit."""
    conformity: Conformity | None = field(init=False)
    """Of all limits together, the gravest; None where none was given. The exit code is 0 for `pass`
    and None, else 1."""
    deviations: tuple[Finding, ...] = field(init=False, metadata=published(by=deviations))
    """Findings that name a rule."""
    findings: tuple[Finding, ...]
    """What the checks say, in the order of their files."""
    missing: tuple[str, ...] | None = None
    """Of a test's folder: parts that are not recorded."""

    def __post_init__(self) -> None:
        named = tuple(finding for finding in self.findings if finding.rule)
        conformity = gravest(one.verdict for one in self.limits)
        fill(self, conformity=conformity, deviations=named)


@dataclass(frozen=True, kw_only=True)
class WholeAnalysis(Analysed, Head):
    """``analyze`` of a table, or of a test's folder with one condition."""

    drift: tuple[DriftCourse, ...] | None = field(default=None, repr=False, compare=False)
    """Of a drift test (7.6) only: the course of each pose."""


@dataclass(frozen=True, kw_only=True)
class Analysis(WholeAnalysis, Displayed):
    """Everything that `scara_iso.analyze` finds in a run."""

    run: Run = field(metadata=INTERNAL)
    """The readings that were analysed, angles unwrapped."""
    block: IntArray | None = field(default=None, repr=False, compare=False, metadata=INTERNAL)
    """Of a drift test, as in `Measured`."""

    def __repr__(self) -> str:
        of_it = self.run.origin.source or "a run"
        used = f"{len(self.poses)} pose(s), {self.cycles.used} cycles"
        return f"<Analysis of {of_it}: {used}, {len(self.findings)} findings>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: a row for each pose and figure (X, .., XY, XYZ), NaN where none.

        Columns: pose (None where the table names none), figure, unit (of all that follow), n, and
        what `AxisResult` and `PlaneResult` publish: mean, RP, RP_low and RP_high (95 %), and so on;
        of an angle RP_a too, by which screen, report and limits go.
        """
        rows = []
        for pose in self.poses:
            of_all = {"unit": Dimension.LENGTH.value, "n": len(pose.cycle)}
            for name, found in pose.figures.items():
                numbers = {
                    key.replace("RP_radial", "RP"): one for key, one in row_of(found).items()
                }
                if numbers.get("unit") == Dimension.ANGLE.value:
                    sigma = [key for key in numbers if key.startswith("three_sigma")]
                    numbers |= {key.replace("three_sigma", "RP_a"): numbers[key] for key in sigma}
                rows.append({"pose": pose.label, "figure": name} | of_all | numbers)
        return frame_of(rows, {"source": self.run.origin.source})


def poses_in_cycles(test: Measured | Analysis) -> Poses[PoseResult]:
    """Return the poses that were visited in cycles: a drift test has none, and so no RP."""
    return test.poses if test.block is None else Poses()


def each_axis(poses: Iterable[PoseResult]) -> Iterator[tuple[PoseResult, AxisResult]]:
    """Yield each axis of each pose, with the pose."""
    return ((pose, axis) for pose in poses for axis in pose.axes.values())


def arrivals_by_pose(
    run: Run, poses: Iterable[PoseResult]
) -> Mapping[str | None, Sequence[PoseResult]]:
    """Return the results of each pose: one, or one for each direction of approach."""
    found: dict[str | None, list[PoseResult]] = {}
    for one in poses:
        found.setdefault(run.arrival_at(one.label)[0], []).append(one)
    return found


def limit_names(code: str, pose: str | None, of: str) -> tuple[str, ...]:
    """Return the names of a limit: of one pose, then of all; an angle has its own, ``AP_a``."""
    named = f"{code}_a" if of == "theta" else code
    return (named,) if pose is None else (f"{named}:{pose}", named)
