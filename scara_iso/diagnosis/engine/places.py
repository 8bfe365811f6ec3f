"""Where in the robot an effect may act: a joint, the arm, an axis, a pose.

A place is a subspace of the movements of all axes at all poses. Once the course of an effect is
known its size in each of them is too, with the covariance of the scatter about it; how likely each
place is then follows from how much of these sizes it accounts for, under the g-prior.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.engine.evidence import extended, shrunk
from scara_iso.diagnosis.engine.hypotheses import GAIN
from scara_iso.diagnosis.engine.residual import Joints, PoseAxis
from scara_iso.diagnosis.engine.rounded import MISFIT
from scara_iso.robot import Arm
from scara_iso.run import FloatArray, IntArray

JOINTS = ("joint 1", "joint 2")
ARM = "along the arm"
EVERY = "every axis"
MOVEMENTS = (*JOINTS, ARM, "X everywhere", "Y everywhere")
"""What moves the tool at every pose, each along a direction of its own."""
_IN_ARM = (*JOINTS, "joint 4", ARM)

PLACE_NAMED, PLACE_RIVAL = 0.6, 0.1
"""Probability from which the place of an effect is named, and that which a joint or a single pose
must not reach beside it. The right joint is less likely than it is right (joints.py)."""

PLACES = {"joint": 0.5, "arm": 0.06, "axis": 0.1, "pose": 0.27, "every": 0.05}
"""Prior weight of the kinds of places: one of the joints, the links, an axis everywhere alike, one
pose, anything else."""


class Place(NamedTuple):
    """Somewhere an effect may act; ``movement`` (axes, k) is that of all axes for unit sizes."""

    name: str
    movement: FloatArray
    weight: float
    """Prior weight among all places."""
    unit: str = ""
    """Of its one size: ``rad`` in a joint, 1 for the growth of the links; else that of an axis."""

    @property
    def tied(self) -> bool:
        """Whether its axes move together; else each has a size of its own."""
        return bool(self.unit)

    @property
    def joint(self) -> str | None:
        """What it is called where it is one thing in the arm."""
        return self.name if self.name in _IN_ARM else None


class Located(NamedTuple):
    """The likeliest place, how likely each is, and how its sizes follow from the axes'.

    ``weights`` (axes, k): sizes are the axes' movements (axes,) times it.
    """

    place: Place
    weights: FloatArray
    probability: Mapping[str, float]
    rivals: frozenset[str]
    """The joints and the single poses: what is named must not be one of them by mistake."""

    @property
    def is_sure(self) -> bool:
        """Whether the place may be named: it is likely, and no joint or pose is besides it."""
        others = self.rivals - {self.place.name}
        return self.probability[self.place.name] >= PLACE_NAMED and all(
            self.probability[rival] < PLACE_RIVAL for rival in others
        )

    @property
    def joint_candidates(self) -> tuple[int, ...]:
        """The joints that cannot be told apart, where nothing but a joint is likely."""
        joints = {n: self.probability.get(f"joint {n}", 0.0) for n in (1, 2)}
        likely = tuple(n for n, p in joints.items() if p >= PLACE_RIVAL)
        return likely if len(likely) > 1 and sum(joints.values()) >= PLACE_NAMED else ()


def movements(arm: Arm, joints_deg: npt.ArrayLike) -> FloatArray:
    """Return how X and Y move at poses (..., 2) for unit sizes of the `MOVEMENTS` (..., 2, 5)."""
    moves = arm.movements(joints_deg)
    alike = np.broadcast_to(np.eye(2), (*moves.shape[:-1], 2))
    return np.concatenate([moves, alike], axis=-1)


def places_of(
    columns: Sequence[PoseAxis],
    arm: Arm | None = None,
    joints_deg: Mapping[str, Joints] | None = None,
) -> tuple[Place, ...]:
    """Return where an effect may act that the axes ``columns`` show.

    With an arm and its joints at every pose that is also in its joints and along its links; without
    them, in an axis everywhere alike, at one pose, or anywhere.
    """
    found = [] if arm is None or joints_deg is None else _in_arm(columns, arm, joints_deg)
    every = np.eye(len(columns))
    by_axis: dict[tuple[str, str], list[int]] = {}
    by_pose: dict[str, list[int]] = {}
    for k, column in enumerate(columns):
        by_axis.setdefault((column.axis, column.unit), []).append(k)
        by_pose.setdefault(column.pose, []).append(k)
    alike = {axis: own for axis, own in by_axis.items() if len(own) > 1}
    for (axis, unit), own in alike.items():
        is_joint_4 = found and (axis, unit) == ("theta", "deg")
        name = "joint 4" if is_joint_4 else f"{axis} everywhere"
        moved = every[:, own].sum(axis=1, keepdims=True)
        found.append(Place(name, moved, PLACES["axis"] / len(alike), unit))
    for pose, own in by_pose.items():
        found.append(Place(pose, every[:, own], PLACES["pose"] / len(by_pose)))
    return (*found, Place(EVERY, every, PLACES["every"]))


def _in_arm(columns: Sequence[PoseAxis], arm: Arm, joints_deg: Mapping[str, Joints]) -> list[Place]:
    plane = ("X", "Y")
    if not any(column.axis in plane for column in columns):
        return []
    moves = np.zeros((len(columns), 3))
    for row, column in zip(moves, columns, strict=True):
        if column.axis in plane:
            row[:] = arm.movements(joints_deg[column.pose])[plane.index(column.axis)]
        elif (column.axis, column.unit) == ("theta", "deg"):
            row[:2] = math.degrees(1.0)
    kinds = [*((name, PLACES["joint"] / 2, "rad") for name in JOINTS), (ARM, PLACES["arm"], "1")]
    return [
        Place(name, moves[:, [k]], weight, unit) for k, (name, weight, unit) in enumerate(kinds)
    ]


def possible_places(
    places: Sequence[Place], poses: IntArray, pose: int | None, *, grows: bool
) -> list[Place]:
    """Return the places that an effect can have: those at its ``pose``, where it has but one.

    ``poses`` (axes,) numbers the pose of each axis. The links are one where the effect ``grows``:
    they do not in one cycle.
    """
    return [
        place
        for place in places
        if (pose is None or (poses[place.movement.any(axis=1)] == pose).all())
        and (grows or place.name != ARM)
    ]


def locate(
    course: FloatArray,
    basis: FloatArray,
    values: FloatArray,
    places: Sequence[Place],
    poses: IntArray,
    of: IntArray | None = None,
) -> Located:
    """Return where an effect of known ``course`` (n, k) acts in ``values`` (n, axes).

    ``basis`` (n, f) is what was fitted before; ``poses`` (axes,) numbers the pose of each axis.
    Where each axis follows one column alone, ``of`` says which.
    Scatter is taken to be Student's about the sizes, since its covariance is estimated; no arm
    follows its geometry to the last digit, so MISFIT of what a pose moves is allowed for. Each
    variance counts as much more as one cycle in nu does; an axis without scatter has some.
    """
    free = values - basis @ (basis.T @ values)
    if of is None:
        free_course = extended(basis, course)[:, basis.shape[1] :]
        sizes = free_course.T @ free
        left = free - free_course @ sizes
    else:
        own = (course - basis @ (basis.T @ course))[:, of[: len(poses)]]
        own /= np.sqrt((own**2).sum(axis=0).mean())
        sizes = ((own * free).sum(axis=0) / (own**2).sum(axis=0))[np.newaxis]
        left = free - own * sizes
    nu = max(1, len(values) - basis.shape[1] - len(sizes))
    scatter = shrunk(left.T @ left / nu, poses, nu)
    variance, moved = np.diag(scatter), (sizes**2).sum(axis=0)
    of_pose = poses[:, np.newaxis] == poses
    misfit = MISFIT**2 * (of_pose @ moved) / of_pose.sum(axis=1)
    least = 1e-9 * float(variance.max()) + np.finfo(float).tiny
    scatter = scatter + np.diag(variance / nu + least + misfit)
    root = np.linalg.cholesky(scatter)
    seen = np.linalg.solve(root, sizes.T)
    total = float((seen**2).sum())
    log = {}
    for place in places:
        own = np.linalg.qr(np.linalg.solve(root, place.movement))[0]
        explained = float(((own.T @ seen) ** 2).sum()) * GAIN / (1 + GAIN)
        gained = np.log1p(total / nu) - np.log1p((total - explained) / nu)
        power, k = nu + seen.size, own.shape[1] * len(sizes)
        log[place.name] = np.log(place.weight) + power / 2 * gained - k / 2 * np.log1p(GAIN)
    likely = np.exp(np.array([*log.values()]) - max(log.values()))
    probability = dict(zip(log, (likely / likely.sum()).tolist(), strict=True))
    best = max(places, key=lambda place: log[place.name])
    inverse = np.linalg.solve(scatter, best.movement)
    weights = inverse @ np.linalg.pinv(best.movement.T @ inverse)
    alone = (p.name for p in places if not p.tied and p.name != EVERY)
    return Located(best, weights, probability, frozenset((*JOINTS, *alone)) & probability.keys())
