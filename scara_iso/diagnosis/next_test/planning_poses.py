"""What a planned test of several poses will tell of the joints, and what would help it.

All axes at all poses tell the size of an effect in a joint as one channel does: the least-squares
estimate from a cycle, whose scatter follows from the covariances of the poses. A joint's smallest
effect is therefore that of one axis (`planning`), in that scatter, and somewhat more, since the
search looks at other places too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Annotated, Literal

import numpy as np

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import INTERNAL, MERGED, Count, Size, fill, published
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.all_poses import AllPoses, axis_at
from scara_iso.diagnosis.joint_scatter.covariances import PoseCovariances
from scara_iso.diagnosis.joint_scatter.poses import PLANE, Joints
from scara_iso.diagnosis.joint_scatter.tracing import (
    SOURCES,
    UNITS,
    patterns_of,
    rounding_of,
    trace,
)
from scara_iso.diagnosis.likelihood.hypotheses import hypotheses_of
from scara_iso.diagnosis.next_test.planning import (
    Alike,
    PlannedRun,
    Travels,
    collinear,
    enough,
    other_conditions,
    smallest_effects,
)
from scara_iso.diagnosis.next_test.separating import PosesApart, poses_apart, separating_plan
from scara_iso.diagnosis.places import JOINTS
from scara_iso.diagnosis.tuning import SEED
from scara_iso.effects import Conditions, Effect, find_effects
from scara_iso.iso9283 import PoseTestConditions
from scara_iso.robot import Arm, Rated
from scara_iso.run import FloatArray, step_of

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
        known = rounding_of(np.asarray(self.division)) + _NO_SCATTER_MM**2 * np.eye(2)
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
    told = _told(before.apart) / _told(apart)
    needed = {joint: told * _ratio(found[joint], then) for joint, then in before.smallest.items()}
    known = before.smallest[JOINTS[0]]
    adds = tuple(effect for effect in found[JOINTS[0]] if effect not in known)
    return ChangeOfPoses(words, found, apart, needed, adds)


def _told(apart: PosesApart) -> float:
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
    names = [[axis_at(axis, pose) for axis in PLANE] for pose in joints_deg]
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
        known=np.broadcast_to(rounding_of(division), (len(joints_deg), 2, 2)),
    )
    conditions = Conditions(test.run.cycle, test.run.covariates)
    x, y = division.tolist()
    return PlannedPosesTest(conditions, arm, joints_deg, trace(covariances).variances, (x, y))
