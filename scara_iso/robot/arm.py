"""SCARA geometry: joints to tool point and back, Jacobian, reach, and the area that is reached.

Joints 1, 2 and 4 turn about vertical axes, joint 3 is the quill. Lengths are in mm, angles in
degrees, both in the base frame: joint 1 is measured from its x axis, joint 2 from link 1, joint 3
is the height z of the tool point, and the tool's orientation is theta = joint 1 + joint 2 +
joint 4. Arrays hold poses along their leading dimensions.

The area, seen from above, is bounded by arcs: about the base where joint 2 is at a limit, straight
or folded, and about the elbow where joint 1 is at a limit. A rectangle lies inside if its centre
does and no arc passes through it, which holds for its every point and not only for its corners. The
largest is found by branch and bound.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise, product

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


_EDGE = 1e-6
"""How far beside an arc its two sides are looked at, as a part of the reach."""


@dataclass(frozen=True, eq=False, slots=True)
class Workspace:
    """The area that an arm reaches with one elbow or either: its arcs, and what is inside.

    ``arcs`` has shape (k, 5): centre x and y and radius in mm, first and last angle in rad.
    """

    arm: Arm
    elbows: tuple[Elbow, ...]
    arcs: FloatArray

    @classmethod
    def of(cls, arm: Arm, elbows: Sequence[Elbow] = tuple(Elbow)) -> Workspace:
        """Return the workspace of ``arm``, bounded by the arcs with its outside on one side.

        Raises `UsageError` where the limits of joint 2 keep the elbow on the other side.
        """
        found = cls(arm, tuple(elbows), np.empty((0, 5)))
        candidates = _candidates(found)
        if not candidates:
            raise UsageError(
                f"joint 2, from {arm.joint_2_deg[0]:g} to {arm.joint_2_deg[1]:g} deg, never has "
                f"its elbow on the {' or '.join(elbow.value for elbow in elbows)}",
                remedy="take the other elbow, or correct the arm's limits",
            )
        pieces = [piece for piece in _split(candidates) if found._bounds(piece)]
        return cls(arm, tuple(elbows), np.array(pieces).reshape(-1, 5))

    def contains(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return which ``points`` (..., 2) in mm are reached within the limits; shape (...)."""
        p = np.asarray(points, dtype=np.float64)
        reached = np.zeros(p.shape[:-1], dtype=bool)
        for elbow in self.elbows:
            reached |= np.all(self.arm.excess(self.arm.solve(p, elbow)) == 0, axis=-1)
        return reached

    def outline(self, *, points: int = 200) -> Iterator[FloatArray]:
        """Yield each bounding arc as a line of shape (points, 2) in mm."""
        for x, y, radius, first, last in self.arcs:
            angle = np.linspace(first, last, points)
            yield np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=-1)

    def clearance(self, centres: FloatArray, aspect: FloatArray) -> FloatArray:
        """Return how large a rectangle fits about each of n centres (n, 2).

        ``aspect`` (n,) is the logarithm of width over depth. The result t (n,) is half the root of
        the area: the half width is t exp(aspect / 2). It is negative outside the workspace.
        """
        stretch = np.exp(aspect / 2)
        scale = np.stack([stretch, 1 / stretch], axis=-1)
        ends = _extreme_points(self.arcs)
        near = np.min(np.max(np.abs(ends - centres[:, None]) / scale[:, None], axis=-1), axis=-1)
        for sign in (1.0, -1.0):
            along = np.stack([scale[:, 0], sign * scale[:, 1]], axis=-1)
            near = np.minimum(near, _along_diagonal(self.arcs, centres, along))
        return np.asarray(np.where(self.contains(centres), near, -near))

    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Return the least and the greatest (x, y) of the workspace in mm."""
        points = _extreme_points(self.arcs)
        return points.min(axis=0), points.max(axis=0)

    def _bounds(self, arc: FloatArray) -> bool:
        x, y, radius, first, last = arc
        middle = (first + last) / 2
        beside = radius + _EDGE * (self.arm.link_1_mm + self.arm.link_2_mm) * np.array([-1, 1])
        sides = np.stack([x + beside * math.cos(middle), y + beside * math.sin(middle)], axis=-1)
        return not bool(np.all(self.contains(sides)))


def _candidates(workspace: Workspace) -> list[FloatArray]:
    """Return every arc on which the workspace may end, shape (5,) each."""
    arm = workspace.arm
    l_1, l_2 = arm.link_1_mm, arm.link_2_mm
    a, b = np.radians(arm.joint_1_deg)
    found = []
    for low, high in _turns_of_joint_2(workspace):
        for q in (low, high):
            tip = l_1 + l_2 * np.exp(1j * q)
            found.append((0.0, 0.0, abs(tip), a + np.angle(tip), b + np.angle(tip)))
        found += [(l_1 * math.cos(q), l_1 * math.sin(q), l_2, q + low, q + high) for q in (a, b)]
    arcs = [np.array(arc) for arc in found if arc[2] > _EDGE * (l_1 + l_2)]
    for arc in arcs:
        arc[4] = min(arc[4], arc[3] + math.tau)
    return arcs


def _turns_of_joint_2(workspace: Workspace) -> list[tuple[float, float]]:
    """Return the intervals of joint 2 in rad, each on one side of straight and folded."""
    low, high = np.radians(workspace.arm.joint_2_deg)
    found = []
    for elbow, turn in product(workspace.elbows, range(-2, 3)):
        first = math.tau * turn - (math.pi if elbow is Elbow.LEFT else 0.0)
        overlap = max(low, first), min(high, first + math.pi)
        found += [overlap] if overlap[0] <= overlap[1] else []
    return found


def _split(arcs: Sequence[FloatArray]) -> Iterator[FloatArray]:
    """Yield the pieces into which the arcs cut each other."""
    ends = _ends(np.array(arcs))
    for arc in arcs:
        x, y, radius, first, last = arc
        cuts = [np.empty(0)] + [_crossings(arc, other) for other in arcs]
        on = np.abs(np.hypot(ends[:, 0] - x, ends[:, 1] - y) - radius) < 1e-6 * radius
        cuts.append(np.arctan2(ends[on, 1] - y, ends[on, 0] - x))
        angles = first + np.mod(np.concatenate(cuts) - first, math.tau)
        angles = np.unique(np.concatenate([[first, last], angles[angles < last]]))
        for start, end in pairwise(angles):
            if end - start > 1e-9:
                yield np.array([x, y, radius, start, end])


def _crossings(arc: FloatArray, other: FloatArray) -> FloatArray:
    """Return the angles on ``arc``'s circle at which the other's circle crosses or touches it."""
    between = complex(other[0] - arc[0], other[1] - arc[1])
    d, r, s = abs(between), arc[2], other[2]
    if d < 1e-9 * r:
        return np.empty(0)
    cosine = (d * d + r * r - s * s) / (2 * d * r)
    if abs(cosine) > 1 + 1e-9:
        return np.empty(0)
    half = math.acos(min(max(cosine, -1.0), 1.0))
    return np.angle(between) + np.array([-half, half])


def _ends(arcs: FloatArray) -> FloatArray:
    """Return the two end points of each arc, shape (2 k, 2)."""
    x, y, radius, first, last = np.concatenate([arcs, arcs]).T
    angle = np.where(np.arange(2 * len(arcs)) < len(arcs), first, last)
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=-1)


def _extreme_points(arcs: FloatArray) -> FloatArray:
    """Return each arc's ends and the points where it is parallel to an axis, shape (m, 2)."""
    x, y, radius, first, last = arcs.T
    quarter = np.arange(4)[:, None] * math.pi / 2
    on = np.mod(quarter - first, math.tau) <= last - first
    points = np.stack([x + radius * np.cos(quarter), y + radius * np.sin(quarter)], axis=-1)
    return np.concatenate([_ends(arcs), points[on]])


def _along_diagonal(arcs: FloatArray, centres: FloatArray, along: FloatArray) -> FloatArray:
    """Return how far each centre (n, 2) is from an arc along ± its own direction (n, 2).

    The unit of the result (n,) is the direction's length; infinite where no arc is met.
    """
    x, y, radius, first, last = arcs.T
    away = centres[:, None] - np.stack([x, y], axis=-1)
    a = np.sum(along**2, axis=-1)[:, None]
    b = np.sum(along[:, None] * away, axis=-1)
    square = b * b - a * (np.sum(away**2, axis=-1) - radius**2)
    root = np.sqrt(np.maximum(square, 0.0))
    nearest = np.full(len(centres), np.inf)
    for s in ((-b - root) / a, (-b + root) / a):
        met = away + s[..., None] * along[:, None]
        angle = np.arctan2(met[..., 1], met[..., 0])
        on = (square >= 0) & (np.mod(angle - first, math.tau) <= last - first)
        nearest = np.minimum(nearest, np.min(np.where(on, np.abs(s), np.inf), axis=-1))
    return nearest


SMALLEST_MM = 1.0
"""A side shorter than this is not a rectangle to test a robot in."""

_WIDEST = 4.0
"""Logarithm of the largest aspect ratio that is tried (55 : 1)."""
_CELLS, _SLICES = 24, 16
"""Cells along x and y, and slices of aspect ratios, with which the search begins."""
_FINEST_MM = 1e-6
"""Half side of a cell at which it ends."""
_CERTAIN_MM = 0.25
"""Half side of a cell down to which the search leaves out no place that may hold the best."""
_PROMISING = 400
"""How many cells are followed below that: of equal places, along which a rectangle can slide, there
may be any number."""
_DIGITS = 9
"""Decimals of mm that count."""
_ALIKE = 1e-6
"""Share of its size by which a rectangle may be smaller than another one and count as equal."""


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle with its edges along x and y, in mm: centre and full sides."""

    x: float
    y: float
    width: float
    depth: float


def largest_rectangle(workspace: Workspace, *, square: bool) -> Rectangle:
    """Return the largest square, or rectangle by area, with edges along x and y inside.

    Branch and bound over centre and aspect ratio: half the root of the area that fits cannot change
    faster than the centre moves, nor than the root of the aspect ratio, so that a cell whose bound
    is below the best found is left out for certain. Of equal ones the foremost (largest x, then y)
    is taken. A square's side comes out to 1e-5 mm, a rectangle's area to one part in a thousand.
    Raises `UsageError` where nothing with the area of `SMALLEST_MM` squared fits.
    """
    reach = max(float(np.abs(workspace.extent()).max()), SMALLEST_MM)
    counts = [_CELLS, _CELLS, 1 if square else _SLICES]
    half = np.array([reach, reach, 0.0 if square else _WIDEST]) / counts
    steps = [np.arange(1 - count, count, 2) for count in counts]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    cells, best = grid * half, SMALLEST_MM / 2
    corners = np.array(list(product((-1, 1), (-1, 1), (0,) if square else (-1, 1))))
    size = np.empty(0)
    while len(cells):
        aspect = cells[:, 2]
        size, stretch = workspace.clearance(cells[:, :2], aspect), np.exp(aspect / 2)
        best = max(best, float(size.max()))
        bound = (size + np.maximum(half[0] / stretch, half[1] * stretch)) * math.exp(half[2] / 2)
        kept = np.flatnonzero(bound >= best)
        most = None if half[:2].max() > _CERTAIN_MM else _PROMISING
        x, y, _ = -cells[kept].T
        kept = kept[np.lexsort((y, x, -bound[kept].round(_DIGITS)))[:most]]
        cells, size = cells[kept], size[kept]
        if half[:2].max() < _FINEST_MM:
            break
        half = half / 2
        cells = (cells[:, np.newaxis] + half * corners).reshape(-1, 3)
    if not len(cells):
        raise UsageError(
            f"the limits leave no area: not even a square of {SMALLEST_MM:g} mm fits the workspace",
            remedy="widen the limits of joint 1 and joint 2",
        )
    equal = np.flatnonzero(size >= size.max() * (1 - _ALIKE)).tolist()
    foremost = max(equal, key=lambda k: tuple(cells[k].round(2)))
    x, y, aspect = (cells[foremost] + 0.0).tolist()
    t = 2 * (float(size[foremost]) - _FINEST_MM)  # keeps the corners inside in spite of rounding
    return Rectangle(x, y, t * math.exp(aspect / 2), t * math.exp(-aspect / 2))
