"""What a planned test will be able to tell, before the robot moves, and what would help it.

The smallest effect follows from simulated runs of one channel under the test by order, in its
scatter. All axes at all poses tell the size of an effect in a joint as one channel does: the
least-squares estimate from a cycle, whose scatter follows from the covariances of the poses. A
joint's smallest effect is therefore that of one axis, in that scatter, and somewhat more, since the
search looks at other places too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations, product
from typing import Annotated, Literal, TypeAlias

import numpy as np

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import INTERNAL, MERGED, Count, Size, fill, published
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.engine.evidence import (
    LARGEST_LOG,
    build,
    constant,
    extended,
    log_bayes,
    views_of,
)
from scara_iso.diagnosis.engine.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.engine.places import JOINTS
from scara_iso.diagnosis.engine.residual import AllPoses, Joints, axis_at
from scara_iso.diagnosis.engine.search import ORDER_SHARE
from scara_iso.diagnosis.separating import PosesApart, poses_apart, separating_plan
from scara_iso.diagnosis.sources import (
    SOURCES,
    UNITS,
    PoseCovariances,
    patterns_of,
    rounding_of,
    trace,
)
from scara_iso.diagnosis.verdict import FEWEST_CYCLES, LEVEL, SEED
from scara_iso.effects import Conditions, Effect, Shape, find_effects
from scara_iso.iso9283 import PoseTestConditions
from scara_iso.robot import Arm, Rated
from scara_iso.run import FloatArray, IntArray, step_of

_TRAVELS = np.geomspace(0.6, 12.0, 14)
"""Tried, in scatters, of 50 cycles at the most."""
_RUNS, _NULL_RUNS, _MORE_CYCLES = 600, 4000, 50
_BOTH_WAYS = "the approach alternated in random order"
_WORTH_RECORDING = {"approach": _BOTH_WAYS, "temperature_C": "the temperature logged"}
_SHARED = 1.17
"""Size found by the search over all poses over that found in one channel: its level is shared with
the other places (benchmarks/joints.py, its cell "design": 80 % as a mean of steps and warm-ups in
either joint)."""
_APART = 1e-3
"""Share of a movement from which poses do not tell the joints apart at all."""
_NO_SCATTER_MM = 1e-6
"""A dial without steps scatters by a nanometre at least: nothing is found in nothing."""
Travels: TypeAlias = Mapping[str, Size | None]
"""By effect; None where twelve sigma, with more than 50 cycles fewer, are not found either."""

POWER = 0.8
"""Share of runs in which the smallest effect that is named would be found."""

ALIKE = 0.9
"""Cosine of two centred courses from which no number of readings tells them apart."""


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """A test that is planned: its conditions, scatter and dial."""

    conditions: Conditions = field(metadata=INTERNAL)
    sigma: Size
    """Standard deviation of the readings."""
    division: Size = field(metadata=published("resolution"))
    """Of the dial; 0 for none."""
    cycles: Count = field(init=False)
    """That count."""
    columns: tuple[str, ...] = field(init=False)
    """That are recorded."""

    def __post_init__(self) -> None:
        fill(self, cycles=len(self.conditions), columns=tuple(self.conditions.covariates))


@dataclass(frozen=True, slots=True)
class Alike:
    """Two effects that can have one course."""

    effects: tuple[str, str]
    """Which."""
    cosine: float
    """The largest of their centred courses: 1 where they are one."""


@dataclass(frozen=True, slots=True)
class Change:
    """Another plan."""

    change: str
    """What is changed."""
    smallest: Travels
    """Travel that it finds in 80 % of tests, by effect, in mm."""


@dataclass(frozen=True, kw_only=True)
class Design:
    """What a planned test of one pose will be able to tell."""

    schema: Literal["scara-iso/design/1"] = "scara-iso/design/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    plan: PlannedRun = field(metadata=MERGED)
    smallest: Travels
    """Travel, lowest to highest reading, found in 80 % of tests, by effect; null: none is."""
    alike: tuple[Alike, ...]
    """What it cannot tell apart."""
    changes: tuple[Change, ...]
    """What would find more."""


def design(
    plan: PlannedRun, *, seed: int = SEED, effects: Sequence[Effect] | None = None
) -> Design:
    """Return what ``plan`` will be able to tell, by simulated runs under the test by order.

    Two levels in no order are not found by it: one pair 4 to 5 sigma apart is found without a
    covariate, by their distribution. Raises `DataError` for fewer than 8 cycles.
    """
    catalogue = tuple(find_effects() if effects is None else effects)
    alike = collinear(catalogue, plan.conditions)

    def smallest(one: PlannedRun) -> dict[str, float | None]:
        return smallest_effects(one, catalogue, np.random.default_rng(seed))

    changes = tuple(Change(words, smallest(other)) for words, other in _others(plan))
    return Design(plan=plan, smallest=smallest(plan), alike=alike, changes=changes)


def smallest_effects(
    plan: PlannedRun, effects: Sequence[Effect], rng: np.random.Generator
) -> dict[str, float | None]:
    """Return the smallest travel found in 80 % of runs for every effect with a known course."""
    n, division = len(plan.conditions), plan.division / plan.sigma
    ordered = [m for m in hypotheses_of(effects, plan.conditions) if m.ordered]
    hypotheses = build(ordered, np.arange(n), constant(n))

    def statistics(courses: FloatArray) -> FloatArray:
        """Return the log of the mean Bayes factor of a run of each course (runs, n), in sigmas."""
        readings = courses + rng.normal(size=courses.shape)
        if division:
            zero = rng.uniform(-0.5, 0.5, (len(courses), 1))
            readings = np.round(readings / division + zero) * division
        log_bf = log_bayes(hypotheses, views_of(readings.T, hypotheses.basis).columns)
        return np.log(hypotheses.test_weights @ np.exp(np.minimum(log_bf, LARGEST_LOG)))

    critical = np.quantile(statistics(np.zeros((_NULL_RUNS, n))), 1 - LEVEL * ORDER_SHARE)

    def power(courses: FloatArray, travel: float) -> float:
        return float((statistics(travel * courses) > critical).mean())

    travels, found = _TRAVELS * min(1.0, math.sqrt(50 / n)), {}
    for name in dict.fromkeys(m.effect for m in ordered):
        shapes = [m for m in ordered if m.effect == name and isinstance(m.form, Shape)]
        if shapes:
            found[name] = _crossing(partial(power, _courses(shapes, rng)), travels, plan.sigma)
    return found


def _courses(shapes: Sequence[Hypothesis], rng: np.random.Generator) -> FloatArray:
    """Return courses (runs, n) of an effect, as likely as its forms are, each of travel 1."""
    weights = np.array([m.weight for m in shapes])
    drawn = rng.choice(len(shapes), _RUNS, p=weights / weights.sum())
    columns = [shapes[k].form.columns for k in drawn]
    courses = np.stack([one @ rng.normal(size=one.shape[1]) for one in columns])
    return np.asarray(courses / np.ptp(courses, axis=1, keepdims=True))


def _crossing(power: Callable[[float], float], travels: FloatArray, sigma: float) -> float | None:
    """Return the travel at which the power passes 80 %, bisected, interpolated; times sigma."""
    low, high = -1, len(travels) - 1
    powers = {high: power(travels[high])}
    if powers[high] < POWER:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        powers[middle] = power(travels[middle])
        low, high = (low, middle) if powers[middle] >= POWER else (middle, high)
    if low < 0:
        return float(travels[0] * sigma)
    share = (POWER - powers[low]) / (powers[high] - powers[low])
    return float((travels[low] + share * (travels[high] - travels[low])) * sigma)


def collinear(effects: Sequence[Effect], conditions: Conditions) -> tuple[Alike, ...]:
    """Return pairs of effects with shapes of a cosine of at least 0.9, the largest first.

    Raises `DataError` for fewer cycles than any diagnosis takes.
    """
    if len(conditions) < FEWEST_CYCLES:
        raise DataError(
            f"{len(conditions)} usable cycles cannot tell structure from scatter",
            remedy=f"plan at least {FEWEST_CYCLES} beside a discarded one, better 30",
        )
    pose = constant(len(conditions))
    bases: dict[str, list[FloatArray]] = {}
    for m in hypotheses_of(effects, conditions):
        if isinstance(m.form, Shape) and m.ordered:
            bases.setdefault(m.effect, []).append(extended(pose, m.form.columns)[:, 1:])
    pairs = [
        Alike((a, b), max(float(np.linalg.norm(u.T @ v, 2)) for u in bases[a] for v in bases[b]))
        for a, b in combinations(bases, 2)
    ]
    return tuple(sorted((p for p in pairs if p.cosine >= ALIKE), key=lambda p: -p.cosine))


def planned_columns(cycle: IntArray) -> dict[str, FloatArray]:
    """Return the columns that a test may record beside its readings, as they might come out."""
    n, ways = len(cycle), np.random.default_rng(0)
    return {
        "approach": ways.permutation(np.where(cycle % 2, 1.0, -1.0)),
        "temperature_C": 20 + ways.normal(0, 0.5, n).cumsum() / 3,
        "payload_kg": ways.permutation(np.resize([0.0, 1.0, 2.0], n)),
        "speed": ways.permutation(np.resize([10.0, 50.0, 100.0], n)),
    }


def _others(plan: PlannedRun) -> Iterator[tuple[str, PlannedRun]]:
    """Yield other plans, in words: with a finer dial, longer, or with more recorded."""
    if plan.division > plan.sigma / 3:
        yield "a dial ten times as fine", replace(plan, division=plan.division / 10)
    cycle, covariates = plan.conditions.cycle, plan.conditions.covariates
    if len(cycle) < _MORE_CYCLES:  # over which every column takes the course that it took
        at = np.linspace(0, len(cycle) - 1, _MORE_CYCLES).round().astype(np.int64)
        stretched = {name: column[at] for name, column in covariates.items()}
        longer = Conditions(np.arange(_MORE_CYCLES) + cycle[0], stretched)
        yield f"{_MORE_CYCLES} cycles", replace(plan, conditions=longer)
    planned = planned_columns(cycle)
    for name, words in _WORTH_RECORDING.items():
        if name not in covariates:
            more = Conditions(cycle, {**covariates, name: planned[name]})
            yield words, replace(plan, conditions=more)


@dataclass(frozen=True, slots=True)
class PlannedScatter:
    """A standard deviation."""

    value: Size
    """In `unit`."""
    unit: Annotated[str, ("enum", ("rad", "mm"))]
    """`rad` of a joint."""


@dataclass(frozen=True, eq=False, slots=True)
class PlannedPosesTest:
    """A test of X and Y at several poses: what is recorded, where the joints are, what scatters.

    ``joints_deg`` has each arrival of a cycle, so that a pose that is approached from several
    directions is there for each. ``variances`` (4,) are those of joint 1 and joint 2 [rad2], of
    each dial's own [mm2] and the covariance of the joints.
    """

    conditions: Conditions = field(metadata=INTERNAL)
    arm: Arm = field(metadata=INTERNAL)
    joints_deg: Mapping[str, Joints] = field(metadata=INTERNAL)
    variances: FloatArray = field(metadata=INTERNAL)
    division: tuple[Size, Size] = field(metadata=published("resolution_mm"))
    """Of X and Y; 0 for none."""
    poses: tuple[str, ...] = field(init=False)
    """Their names."""
    cycles: Count = field(init=False)
    """That count."""
    columns: tuple[str, ...] = field(init=False)
    """That are recorded."""
    sources: Mapping[str, PlannedScatter] = field(init=False, metadata=published("scatter"))
    """Of `joint 1`, `joint 2`, and the `dial` itself."""
    sigma: Mapping[str, Annotated[Size, ("unit", "rad")]] = field(
        init=False, metadata=published("seen_in_a_cycle")
    )
    """Scatter of a joint's angle as all poses of one cycle show it."""
    apart: PosesApart = field(init=False, metadata=INTERNAL)
    """How well the poses tell joints, arm and dials apart, beside the scatter."""

    @property
    def directions(self) -> int:
        """From how many directions a pose is approached in a cycle."""
        return round(len(self.joints_deg) / len(set(self.joints_deg.values())))

    def __post_init__(self) -> None:
        joints = [*self.joints_deg.values()]
        made = np.einsum("k,pkij->pij", self.variances, patterns_of(self.arm, joints))
        scatter = made + rounding_of(self.division) + _NO_SCATTER_MM**2 * np.eye(2)
        columns = self.arm.jacobian(joints)
        known = np.einsum("pik,pik->k", columns, np.linalg.solve(scatter, columns))
        deviations = map(PlannedScatter, np.sqrt(self.variances[:-1]).tolist(), UNITS)
        fill(
            self,
            poses=tuple(self.joints_deg),
            cycles=len(self.conditions),
            columns=tuple(self.conditions.covariates),
            sources=dict(zip(SOURCES, deviations, strict=True)),
            sigma=dict(zip(JOINTS, (1 / np.sqrt(known)).tolist(), strict=True)),
            apart=poses_apart(self.arm, joints, scatter),
        )


@dataclass(frozen=True, slots=True)
class ChangeOfPoses:
    """Another plan, and the gain."""

    change: str
    """What is changed."""
    smallest: Mapping[str, Travels]
    """As of the plan."""
    apart: PosesApart = field(metadata=published("joints_apart"))
    """How well its poses tell the joints apart."""
    size_needed: Mapping[str, Size]
    """Size found and told from the other joint, over that of the plan, by joint, of all effects
    that both know."""
    adds: tuple[str, ...]
    """Effects that only it tells."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DesignOfPoses:
    """What a planned test of several poses will be able to tell of the joints."""

    schema: Literal["scara-iso/design-poses/1"] = "scara-iso/design-poses/1"
    """Name and number of this schema."""
    unit: Literal["rad"] = "rad"
    """Of every size in a joint."""
    plan: PlannedPosesTest = field(metadata=MERGED)
    smallest: Mapping[str, Travels]
    """Travel found in 80 % of tests, in rad, by joint and effect; null: none is."""
    apart: PosesApart = field(metadata=published("joints_apart"))
    """How well the poses tell the joints apart."""
    alike: tuple[Alike, ...]
    """What it cannot tell apart."""
    changes: tuple[ChangeOfPoses, ...]
    """What would help, the largest gain first."""


def design_of_poses(
    plan: PlannedPosesTest, *, seed: int = SEED, effects: Sequence[Effect] | None = None
) -> DesignOfPoses:
    """Return what a test of several poses will be able to tell of the joints.

    Raises `DataError` for fewer than 8 cycles.
    """
    in_one_scatter = design(PlannedRun(plan.conditions, 1.0, 0.0), seed=seed, effects=effects)

    def in_joints(travels: Travels, test: PlannedPosesTest) -> dict[str, Travels]:
        return {
            joint: {
                effect: travel and travel * _SHARED * sigma for effect, travel in travels.items()
            }
            for joint, sigma in test.sigma.items()
        }

    smallest = in_joints(in_one_scatter.smallest, plan)

    def changed(words: str, travels: Travels, test: PlannedPosesTest) -> ChangeOfPoses:
        then, apart = in_joints(travels, test), _resolved(plan.apart) / _resolved(test.apart)
        needed = {joint: apart * _ratio(then[joint], smallest[joint]) for joint in JOINTS}
        adds = tuple(effect for effect in travels if effect not in in_one_scatter.smallest)
        return ChangeOfPoses(words, then, test.apart, needed, adds)

    changes = [
        *(changed(one.change, one.smallest, plan) for one in in_one_scatter.changes),
        *(changed(words, in_one_scatter.smallest, test) for words, test in other_tests(plan)),
    ]
    changes.sort(key=lambda one: round(max(one.size_needed.values()), 3))
    return DesignOfPoses(
        plan=plan,
        smallest=smallest,
        apart=plan.apart,
        alike=in_one_scatter.alike,
        changes=tuple(one for one in changes if plan.directions == 1 or one.change != _BOTH_WAYS),
    )


def other_tests(plan: PlannedPosesTest) -> Iterator[tuple[str, PlannedPosesTest]]:
    """Yield other tests of as many cycles and poses, in words: with finer dials, elsewhere."""
    if any(plan.division):
        x, y = plan.division
        yield "dials ten times as fine", replace(plan, division=(x / 10, y / 10))
    try:
        proposed = separating_plan(plan.arm, {}, conditions=PoseTestConditions(), rated=Rated())
    except UsageError:
        return
    poses = {
        f"{one.name} {k}": (one.joint_1_deg, one.joint_2_deg)
        for one, k in product(proposed.poses, range(plan.directions))
    }
    yield "the poses that plan proposes with `separating=True`", replace(plan, joints_deg=poses)


def _resolved(apart: PosesApart) -> float:
    """Return the share of a movement of one joint that the other does not account for."""
    return max(math.sin(math.radians(apart.angle_deg)), _APART)


def _ratio(found: Travels, before: Travels) -> float:
    both = ((travel, before.get(effect)) for effect, travel in found.items())
    ratios = [now / then for now, then in both if now and then]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else 1.0


def like_test(test: AllPoses, arm: Arm, joints_deg: Mapping[str, Joints]) -> PlannedPosesTest:
    """Return the plan of a test like one that was measured: its columns, its dials, its scatter.

    The scatter is that from cycle to cycle, which a slow course leaves, traced to its sources.
    Raises `DataError` where X or Y is not there in mm.
    """
    axes = [test.run.axes.get(axis_at(axis, pose)) for pose in joints_deg for axis in "XY"]
    lengths = [a for a in axes if a is not None and a.dimension is Dimension.LENGTH]
    if len(lengths) < len(axes):
        raise DataError(
            "no X and Y in mm at every pose",
            where=test.run.origin.source,
            remedy="measure both: one alone does not tell the joints apart",
        )
    turns = np.diff(np.stack([a.readings for a in lengths]).reshape(len(joints_deg), 2, -1))
    turns = np.swapaxes(turns, 1, 2) / math.sqrt(3)  # of two readings each, a third of them known
    x, y = np.max(np.reshape([step_of(a) for a in lengths], (-1, 2)), axis=0).tolist()
    freedom = max(1.0, turns.shape[1] * 2 / 3)
    covariances = PoseCovariances.of(turns, freedom, arm, [*joints_deg.values()], (x, y))
    conditions = Conditions(test.run.cycle, test.run.covariates)
    return PlannedPosesTest(conditions, arm, joints_deg, trace(covariances).variances, (x, y))
