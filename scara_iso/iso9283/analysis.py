"""From a `Run` to its figures and what must be said of them: `analyze`; what they do not give.

Beside the cycles at the poses there are other tests: drift (7.6), and joints pushed to and fro.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import INTERNAL, MERGED, fill, publish
from scara_iso.iso9283.characteristics import find_characteristics, needs
from scara_iso.iso9283.checks import find_checks
from scara_iso.iso9283.checks.parts_missing import not_recorded
from scara_iso.iso9283.core.cycles import AS_THE_TABLE_SAYS, Counting, UsedCycles, used_cycles
from scara_iso.iso9283.core.drift import block_of_rows, drift_courses, every_visit
from scara_iso.iso9283.core.figures import (
    Conformity,
    DecisionRule,
    Definition,
    Limit,
    PoseResult,
    Poses,
    axis_result,
    plane_result,
    radial_result,
)
from scara_iso.iso9283.core.limits import check_limits, checks_of
from scara_iso.iso9283.core.results import (
    Analysed,
    Analysis,
    Characteristic,
    Cycles,
    Finding,
    Head,
    LimitCheck,
    Measured,
    gravest,
)
from scara_iso.iso9283.core.statistics import standard_deviation
from scara_iso.run import FloatArray, IntArray, Run

if TYPE_CHECKING:
    from scara_iso.iso9283.pushed_joint import PushResult

_VISITS = 7


def definitions(readings: FloatArray, approach: FloatArray | None) -> tuple[Definition, ...]:
    """Return half range, 2 s, 3 s and, where both approaches are there, ISO 230-2's R.

    ``readings`` of one axis, shape (n,); ``approach`` +1 or -1 for each, or None. All values are
    in the unit of the readings.
    """
    s = float(standard_deviation(readings))
    visits = readings[:_VISITS]
    found = [
        Definition("half range", float(np.ptp(readings)) / 2, f"± of all {len(readings)} readings"),
        Definition(
            f"half range of {_VISITS}", float(np.ptp(visits)) / 2, "± of the first seven visits"
        ),
        Definition("2 s", 2 * s, "± two sample standard deviations"),
        Definition("3 s", 3 * s, "± three sample standard deviations"),
    ]
    if approach is not None:
        found += _iso_230_2(readings, approach)
    return tuple(found)


def _iso_230_2(readings: FloatArray, approach: FloatArray) -> list[Definition]:
    """ISO 230-2: R = max(2 S_up + 2 S_down + |B|, 4 S_up, 4 S_down), B the reversal value."""
    up, down = readings[approach > 0], readings[approach < 0]
    if min(len(up), len(down)) < 2:
        return []
    S_up, S_down = float(standard_deviation(up)), float(standard_deviation(down))
    B = float(up.mean() - down.mean())
    R = max(2 * S_up + 2 * S_down + abs(B), 4 * S_up, 4 * S_down)
    return [
        Definition("R up", 4 * S_up, "ISO 230-2, unidirectional, approach +1"),
        Definition("R down", 4 * S_down, "ISO 230-2, unidirectional, approach -1"),
        Definition("B", B, "ISO 230-2, reversal: mean of +1 minus mean of -1"),
        Definition("R", R, "ISO 230-2, bidirectional"),
    ]


_FEWEST_CYCLES = 2


def analyze(
    run: Run,
    counting: Counting = AS_THE_TABLE_SAYS,
    *,
    limits: Mapping[str, Limit] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    other_definitions: bool = False,
) -> Analysis:
    """Return RP of every pose, axis and plane of a run, with intervals and findings.

    Paper eq. 2-6 and 23, ISO 9283 7.2.1 and 7.2.2. ``limits`` are in mm (degrees for an
    angle), or texts with a unit, by figure (``X``, ``XY``...); the key `limits.EVERY_LENGTH` holds
    for every length.
    ``decision`` is ``interval`` (a limit is kept or broken where the whole 95 % interval says so,
    and not kept on an interval that a finding voids)
    or ``simple`` (RP at most the limit). ``other_definitions`` adds half range, 2 s, 3 s and ISO
    230-2. Raises `DataError` where the run breaks the cycle rule, and `UsageError` for another
    rule or a limit of a figure that the run does not have.
    """
    rule = _rule(decision)
    run = run.unwrapped()
    block = block_of_rows(run)
    chosen = _enough_cycles(run, counting, block)
    each = zip(chosen.poses, chosen.rows, chosen.missing, strict=True)
    poses = Poses(_pose_result(run, *pose, other_definitions=other_definitions) for pose in each)
    drift = None if block is None else tuple(drift_courses(run, poses, block))
    measured = Measured(run, publish(Cycles, chosen), poses, block, drift)
    found = tuple(one for each in find_characteristics() for one in each.compute(measured))
    measured = replace(measured, codes=frozenset(one.code for one in found))
    analysis = publish(
        Analysis,
        measured,
        source=run.origin.source,
        read_as=run.origin.understood,
        notes=run.origin.notes,
        metadata=run.metadata,
        findings=tuple(finding for one in find_checks() for finding in one.check(measured)),
        characteristics=found,
    )
    return hold_to(analysis, limits, rule) if limits else analysis


def hold_to(
    analysis: Analysis,
    limits: Mapping[str, Limit],
    decision: DecisionRule = DecisionRule.INTERVAL,
) -> Analysis:
    """Return an analysis with its figures held against limits; raises as `check_limits`."""
    checked = check_limits(
        analysis.characteristics,
        limits,
        analysis.findings,
        decision=decision,
        needs=needs(),
        units=analysis.run.stated_units,
    )
    return replace(analysis, characteristics=checked, limits=checks_of(checked))


def _enough_cycles(run: Run, counting: Counting, block: IntArray | None) -> UsedCycles:
    """Return the rows that count, of a drift test every visit; `DataError` where one is left."""
    if block is None:
        chosen = used_cycles(run, counting)
    else:
        asked = counting.first_cycle_discarded or counting.cycles is not None
        chosen = every_visit(run, block, asked=asked)
    if chosen.used < _FEWEST_CYCLES:
        raise DataError(
            f"{chosen.used} cycle counts: no scatter can be computed",
            where=run.origin.source,
            remedy=f"run {_FEWEST_CYCLES} cycles that count, or more",
        )
    return chosen


def _rule(decision: str) -> DecisionRule:
    try:
        return DecisionRule(decision)
    except ValueError:
        remedy = f"use one of {', '.join(rule.value for rule in DecisionRule)}"
        raise UsageError(f"decision {decision!r}: no such rule", remedy=remedy) from None


def _pose_result(
    run: Run,
    label: str | None,
    rows: IntArray,
    missing: tuple[tuple[int, int], ...],
    *,
    other_definitions: bool,
) -> PoseResult:
    axes = {name: axis_result(run, axis, label, rows) for name, axis in run.axes.items()}
    if other_definitions:
        approach = run.covariates.get("approach")
        side = None if approach is None else approach[rows]
        axes = {
            name: replace(one, definitions=definitions(one.readings, side))
            for name, one in axes.items()
        }
    return PoseResult(
        label=label,
        rows=rows,
        cycle=run.cycle[rows],
        axes=axes,
        XY=plane_result(run, label, rows),
        XYZ=radial_result(run, "XYZ", label, rows),
        missing=missing,
    )


@dataclass(frozen=True, slots=True)
class NotMeasured:
    """A characteristic that a test does not give, with its clause, and why."""

    name: str
    clause: str
    why: str


# Clauses as the contents of ISO 9283:1998 name them.
BEYOND_DIALS = (
    NotMeasured(
        "distance accuracy AD beyond a dial's range",
        "7.3",
        "a dial measures no length beyond its own travel: use a laser tracker or a scale",
    ),
    NotMeasured("path accuracy AT", "8.2", "a dial rests at one place and follows no path"),
    NotMeasured(
        "path repeatability RT", "8.3", "a dial follows no path: use a tracking instrument"
    ),
    NotMeasured("path accuracy on reorientation", "8.4", "likewise"),
    NotMeasured("cornering deviations", "8.5", "a dial follows no path, nor a corner between two"),
    NotMeasured(
        "path velocity characteristics", "8.6", "a dial does not measure speed along a path"
    ),
    NotMeasured(
        "minimum posing time",
        "9",
        "it begins when the robot leaves one pose; the dial is at the other",
    ),
    NotMeasured("weaving deviations", "11", "a dial follows no path"),
)
"""What dials at a pose cannot measure, by clause."""


def not_measured(analysis: Analysis) -> tuple[NotMeasured, ...]:
    """Return each characteristic that these readings do not give, with what it would need.

    Those that dials can measure by name of their file, then `BEYOND_DIALS`.
    """
    there = {one.code for one in analysis.characteristics}
    lacking = (
        NotMeasured(one.CODE, one.CLAUSE, f"needs {one.NEEDS}")
        for one in find_characteristics()
        if one.CODE not in there
    )
    return (*lacking, *BEYOND_DIALS)


_DRIFT, _PUSH = "drift", "push"


@dataclass(frozen=True, eq=False, slots=True)
class OtherTests:
    """The tests beside the poses: drift and push tests; empty where there are none."""

    drift: Analysis | None = field(default=None, metadata=INTERNAL)
    """Of the drift test, its rows under the label of its pose."""
    pushes: Mapping[str, PushResult] = field(default_factory=dict, metadata=INTERNAL)
    """By name of the part: ``push``, or ``push-joint_1`` of several."""
    characteristics: tuple[Characteristic, ...] = field(init=False)
    """Their figures; those of several joints are of ``joint_1`` and ``joint_1 reading``."""
    limits: tuple[LimitCheck, ...] = field(init=False)
    """One for each figure that was held against a limit."""
    conformity: Conformity | None = field(init=False)
    """Of these limits together, the gravest; None where none was given."""
    findings: tuple[Finding, ...] = field(init=False)
    """What the checks say of the drift test, as of the pose ``drift``, and what is missing."""
    missing: tuple[str, ...] = ()
    """Parts that are not recorded."""

    def __post_init__(self) -> None:
        pushed = [one for name in self.pushes for one in self._of_push(name)]
        limits = [one.limit for one in pushed if one.limit is not None]
        findings = []
        if self.missing:
            findings.append(not_recorded(", ".join(self.missing), other_tests=True))
        if self.drift is not None:
            pushed = [*self.drift.characteristics, *pushed]
            limits = [*self.drift.limits, *limits]
            findings = [*(replace(one, pose=_DRIFT) for one in self.drift.findings), *findings]
        fill(
            self,
            characteristics=tuple(pushed),
            limits=tuple(limits),
            conformity=gravest(one.verdict for one in limits),
            findings=tuple(findings),
        )

    def __bool__(self) -> bool:
        return bool(self.drift or self.pushes or self.missing)

    @property
    def simulated(self) -> bool:
        """Whether readings of the drift test are of no dial."""
        return self.drift is not None and bool(self.drift.run.simulated)

    def added_to(self, analysis: Analysis) -> Analysis:
        """Return an analysis of the poses with these figures and findings, none of them twice."""
        said = {(one.code, one.axis, one.message) for one in analysis.findings}
        new = (one for one in self.findings if (one.code, one.axis, one.message) not in said)
        return replace(
            analysis,
            findings=(*analysis.findings, *new),
            limits=(*analysis.limits, *self.limits),
            characteristics=(*analysis.characteristics, *self.characteristics),
        )

    def _of_push(self, name: str) -> Iterator[Characteristic]:
        joint = name.removeprefix(_PUSH).removeprefix("-")
        for found in self.pushes[name].characteristics:
            if not joint:
                yield found
                continue
            of = joint if found.of == "joint" else f"{joint} {found.of}"
            check = found.limit and replace(found.limit, figure=f"{found.code} {of}")
            yield replace(found, of=of, limit=check)


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
    other_tests: OtherTests | None = field(default=None, metadata=MERGED)
    """Figures, limits and findings of the tests beside them."""
