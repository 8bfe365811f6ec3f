"""All poses of a test as one run, and where an effect may act: a joint, the arm, an axis, a pose.

The run has a row for each cycle and an axis for each indicator at each pose: what is common to the
visits of a cycle then stays together whatever is done with the cycles. A place is a subspace of the
movements of all axes at all poses. Once the course of an effect is known its size in each of them
is too, with the covariance of the scatter about it; how likely each place is then follows from how
much of these sizes it accounts for, under the g-prior.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.evidence import shrunk
from scara_iso.diagnosis.hypotheses import extended
from scara_iso.diagnosis.tuning import (
    FEWEST_CYCLES,
    GAIN,
    MISFIT,
    PLACE_NAMED,
    PLACE_RIVAL,
    PLACES,
)
from scara_iso.robot import Arm
from scara_iso.run import Axis, FloatArray, IntArray, Origin, Run

Joints: TypeAlias = tuple[float, float]
"""Joints 1 and 2 in degrees."""
_PLANES = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}


@dataclass(frozen=True, eq=False, slots=True)
class PoseAxis:
    """An indicator at a pose; ``unit`` is mm or deg."""

    pose: str
    axis: str
    unit: str


@dataclass(frozen=True, eq=False, slots=True)
class AllPoses:
    """A test as one ``run`` of all its poses; ``axes`` says which pose and indicator each is.

    ``parts`` are the rows of each pose alone, in the order of the run's cycles.
    """

    run: Run
    axes: Mapping[str, PoseAxis]
    parts: Mapping[str, Run]
    notes: tuple[str, ...]

    def planes(self) -> dict[str, tuple[str, ...]]:
        """Return the axes of each RP: every axis, and plane and space of each pose."""
        found: dict[str, tuple[str, ...]] = {name: (name,) for name in self.axes}
        for pose, part in self.parts.items():
            for plane, own in _PLANES.items():
                if set(own) <= set(part.axes):
                    found[axis_at(plane, pose)] = tuple(axis_at(axis, pose) for axis in own)
        return found


def axis_at(axis: str, pose: str) -> str:
    """Return the name of an axis, or a plane, at a pose."""
    return f"{axis} at {pose}"


def whole_cycles(run: Run, rows: Mapping[str, IntArray]) -> AllPoses:
    """Return the ``rows`` of a run that count, by pose, as one run.

    Cycles that are not there at every pose are left out, with a note; where poses hardly share a
    number their cycles are taken in turn.
    """
    parts, notes = _alike({pose: run.take(own) for pose, own in rows.items()})
    axes, of = {}, {}
    for pose, part in parts.items():
        for name, axis in part.axes.items():
            own = axis_at(name, pose)
            of[own] = PoseAxis(pose, name, axis.unit)
            axes[own] = Axis(own, axis.readings, axis.dimension, axis.resolution, axis.uncertainty)
    covariates, more = _of_cycles([*parts.values()])
    first = next(iter(parts.values()))
    origin = Origin(source=run.origin.source)
    whole = Run(first.cycle, axes, covariates=covariates, metadata=run.metadata, origin=origin)
    return AllPoses(whole, of, parts, (*notes, *more))


def _alike(parts: dict[str, Run]) -> tuple[dict[str, Run], list[str]]:
    """Return the poses with the same cycles, and what was left out for it."""
    shared = set.intersection(*(set(part.cycle.tolist()) for part in parts.values()))
    fewest = min(map(len, parts.values()))
    if len(shared) < min(FEWEST_CYCLES, fewest):
        note = "the poses do not share the numbers of their cycles: they are taken in turn"
        return {p: part.take(np.arange(fewest)) for p, part in parts.items()}, [note]
    gone = sorted({c for part in parts.values() for c in part.cycle.tolist()} - shared)
    kept = {
        pose: part.take(np.flatnonzero(np.isin(part.cycle, [*shared])))
        for pose, part in parts.items()
    }
    notes = (
        [f"cycle {', '.join(map(str, gone))}: not there at every pose, left out"] if gone else []
    )
    return kept, notes


def _of_cycles(parts: Sequence[Run]) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the covariates of the cycles: the means of their visits, where these are alike."""
    kept, notes = {}, []
    for name in parts[0].covariates:
        if not all(name in part.covariates for part in parts):
            continue
        visits = np.stack([part.covariates[name] for part in parts])
        mean = visits.mean(axis=0)
        within = visits - mean - (visits - mean).mean(axis=1, keepdims=True)
        if within.var() <= mean.var() or not np.ptp(visits):
            kept[name] = mean
        else:
            notes.append(
                f"{name} differs between the visits of a cycle: it is left out of the search over "
                "all poses; `pose=` searches one with it"
            )
    return kept, notes


_RANK = 1e-3
"""Length beside the other directions of a place, of 1, from which one is a direction of its own."""


@dataclass(frozen=True, eq=False, slots=True)
class Place:
    """Somewhere an effect may act; ``movement`` (axes, k) is that of all axes for unit sizes."""

    name: str
    movement: FloatArray
    weight: float
    """Prior weight among all places."""
    unit: str = ""
    """Of its one size: ``rad`` in a joint, 1 for the growth of the links; else that of an axis."""
    tied: bool = True
    """Whether its axes move together; else each has a size of its own."""
    joint: str | None = None
    """What it is called where it is one thing in the arm."""

    @property
    def alone(self) -> bool:
        """Whether it is a single pose."""
        return not self.tied and self.name != EVERY


@dataclass(frozen=True, eq=False, slots=True)
class Located:
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
        return self.probability[self.place.name] >= PLACE_NAMED and all(
            self.probability[rival] < PLACE_RIVAL
            for rival in self.rivals
            if rival != self.place.name
        )

    @property
    def joint_candidates(self) -> tuple[int, ...]:
        """The joints that cannot be told apart, where nothing but a joint is likely."""
        joints = {n: self.probability.get(f"joint {n}", 0.0) for n in (1, 2)}
        either = sum(joints.values()) + self.probability.get(BOTH, 0.0)
        likely = tuple(n for n, p in joints.items() if p >= PLACE_RIVAL)
        return likely if len(likely) > 1 and either >= PLACE_NAMED else ()


JOINTS = ("joint 1", "joint 2")
BOTH = "joints 1 and 2"
ARM = "along the arm"
EVERY = "every axis"
MOVEMENTS = (*JOINTS, ARM, "X everywhere", "Y everywhere")
"""What moves the tool at every pose, each along a direction of its own."""


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
    found: list[Place] = []
    if arm is not None and joints_deg is not None:
        found += _in_arm(columns, arm, joints_deg)
    alike = {}
    for axis in dict.fromkeys(column.axis for column in columns):
        own = np.array([column.axis == axis for column in columns])
        if len({c.pose for c, one in zip(columns, own, strict=True) if one}) > 1:
            unit = next(c.unit for c in columns if c.axis == axis)
            joint = "joint 4" if found and (axis, unit) == ("theta", "deg") else None
            alike[joint or f"{axis} everywhere"] = (own, unit, joint)
    found += [
        Place(name, own[:, np.newaxis] * 1.0, PLACES["axis"] / len(alike), unit, joint=joint)
        for name, (own, unit, joint) in alike.items()
    ]
    poses = dict.fromkeys(column.pose for column in columns)
    every = np.eye(len(columns))
    for pose in poses:
        own = np.array([column.pose == pose for column in columns])
        found.append(Place(pose, every[:, own], PLACES["pose"] / len(poses), tied=False))
    return (*found, Place(EVERY, every, PLACES["every"], tied=False))


def _in_arm(columns: Sequence[PoseAxis], arm: Arm, joints_deg: Mapping[str, Joints]) -> list[Place]:
    """Return the joints that the axes show, both of them together, and the growth of the links."""
    plane = ("X", "Y")
    if not any(column.axis in plane for column in columns):
        return []
    moves = np.zeros((len(columns), 3))
    for row, column in zip(moves, columns, strict=True):
        if column.axis in plane:
            row[:] = arm.movements(joints_deg[column.pose])[plane.index(column.axis)]
        elif (column.axis, column.unit) == ("theta", "deg"):
            row[:2] = math.degrees(1.0)
    one = PLACES["joint"] / 2
    return [
        Place("joint 1", moves[:, :1], one, "rad", joint="joint 1"),
        Place("joint 2", moves[:, 1:2], one, "rad", joint="joint 2"),
        Place(BOTH, moves[:, :2], PLACES["joints"], "rad"),
        Place(ARM, moves[:, 2:], PLACES["arm"], "1", joint=ARM),
    ]


def separation(places: Sequence[Place], values: FloatArray, poses: IntArray) -> tuple[float, float]:
    """Return the angle in degrees between joints 1 and 2 beside scatter, and the poses' index.

    ``values`` (n, axes) are the readings. The observability index is the ratio of the smaller to
    the larger singular value of the joints' movements (Nahvi and Hollerbach 1996): 0 where these
    poses cannot tell the joints apart.
    """
    both = next(place.movement for place in places if place.name == BOTH)
    free = values - values.mean(axis=0)
    nu = len(free) - 1
    scatter = _with_root(shrunk(free.T @ free / nu, poses, nu), nu)
    seen = np.linalg.solve(np.linalg.cholesky(scatter), both)
    one, other = (seen / np.linalg.norm(seen, axis=0)).T
    singular = np.linalg.svd(both, compute_uv=False)
    angle = math.degrees(math.acos(min(1.0, abs(float(one @ other)))))
    return angle, float(singular[-1] / singular[0])


def locate(
    course: FloatArray,
    basis: FloatArray,
    values: FloatArray,
    places: Sequence[Place],
    poses: IntArray,
) -> Located:
    """Return where an effect of known ``course`` (n, k) acts in ``values`` (n, axes).

    ``basis`` (n, f) is what was fitted before; ``poses`` (axes,) numbers the pose of each axis.
    Scatter is taken to be Student's about the sizes, since its covariance is estimated; no arm
    follows its geometry to the last digit, so MISFIT of what a pose moves is allowed for.
    """
    free_course = extended(basis, course)[:, basis.shape[1] :]
    free = values - basis @ (basis.T @ values)
    sizes = free_course.T @ free
    left = free - free_course @ sizes
    nu = max(1, len(values) - basis.shape[1] - free_course.shape[1])
    scatter = _with_root(shrunk(left.T @ left / nu, poses, nu), nu) + _misfit(sizes, poses)
    root = np.linalg.cholesky(scatter)
    seen = np.linalg.solve(root, sizes.T)
    total = float((seen**2).sum())
    log = {}
    for place in places:
        own = _orthonormal(np.linalg.solve(root, place.movement))
        explained = float(((own.T @ seen) ** 2).sum()) * GAIN / (1 + GAIN)
        gained = np.log1p(total / nu) - np.log1p((total - explained) / nu)
        power, k = nu + seen.size, own.shape[1] * len(sizes)
        log[place.name] = np.log(place.weight) + power / 2 * gained - k / 2 * np.log1p(GAIN)
    likely = np.exp(np.array([*log.values()]) - max(log.values()))
    probability = dict(zip(log, (likely / likely.sum()).tolist(), strict=True))
    best = max(places, key=lambda place: log[place.name])
    inverse = np.linalg.solve(scatter, best.movement)
    weights = inverse @ np.linalg.pinv(best.movement.T @ inverse)
    rivals = frozenset(p.name for p in places if p.name in JOINTS or p.alone)
    return Located(best, weights, probability, rivals)


def _misfit(sizes: FloatArray, poses: IntArray) -> FloatArray:
    moved = (sizes**2).sum(axis=0)
    by_pose = np.array([moved[poses == p].mean() for p in poses])
    return np.asarray(np.diag(MISFIT**2 * by_pose))


def _with_root(scatter: FloatArray, nu: int) -> FloatArray:
    """Return a covariance from ``nu`` cycles that has a root, however few they are.

    Each variance counts as much more as one cycle in ``nu`` does; an axis without scatter has some.
    """
    variance = np.diag(scatter)
    least = 1e-9 * float(variance.max()) + np.finfo(float).tiny
    return np.asarray(scatter + np.diag(variance / nu + least))


def _orthonormal(directions: FloatArray) -> FloatArray:
    """Return an orthonormal basis of directions (axes, k), those alike taken for one."""
    scaled = directions / np.maximum(np.linalg.norm(directions, axis=0), 1e-300)
    u, s, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(u[:, s > _RANK])
