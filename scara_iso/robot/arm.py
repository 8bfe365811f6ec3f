"""SCARA geometry: joints to tool point and back, Jacobian, reach, what a joint's error moves.

Joints 1, 2 and 4 turn about vertical axes, joint 3 is the quill. Lengths are in mm, angles in
degrees, both in the base frame: joint 1 is measured from its x axis, joint 2 from link 1, joint 3
is the height z of the tool point, and the tool's orientation is theta = joint 1 + joint 2 +
joint 4. Arrays hold poses along their leading dimensions.
"""

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import UsageError
from scara_iso.run import FloatArray

JOINTS = ("joint 1", "joint 2", "joint 3", "joint 4")
JOINT_UNITS = ("deg", "deg", "mm", "deg")

_SLACK = 1e-9
"""What rounding may add to a joint or a distance, in degrees or mm, without leaving a limit."""
_LONGEST = 1e6
"""No arm is a kilometre long; mm."""
_SHOWN = 3
"""How many poses an error names."""


class Elbow(Enum):
    """Side of the line from base to tool on which the elbow lies, seen from above."""

    RIGHT = "right"
    """Joint 2 turns counter-clockwise: its sine is positive."""
    LEFT = "left"
    """Joint 2 turns clockwise: its sine is negative."""

    @property
    def sign(self) -> int:
        """Sign of the sine of joint 2: +1 right, -1 left."""
        return 1 if self is Elbow.RIGHT else -1


@dataclass(frozen=True, slots=True)
class Arm:
    """A SCARA arm: two link lengths and the (lowest, highest) position of each joint.

    ``link_1_mm`` and ``link_2_mm`` are distances between the vertical axes; ``joint_1_deg``,
    ``joint_2_deg`` and ``joint_4_deg`` limits of the turning joints.

    Raises `UsageError`, naming every fault, for a length that is not positive or is beyond a
    kilometre, or limits that are not two finite numbers in order.
    """

    link_1_mm: float
    link_2_mm: float
    joint_1_deg: tuple[float, float] = (-180.0, 180.0)
    joint_2_deg: tuple[float, float] = (-180.0, 180.0)
    quill_mm: tuple[float, float] = (0.0, 0.0)
    """Lowest and highest z of the tool point in the base frame; their difference is the stroke."""
    joint_4_deg: tuple[float, float] = (-360.0, 360.0)

    def __post_init__(self) -> None:
        links = {"link_1_mm": self.link_1_mm, "link_2_mm": self.link_2_mm}
        limits = dict(zip(JOINTS, self.limits.tolist(), strict=True))
        faults = [f"{name} is {v:g}" for name, v in links.items() if not 0 < v <= _LONGEST]
        faults += [
            f"{name} goes from {low:g} to {high:g}"
            for name, (low, high) in limits.items()
            if not -math.inf < low <= high < math.inf
        ]
        if faults:
            raise UsageError(
                f"not a possible arm: {', '.join(faults)}",
                remedy="links are positive, in mm, limits finite and in order (lowest, highest)",
            )

    @property
    def limits(self) -> FloatArray:
        """Limits of the four joints, shape (4, 2): lowest and highest, in deg, deg, mm, deg."""
        return np.array([self.joint_1_deg, self.joint_2_deg, self.quill_mm, self.joint_4_deg])

    @property
    def stroke_mm(self) -> float:
        """Stroke of the quill in mm."""
        return self.quill_mm[1] - self.quill_mm[0]

    def forward(self, joints: npt.ArrayLike) -> FloatArray:
        """Return where the tool is.

        ``joints`` of shape (..., 2) give (x, y) of the same shape; of shape (..., 4) they give
        (x, y, z, theta).
        """
        q = _last_dimension(joints)
        a = np.radians(q[..., 0])
        b = a + np.radians(q[..., 1])
        x = self.link_1_mm * np.cos(a) + self.link_2_mm * np.cos(b)
        y = self.link_1_mm * np.sin(a) + self.link_2_mm * np.sin(b)
        if q.shape[-1] == 2:
            return np.stack([x, y], axis=-1)
        return np.stack([x, y, q[..., 2], q[..., 0] + q[..., 1] + q[..., 3]], axis=-1)

    def solve(self, poses: npt.ArrayLike, elbow: Elbow) -> FloatArray:
        """Return the joints of ``poses``, whether or not they respect the limits; nan out of reach.

        Shapes as in `forward`. An angle is given in the turn that lies within its limits if one
        does; joint 1 of a tool on the base axis is the one that points link 2 along x.
        """
        p = _last_dimension(poses)
        l_1, l_2 = self.link_1_mm, self.link_2_mm
        r = np.hypot(p[..., 0], p[..., 1])
        # half-angle form: keeps its digits where the arm is nearly straight or folded
        straight = (l_1 + l_2 - r) * (l_1 + l_2 + r)
        folded = (r - abs(l_1 - l_2)) * (r + abs(l_1 - l_2))
        slack = _SLACK * (l_1 + l_2)
        with np.errstate(invalid="ignore"):
            root = [np.sqrt(np.where(s > -slack, np.maximum(s, 0), s)) for s in (straight, folded)]
        q_2 = elbow.sign * 2 * np.arctan2(*root)
        q_1 = np.arctan2(p[..., 1], p[..., 0]) - np.arctan2(
            l_2 * np.sin(q_2), l_1 + l_2 * np.cos(q_2)
        )
        turns = [_into(np.degrees(q), lim) for q, lim in zip((q_1, q_2), self.limits, strict=False)]
        if p.shape[-1] == 2:
            return np.stack(turns, axis=-1)
        q_4 = _into(p[..., 3] - turns[0] - turns[1], self.limits[3])
        return np.stack([*turns, p[..., 2], q_4], axis=-1)

    def excess(self, joints: npt.ArrayLike) -> FloatArray:
        """Return how far each joint lies outside its limits, same shape; 0 within, nan kept."""
        q = _last_dimension(joints)
        low, high = self.limits[: q.shape[-1]].T
        over = np.maximum(np.maximum(low - q, q - high), 0.0)
        return np.where(over > _SLACK, over, np.where(np.isnan(q), np.nan, 0.0))

    def inverse(self, poses: npt.ArrayLike, *, elbow: Elbow) -> FloatArray:
        """Return the joints that bring the tool to ``poses``; shapes as in `forward`.

        Raises `UsageError` where a pose is out of reach or a joint outside its limits, saying by
        how much.
        """
        p = _last_dimension(poses)
        joints = self.solve(p, elbow)
        excess = self.excess(joints)
        bad = np.argwhere(np.any(np.isnan(excess) | (excess > 0), axis=-1))
        if len(bad):
            shown = [self._why(p[tuple(i)], joints[tuple(i)], elbow) for i in bad[:_SHOWN]]
            more = [f"and {len(bad) - _SHOWN} more poses"] if len(bad) > _SHOWN else []
            raise UsageError(
                "; ".join(shown + more),
                remedy="move the pose, take the other elbow, or correct the arm's limits",
            )
        return joints

    def _why(self, pose: FloatArray, joints: FloatArray, elbow: Elbow) -> str:
        place, r = f"x = {pose[0]:g}, y = {pose[1]:g} mm", math.hypot(pose[0], pose[1])
        inner, outer = abs(self.link_1_mm - self.link_2_mm), self.link_1_mm + self.link_2_mm
        if math.isnan(r):
            return f"{place}: not a place"
        if np.isnan(joints[0]):
            beyond = f"{r - outer:.3g} mm beyond the reach of {outer:g} mm"
            inside = f"{inner - r:.3g} mm inside the hole of {inner:g} mm"
            return f"{place} is out of reach: {beyond if r > outer else inside}"
        units = zip(JOINTS, JOINT_UNITS, joints, self.excess(joints), self.limits, strict=False)
        parts = [
            f"{name} would be {q:.6g} {unit}, {by:.3g} {unit} outside {low:g} to {high:g}"
            for name, unit, q, by, (low, high) in units
            if not by <= 0
        ]
        return f"{place}, elbow {elbow.value}: {', '.join(parts)}"

    def jacobian(self, joints: npt.ArrayLike) -> FloatArray:
        """Return the tool's motion for a motion of each joint, as columns.

        Shape (..., 2, 2) for two joints: d(x, y) in mm per radian. Shape (..., 4, 4) for four:
        d(x, y, z, theta), angles in radians and lengths in mm in rows and columns alike.
        """
        q = _last_dimension(joints)
        a = np.radians(q[..., 0])
        b = a + np.radians(q[..., 1])
        second = self.link_2_mm * np.stack([-np.sin(b), np.cos(b)], axis=-1)
        first = second + self.link_1_mm * np.stack([-np.sin(a), np.cos(a)], axis=-1)
        planar = np.stack([first, second], axis=-1)
        if q.shape[-1] == 2:
            return planar
        full = np.zeros((*q.shape, 4))
        full[..., :2, :2] = planar
        full[..., 2, 2] = 1.0
        full[..., 3, [0, 1, 3]] = 1.0
        return full

    def movements(self, joints_deg: npt.ArrayLike) -> FloatArray:
        """Return how X and Y move, (..., 2, 3), for joints 1 and 2 [mm/rad] and growing links [mm].

        Both links growing by the same strain scale the arm: the tool moves along the line from the
        base axis, by the strain times its distance from it.
        """
        place = self.forward(joints_deg)[..., np.newaxis]
        return np.concatenate([self.jacobian(joints_deg), place], axis=-1)

    def singularity_deg(self, joints: npt.ArrayLike) -> FloatArray:
        """Return by how many degrees joint 2 misses the nearest singularity: straight or folded."""
        q_2 = _last_dimension(joints)[..., 1]
        return np.abs(q_2 - 180.0 * np.round(q_2 / 180.0))

    def reach(self) -> tuple[float, float]:
        """Return the inner and outer radius in mm that joint 2 reaches within its limits."""
        low, high = self.joint_2_deg
        turns = 180.0 * np.arange(math.ceil(low / 180.0), math.floor(high / 180.0) + 1)
        radii = np.hypot(*self.forward([(0.0, q) for q in (low, high, *turns)]).T)
        return float(radii.min()), float(radii.max())


def _into(angle: FloatArray, limits: FloatArray) -> FloatArray:
    """Return ``angle`` in the turn centred on the middle of its limits, in degrees."""
    middle = float(limits.mean())
    return angle - 360.0 * np.round((angle - middle) / 360.0)


def _last_dimension(values: npt.ArrayLike) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] not in (2, 4):
        raise UsageError(f"joints and poses have 2 or 4 numbers each, not shape {array.shape}")
    return array
