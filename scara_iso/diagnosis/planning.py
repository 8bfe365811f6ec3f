"""What a planned test will be able to tell, before the robot moves, and what would help it.

All axes at all poses tell the size of an effect in a joint as one channel does: the least-squares
estimate from a cycle, whose scatter follows from the covariances of the poses. A joint's smallest
effect is therefore that of one axis, in that scatter, and somewhat more, since the search looks at
other places too.
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
from scara_iso.diagnosis.evidence import evidence_of_runs
from scara_iso.diagnosis.hypotheses import (
    Hypothesis,
    HypothesisSet,
    build,
    constant,
    extended,
    hypotheses_of,
)
from scara_iso.diagnosis.places import JOINTS, AllPoses, Joints, axis_at
from scara_iso.diagnosis.separating import PosesApart, poses_apart, separating_plan
from scara_iso.diagnosis.sources import (
    SOURCES,
    UNITS,
    PoseCovariances,
    patterns_of,
    rounding_of,
    trace,
)
from scara_iso.diagnosis.tuning import ALIKE, FEWEST_CYCLES, LEVEL, POWER, SEED
from scara_iso.effects import Conditions, Effect, Shape, find_effects
from scara_iso.iso9283 import PoseTestConditions
from scara_iso.robot import Arm, Rated
from scara_iso.run import FloatArray, IntArray, step_of

_TRAVELS = np.geomspace(0.6, 12.0, 14)
_RUNS, _NULL_RUNS, _MORE_CYCLES = 150, 1000, 50
_WORTH_RECORDING = {
    "approach": "the approach alternated in random order",
    "temperature_C": "the temperature logged",
}
Travels: TypeAlias = Mapping[str, Size | None]
"""By effect; None where twelve sigma, with more than 50 cycles fewer, are not found either."""


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """A test that is planned: its conditions, scatter and dial."""

    conditions: Conditions = field(metadata=INTERNAL)
    sigma: Size
    """Standard deviation of the readings."""
    division: Size = field(metadata=published("resolution"))
    """Of the dial; 0 for none."""
    moved: int = field(default=1, metadata=INTERNAL)
    """How many axes an effect moves, by the same travel."""
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
    enough(plan.conditions)
    catalogue = tuple(find_effects() if effects is None else effects)
    return Design(
        plan=plan,
        smallest=smallest_effects(plan, catalogue, np.random.default_rng(seed)),
        alike=collinear(hypotheses_of(catalogue, plan.conditions), plan.conditions),
        changes=tuple(
            Change(words, smallest_effects(other, catalogue, np.random.default_rng(seed)))
            for words, other in _changes(plan)
        ),
    )


def enough(conditions: Conditions) -> None:
    """Raise `DataError` for fewer cycles than any diagnosis takes."""
    if len(conditions) < FEWEST_CYCLES:
        raise DataError(
            f"{len(conditions)} usable cycles cannot tell structure from scatter",
            remedy=f"plan at least {FEWEST_CYCLES} beside a discarded one, better 30",
        )


def smallest_effects(
    plan: PlannedRun, effects: Sequence[Effect], rng: np.random.Generator
) -> dict[str, float | None]:
    """Return the smallest travel found in 80 % of runs for every effect with a known course."""
    members = hypotheses_of(effects, plan.conditions)
    travels = _TRAVELS * min(1.0, math.sqrt(50 / len(plan.conditions)))
    ordered = [m for m in members if m.ordered and not m.hidden]
    n = len(plan.conditions)
    hypotheses = build(ordered, np.arange(n), constant(n))
    null = _statistics(hypotheses, [_readings(plan, None, 0.0, rng) for _ in range(_NULL_RUNS)])
    critical = float(np.quantile(null, 1 - LEVEL))
    found = {}
    for name in dict.fromkeys(m.effect for m in ordered):
        shapes = [m for m in ordered if m.effect == name and isinstance(m.form, Shape)]
        if shapes:
            power = partial(_power, hypotheses, plan, shapes, critical, rng)
            found[name] = _crossing(power, travels, plan.sigma)
    return found


def collinear(members: Sequence[Hypothesis], conditions: Conditions) -> tuple[Alike, ...]:
    """Return pairs of effects with shapes of a cosine of at least 0.9, the largest first."""
    pose = constant(len(conditions))
    bases: dict[str, list[FloatArray]] = {}
    for m in members:
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


def _changes(plan: PlannedRun) -> list[tuple[str, PlannedRun]]:
    changes = [("three axes that move together", replace(plan, moved=3))]
    if plan.division > plan.sigma / 3:
        changes.append(("a dial ten times as fine", replace(plan, division=plan.division / 10)))
    others = other_conditions(plan.conditions)
    return [*changes, *((words, replace(plan, conditions=other)) for words, other in others)]


def other_conditions(conditions: Conditions) -> Iterator[tuple[str, Conditions]]:
    """Yield other ways to take as many cycles or more, in words: longer, or with more recorded."""
    if len(conditions) < _MORE_CYCLES:
        yield f"{_MORE_CYCLES} cycles", _longer(conditions)
    planned = planned_columns(conditions.cycle)
    for name, words in _WORTH_RECORDING.items():
        if name not in conditions.covariates:
            covariates = {**conditions.covariates, name: planned[name]}
            yield words, Conditions(conditions.cycle, covariates)


def _longer(conditions: Conditions) -> Conditions:
    """Return more cycles, over which every column takes the course that it took over fewer."""
    at = np.linspace(0, len(conditions) - 1, _MORE_CYCLES).round().astype(np.int64)
    stretched = {name: column[at] for name, column in conditions.covariates.items()}
    return Conditions(np.arange(_MORE_CYCLES) + conditions.cycle[0], stretched)


def _power(
    hypotheses: HypothesisSet,
    plan: PlannedRun,
    shapes: Sequence[Hypothesis],
    critical: float,
    rng: np.random.Generator,
    travel: float,
) -> float:
    weights = np.array([m.weight for m in shapes])
    drawn = rng.choice(len(shapes), _RUNS, p=weights / weights.sum())
    runs = [_readings(plan, shapes[k], travel, rng) for k in drawn]
    return float(np.mean(_statistics(hypotheses, runs) > critical))


def _readings(
    plan: PlannedRun, member: Hypothesis | None, travel: float, rng: np.random.Generator
) -> FloatArray:
    """Return one simulated run (n, axes), in sigmas."""
    n = len(plan.conditions)
    readings = rng.normal(size=(n, plan.moved))
    if member is not None and isinstance(member.form, Shape):
        columns = member.form.columns
        course = columns @ rng.normal(size=columns.shape[1])
        readings += (travel / np.ptp(course) * course)[:, np.newaxis]
    if not plan.division:
        return readings
    division = plan.division / plan.sigma
    return np.asarray(np.round(readings / division + rng.uniform(-0.5, 0.5)) * division)


def _statistics(hypotheses: HypothesisSet, runs: Sequence[FloatArray]) -> FloatArray:
    """Return the log of the mean Bayes factor of each run, shape (runs,)."""
    return np.asarray(np.log(hypotheses.test_weights @ evidence_of_runs(hypotheses, runs)))


def _crossing(power: Callable[[float], float], travels: FloatArray, sigma: float) -> float | None:
    """Return the travel at which the power passes 80 %, bisected, interpolated; times sigma."""
    low, high = -1, len(travels) - 1
    seen = {high: power(travels[high])}
    if seen[high] < POWER:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        seen[middle] = power(travels[middle])
        low, high = (low, middle) if seen[middle] >= POWER else (middle, high)
    if low < 0:
        return float(travels[0] * sigma)
    share = (POWER - seen[low]) / (seen[high] - seen[low])
    return float((travels[low] + share * (travels[high] - travels[low])) * sigma)


_SHARED = 1.17
"""Size found by the search over all poses over that found in one channel: its level is shared with
the other places (benchmarks/joints.py, its cell "design": 80 % as a mean of steps and warm-ups in
either joint)."""
_ALIKE = 1e-3
"""Share of a movement from which poses do not tell the joints apart at all."""
_NO_SCATTER_MM = 1e-6
"""A dial without steps scatters by a nanometre at least: nothing is found in nothing."""


@dataclass(frozen=True, slots=True)
class PlannedScatter:
    """A standard deviation."""

    value: Size
    """In `unit`."""
    unit: Annotated[str, ("enum", ("rad", "mm"))]
    """`rad` of a joint."""


def _names(poses: Mapping[str, Joints]) -> tuple[str, ...]:
    return tuple(poses)


def _with_units(sources: Mapping[str, float]) -> Mapping[str, PlannedScatter]:
    units = zip(sources.items(), UNITS, strict=True)
    return {name: PlannedScatter(value, unit) for (name, value), unit in units}


@dataclass(frozen=True, eq=False, slots=True)
class PlannedPosesTest:
    """A test of X and Y at several poses: what is recorded, where the joints are, what scatters.

    ``joints_deg`` has each arrival of a cycle, so that a pose that is approached from several
    directions is there for each. ``variances`` (4,) are those of joint 1 and joint 2 [rad2], of
    each dial's own [mm2] and the covariance of the joints.
    """

    conditions: Conditions = field(metadata=INTERNAL)
    arm: Arm = field(metadata=INTERNAL)
    joints_deg: Mapping[str, Joints] = field(metadata=published("poses", by=_names))
    """Their names."""
    variances: FloatArray = field(metadata=INTERNAL)
    division: tuple[Size, Size] = field(metadata=published("resolution_mm"))
    """Of X and Y; 0 for none."""
    cycles: Count = field(init=False)
    """That count."""
    columns: tuple[str, ...] = field(init=False)
    """That are recorded."""
    sources: Mapping[str, float] = field(init=False, metadata=published("scatter", by=_with_units))
    """Of `joint 1`, `joint 2`, and the `dial` itself."""
    sigma: Mapping[str, Annotated[Size, ("unit", "rad")]] = field(
        init=False, metadata=published("seen_in_a_cycle")
    )
    """Scatter of a joint's angle as all poses of one cycle show it."""

    def __post_init__(self) -> None:
        deviations = np.sqrt(self.variances[: len(SOURCES)]).tolist()
        columns = self.arm.jacobian([*self.joints_deg.values()])
        seen = np.linalg.solve(self.scatter, columns)
        known = np.einsum("pik,pik->k", columns, seen)
        fill(
            self,
            cycles=len(self.conditions),
            columns=tuple(self.conditions.covariates),
            sources=dict(zip(SOURCES, deviations, strict=True)),
            sigma=dict(zip(JOINTS, (1 / np.sqrt(known)).tolist(), strict=True)),
        )

    @property
    def directions(self) -> int:
        """From how many directions a pose is approached in a cycle."""
        return round(len(self.joints_deg) / len(set(self.joints_deg.values())))

    @property
    def scatter(self) -> FloatArray:
        """Covariances of X and Y at the poses, shape (P, 2, 2) [mm2]."""
        patterns = patterns_of(self.arm, [*self.joints_deg.values()])
        made = np.einsum("k,pkij->pij", self.variances, patterns)
        known = rounding_of(self.division) + _NO_SCATTER_MM**2 * np.eye(2)
        return np.asarray(made + known)

    @property
    def apart(self) -> PosesApart:
        """How well the poses tell joints, arm and dials apart, beside the scatter."""
        return poses_apart(self.arm, [*self.joints_deg.values()], self.scatter)


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
    enough(plan.conditions)
    catalogue = tuple(find_effects() if effects is None else effects)

    def in_one_scatter(conditions: Conditions) -> Travels:
        one = PlannedRun(conditions, 1.0, 0.0)
        return smallest_effects(one, catalogue, np.random.default_rng(seed))

    now = in_one_scatter(plan.conditions)

    def found(other: PlannedPosesTest) -> dict[str, Travels]:
        same = other.conditions is plan.conditions
        smallest = now if same else in_one_scatter(other.conditions)
        return {joint: _times(smallest, _SHARED * s) for joint, s in other.sigma.items()}

    before = DesignOfPoses(
        plan=plan,
        smallest=found(plan),
        apart=plan.apart,
        alike=collinear(hypotheses_of(catalogue, plan.conditions), plan.conditions),
        changes=(),
    )
    changes = [_change(words, found(other), other.apart, before) for words, other in _others(plan)]
    changes.sort(key=lambda one: round(max(one.size_needed.values()), 3))
    return replace(before, changes=tuple(changes))


def _times(smallest: Travels, sigma: float) -> Travels:
    return {effect: travel and travel * sigma for effect, travel in smallest.items()}


def _others(plan: PlannedPosesTest) -> Iterator[tuple[str, PlannedPosesTest]]:
    for words, conditions in other_conditions(plan.conditions):
        if plan.directions == 1 or "approach" not in conditions.covariates:
            yield words, replace(plan, conditions=conditions)
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


def _change(
    words: str,
    found: Mapping[str, Travels],
    apart: PosesApart,
    before: DesignOfPoses,
) -> ChangeOfPoses:
    resolved = _resolved(before.apart) / _resolved(apart)
    needed = {
        joint: resolved * _ratio(found[joint], then) for joint, then in before.smallest.items()
    }
    known = before.smallest[JOINTS[0]]
    adds = tuple(effect for effect in found[JOINTS[0]] if effect not in known)
    return ChangeOfPoses(words, found, apart, needed, adds)


def _resolved(apart: PosesApart) -> float:
    """Return the share of a movement of one joint that the other does not account for."""
    return max(math.sin(math.radians(apart.angle_deg)), _ALIKE)


def _ratio(found: Travels, before: Travels) -> float:
    """Return the geometric mean of what is found over what was, of effects that both find."""
    both = ((travel, before.get(effect)) for effect, travel in found.items())
    ratios = [now / then for now, then in both if now and then]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else 1.0


def like_test(test: AllPoses, arm: Arm, joints_deg: Mapping[str, Joints]) -> PlannedPosesTest:
    """Return the plan of a test like one that was measured: its columns, its dials, its scatter.

    The scatter is that from cycle to cycle, which a slow course leaves, traced to its sources.
    Raises `DataError` where X or Y is not there in mm.
    """
    names = [[axis_at(axis, pose) for axis in "XY"] for pose in joints_deg]
    axes = [[test.run.axes.get(name) for name in own] for own in names]
    if any(a is None or a.dimension is not Dimension.LENGTH for own in axes for a in own):
        raise DataError(
            "no X and Y in mm at every pose",
            where=test.run.origin.source,
            remedy="measure both: one alone does not tell the joints apart",
        )
    readings = np.array([[a.readings for a in own if a is not None] for own in axes])
    turns = np.diff(readings, axis=-1)
    steps = [[step_of(a) for a in own if a is not None] for own in axes]
    division = np.max(steps, axis=0)
    count = turns.shape[-1]
    covariances = PoseCovariances(
        observed=turns @ np.swapaxes(turns, -1, -2) / (2 * max(1, count)),
        freedom=np.full(len(joints_deg), max(1.0, count * 2 / 3)),
        patterns=patterns_of(arm, [*joints_deg.values()]),
        known=rounding_of(division),
    )
    conditions = Conditions(test.run.cycle, test.run.covariates)
    x, y = division.tolist()
    return PlannedPosesTest(conditions, arm, joints_deg, trace(covariances).variances, (x, y))
