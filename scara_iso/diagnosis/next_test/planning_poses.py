"""What a planned test of several poses will tell of the joints, and what would help it.

All axes at all poses tell the size of an effect in a joint as one channel does: the least-squares
estimate from a cycle, whose scatter follows from the covariances of the poses. A joint's smallest
effect is therefore that of one axis (`planning`), in that scatter, and somewhat more, since the
search looks at other places too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.all_poses import AllPoses, axis_at
from scara_iso.diagnosis.joint_scatter.covariances import PoseCovariances
from scara_iso.diagnosis.joint_scatter.poses import PLANE, Joints
from scara_iso.diagnosis.joint_scatter.tracing import SOURCES, patterns_of, rounding_of, trace
from scara_iso.diagnosis.likelihood.hypotheses import hypotheses_of
from scara_iso.diagnosis.next_test.planning import (
    Alike,
    PlannedRun,
    Smallest,
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


@dataclass(frozen=True, eq=False, slots=True)
class PlannedPosesTest:
    """A test of X and Y at several poses: what is recorded, where the joints are, what scatters.

    ``joints_deg`` has each arrival of a cycle, so that a pose that is approached from several
    directions is there for each. ``variances`` (4,) are those of joint 1 and joint 2 [rad2], of
    each dial's own [mm2] and the covariance of the joints; ``division`` is of X and Y [mm], 0 for
    none.
    """

    conditions: Conditions
    arm: Arm
    joints_deg: Mapping[str, Joints]
    variances: FloatArray
    division: tuple[float, float]

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
    def sources(self) -> dict[str, float]:
        """Standard deviation of each source of scatter: joints in rad, the dial in mm."""
        return dict(zip(SOURCES, np.sqrt(self.variances[: len(SOURCES)]).tolist(), strict=True))

    @property
    def sigma(self) -> dict[str, float]:
        """Scatter of a joint's angle as all poses of one cycle show it, in rad, by joint."""
        columns = self.arm.jacobian([*self.joints_deg.values()])
        seen = np.linalg.solve(self.scatter, columns)
        known = np.einsum("pik,pik->k", columns, seen)
        return dict(zip(JOINTS, (1 / np.sqrt(known)).tolist(), strict=True))

    @property
    def apart(self) -> PosesApart:
        """How well the poses tell joints, arm and dials apart, beside the scatter."""
        return poses_apart(self.arm, [*self.joints_deg.values()], self.scatter)


@dataclass(frozen=True, slots=True)
class ChangeOfPoses:
    """Another plan in words, what it would find, and the gain.

    ``size_needed`` is the size in each joint that is found and told from the other joint, over that
    of the plan, over all effects that both know; ``adds`` are the effects that only it tells.
    """

    change: str
    smallest: Mapping[str, tuple[Smallest, ...]]
    apart: PosesApart
    size_needed: Mapping[str, float]
    adds: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DesignOfPoses:
    """What the plan finds in each joint [rad], what it cannot tell apart, and what would help.

    ``changes`` have the largest gain first.
    """

    smallest: Mapping[str, tuple[Smallest, ...]]
    apart: PosesApart
    alike: tuple[Alike, ...]
    changes: tuple[ChangeOfPoses, ...]


def design_of_poses(
    plan: PlannedPosesTest, *, seed: int = SEED, effects: Sequence[Effect] | None = None
) -> DesignOfPoses:
    """Return what a test of several poses will be able to tell of the joints.

    Raises `DataError` for fewer than 8 cycles.
    """
    enough(plan.conditions)
    catalogue = tuple(find_effects() if effects is None else effects)

    def in_one_scatter(conditions: Conditions) -> tuple[Smallest, ...]:
        one = PlannedRun(conditions, 1.0, 0.0)
        return smallest_effects(one, catalogue, np.random.default_rng(seed))

    now = in_one_scatter(plan.conditions)

    def found(other: PlannedPosesTest) -> dict[str, tuple[Smallest, ...]]:
        same = other.conditions is plan.conditions
        smallest = now if same else in_one_scatter(other.conditions)
        return {joint: _times(smallest, _SHARED * s) for joint, s in other.sigma.items()}

    before = DesignOfPoses(
        smallest=found(plan),
        apart=plan.apart,
        alike=collinear(hypotheses_of(catalogue, plan.conditions), plan.conditions),
        changes=(),
    )
    changes = [_change(words, found(other), other.apart, before) for words, other in _others(plan)]
    changes.sort(key=lambda one: round(max(one.size_needed.values()), 3))
    return replace(before, changes=tuple(changes))


def _times(smallest: Sequence[Smallest], sigma: float) -> tuple[Smallest, ...]:
    return tuple(replace(s, travel=s.travel and s.travel * sigma) for s in smallest)


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
    found: Mapping[str, tuple[Smallest, ...]],
    apart: PosesApart,
    before: DesignOfPoses,
) -> ChangeOfPoses:
    told = _told(before.apart) / _told(apart)
    needed = {joint: told * _ratio(found[joint], then) for joint, then in before.smallest.items()}
    known = {one.effect for one in before.smallest[JOINTS[0]]}
    adds = tuple(one.effect for one in found[JOINTS[0]] if one.effect not in known)
    return ChangeOfPoses(words, found, apart, needed, adds)


def _told(apart: PosesApart) -> float:
    """Return the share of a movement of one joint that the other does not account for."""
    return max(math.sin(math.radians(apart.angle_deg)), _ALIKE)


def _ratio(found: Sequence[Smallest], before: Sequence[Smallest]) -> float:
    """Return the geometric mean of what is found over what was, of effects that both find."""
    then = {one.effect: one.travel for one in before if one.travel}
    ratios = [one.travel / then[one.effect] for one in found if one.travel and one.effect in then]
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
