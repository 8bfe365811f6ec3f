"""Poses at which the joints of an arm show what each of them does, and the dials what they do.

A movement is told from another by its direction in the space of all axes at all poses. What
`diagnose` tells apart there are the two joints, the growth of the links, and X and Y everywhere
alike. Sought are poses from which the size of an effect in either joint is known best, although
any one of the others may act as well: by exchange (Fedorov 1972), one pose at a time, from several
starts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Annotated, Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from scara_iso.base.displayed import Plotted
from scara_iso.base.errors import UsageError
from scara_iso.base.published import INTERNAL, Size, fill
from scara_iso.diagnosis.engine.places import MOVEMENTS, movements
from scara_iso.iso9283 import (
    CYCLES,
    PlannedPose,
    PlannedVisit,
    Poses,
    PoseTestConditions,
    planned_poses,
    planned_visits,
)
from scara_iso.robot import Arm, Elbow, Rated
from scara_iso.run import FloatArray, frame_of

if TYPE_CHECKING:
    import pandas as pd


Angle: TypeAlias = Annotated[float, ("unit", "deg"), ("minimum", 0)]
PROPOSED: Final = "proposed"
GIVEN: Final = "given"
STANDARD: Final = "standard"
"""The poses of a plan, of the model, and of ISO 9283."""
_POSES = 5
_CELLS = (37, 25)
"""Steps of joint 1 and joint 2 between which a pose is chosen."""
_MARGIN = 0.05
"""Share of a joint's range at either end that is left out: a pose is approached from both sides."""
_SINGULAR_DEG = 20.0
"""Nearest to straight or folded that a pose is taken: the arm is slow and stiff there."""
_JOINTS_OVER_DIAL = 5.0
"""Scatter of each joint at full reach over that of a dial, as far as poses are compared: of 2, 3
and 5 the one at which the angles between the joints gain too (docs/joints.md)."""
_NEAREST = 0.12
"""Share of the reach by which poses are apart: each has a fixture and its indicators."""
_STARTS = 20
_DIGITS = 9
"""Decimals that count: rounding must not choose between equal poses."""


@dataclass(frozen=True, slots=True)
class PosesApart:
    """How well poses tell apart what moves them."""

    angle_deg: Angle
    """Between joints 1 and 2."""
    observability_index: Size
    """Of joints 1 and 2."""
    smallest_angle_deg: Angle
    """Between any two of joints, arm, X and Y everywhere."""
    between: tuple[str, str]
    """The two movements of that angle."""
    uncertainty: Size
    """Of the size of an effect in a joint from one cycle, in that joint's scatter, where any one of
    the other movements may act too: the larger of both joints."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SeparatingPlan(Plotted):
    """``plan`` of poses that tell the joints apart. Lengths in mm, in the base frame."""

    schema: Literal["scara-iso/plan-separating/1"] = "scara-iso/plan-separating/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    elbow: Elbow
    """Side of the elbow at every pose."""
    poses: Poses[PlannedPose] = field(metadata=INTERNAL)
    """By number or name, in the order of joint 1; z is the middle of the quill."""
    apart: Mapping[Annotated[str, ("enum", (PROPOSED, GIVEN, STANDARD))], PosesApart]
    """How well these poses tell the movements apart, and beside them those of the model (given) and
    of ISO 9283's cube (standard), as far as there are any."""
    conditions: PoseTestConditions = field(metadata=CYCLES)
    """Of each pose."""
    arm: Arm = field(metadata=INTERNAL)
    """The arm that it is planned for."""
    rated: Rated
    """Load and velocity."""
    visits: tuple[PlannedVisit, ...] = field(init=False)
    """One cycle, in order; from pose to pose the joints turn."""

    def __post_init__(self) -> None:
        visits = planned_visits(self.poses, self.conditions, self.rated, path="joint")
        fill(self, visits=visits)

    def __repr__(self) -> str:
        angle = self.apart[PROPOSED].smallest_angle_deg
        return f"<SeparatingPlan: {len(self.poses)} poses, smallest angle {angle:.0f} deg>"

    def to_frame(self) -> pd.DataFrame:
        """Return one cycle as a pandas table: the columns of `rows`, a row for each visit."""
        return frame_of(self.rows(), {})

    def rows(self) -> list[Mapping[str, str | int | float | None]]:
        """Return one cycle as a table, as `PosePlan.rows`."""
        return [asdict(visit) for visit in self.visits]


def separating_plan(
    arm: Arm,
    given: Mapping[str, Sequence[tuple[float, float]]],
    *,
    elbow: Elbow | None = None,
    conditions: PoseTestConditions,
    rated: Rated,
) -> SeparatingPlan:
    """Return five poses that tell the joints of ``arm`` apart, beside others that are ``given``.

    Those are joints 1 and 2 in degrees, by the names of `SeparatingPlan.apart`. All proposed poses
    have one elbow: the named one, else the better. Raises `UsageError` where the limits leave no
    pose away from straight and folded, or no five that are apart.
    """
    found = {}
    for side in tuple(Elbow) if elbow is None else (elbow,):
        joints = _exchanged(arm, _grid(arm, side))
        if joints is not None:
            found[side] = joints
    if not found:
        raise UsageError(
            f"the limits leave no room for {_POSES} poses, {_NEAREST:.0%} of the reach apart and "
            f"{_SINGULAR_DEG:g} degrees from straight and folded",
            remedy="take the other elbow, or correct the arm's limits",
        )
    # rounding must not choose between mirrored elbows
    best = min(found, key=lambda side: poses_apart(arm, found[side]).uncertainty)
    joints = found[best][np.argsort(found[best][:, 0], kind="stable")]
    # whole micrometres, as a controller takes them
    joints = arm.inverse(np.round(arm.forward(joints), 3), elbow=best)
    height, turn = sum(arm.quill_mm) / 2, sum(arm.joint_4_deg) / 2
    whole = np.column_stack([joints, np.tile([height, turn], (len(joints), 1))])
    poses = planned_poses(arm, np.round(arm.forward(whole), 6), whole)
    chosen = [(pose.joint_1_deg, pose.joint_2_deg) for pose in poses]
    sets = {PROPOSED: chosen, **given}
    apart = {name: poses_apart(arm, own) for name, own in sets.items()}
    return SeparatingPlan(
        elbow=best, poses=Poses(poses), apart=apart, conditions=conditions, arm=arm, rated=rated
    )


def poses_apart(
    arm: Arm, joints_deg: npt.ArrayLike, scatter: FloatArray | None = None
) -> PosesApart:
    """Return how well poses (P, 2), joints 1 and 2 in degrees, tell `MOVEMENTS` apart.

    Angles are beside the covariances ``scatter`` (P, 2, 2) of X and Y, else dials alike everywhere.
    """
    alike = np.broadcast_to(np.eye(2), (len(np.asarray(joints_deg)), 2, 2))
    known = _known(arm, joints_deg, alike if scatter is None else scatter).sum(axis=0)
    length = np.sqrt(np.maximum(np.diagonal(known), np.finfo(float).tiny))
    cosines = np.abs(known) / np.outer(length, length)
    pairs = list(combinations(range(len(MOVEMENTS)), 2))
    one, other = max(pairs, key=lambda pair: round(float(cosines[pair]), _DIGITS))
    least, most = np.linalg.eigvalsh(_known(arm, joints_deg, alike).sum(axis=0)[:2, :2])
    nominal = _known(arm, joints_deg, _nominal(arm, joints_deg)).sum(axis=0)
    return PosesApart(
        _angle(cosines[0, 1]),
        math.sqrt(max(0.0, float(least / most))),
        _angle(cosines[one, other]),
        (MOVEMENTS[one], MOVEMENTS[other]),
        float(_uncertainty(nominal)),
    )


def _angle(cosine: float) -> float:
    return math.degrees(math.acos(min(1.0, float(cosine))))


def _known(arm: Arm, joints_deg: npt.ArrayLike, scatter: FloatArray) -> FloatArray:
    """Return what each pose tells of the sizes of the `MOVEMENTS` beside its scatter (P, 5, 5).

    Those of several poses together are their sums.
    """
    moves = movements(arm, joints_deg)
    return np.asarray(np.swapaxes(moves, -1, -2) @ np.linalg.solve(scatter, moves))


def _nominal(arm: Arm, joints_deg: npt.ArrayLike) -> FloatArray:
    """Return covariances (P, 2, 2) of X and Y, in those of a joint alone where its lever is 1."""
    jacobian = arm.jacobian(joints_deg)
    dial = ((arm.link_1_mm + arm.link_2_mm) / _JOINTS_OVER_DIAL) ** 2
    return np.asarray(jacobian @ np.swapaxes(jacobian, -1, -2) + dial * np.eye(2))


def _uncertainty(known: FloatArray) -> FloatArray:
    """Return how well poses (..., 5, 5) show a joint's size beside any one other movement."""
    own = np.diagonal(known, axis1=-2, axis2=-1)
    shared = known[..., :2, :] ** 2 / np.maximum(own, np.finfo(float).tiny)[..., np.newaxis, :]
    left = own[..., :2, np.newaxis] - shared
    left[..., [0, 1], [0, 1]] = np.inf
    least = np.maximum(left.min(axis=(-2, -1)), np.finfo(float).tiny)
    return np.asarray((1 / np.sqrt(least)).round(_DIGITS))


def _grid(arm: Arm, elbow: Elbow) -> FloatArray:
    """Return the joints (m, 2) in degrees among which poses are chosen."""
    axes = []
    for (low, high), count in zip(arm.limits, _CELLS, strict=False):
        room = _MARGIN * (high - low)
        axes.append(np.linspace(low + room, high - room, count))
    joints = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    own = np.sign(np.sin(np.radians(joints[:, 1]))) == elbow.sign
    return np.asarray(joints[own & (arm.singularity_deg(joints) >= _SINGULAR_DEG)])


def _exchanged(arm: Arm, grid: FloatArray) -> FloatArray | None:
    """Return the poses (P, 2) of a grid (m, 2) that tell the movements apart; None: no room."""
    if not len(grid):
        return None
    known, places = _known(arm, grid, _nominal(arm, grid)), arm.forward(grid)
    between = np.linalg.norm(places[:, np.newaxis] - places, axis=-1)
    near = between < _NEAREST * (arm.link_1_mm + arm.link_2_mm)
    found = []
    for start in range(1, _STARTS + 1):
        chosen, reached, now = [start * k**2 % len(grid) for k in range(_POSES)], np.inf, 1e300
        while now < reached:
            reached = now
            for k in range(_POSES):
                others = chosen[:k] + chosen[k + 1 :]
                worse = _uncertainty(known[others].sum(axis=0) + known)
                worse[near[others].any(axis=0)] = np.inf
                chosen[k] = int(np.argmin(worse))
            now = float(_uncertainty(known[chosen].sum(axis=0)))
        found.append((now, chosen))
    best = min(found)[1]
    return grid[best] if np.count_nonzero(near[np.ix_(best, best)]) == _POSES else None
