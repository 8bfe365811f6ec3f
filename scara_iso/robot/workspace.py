"""The area that a SCARA reaches, seen from above, and how large a rectangle fits at a place.

The area is bounded by arcs: about the base where joint 2 is at a limit, straight or folded, and
about the elbow where joint 1 is at a limit. A rectangle lies inside if its centre does and no arc
passes through it, which holds for its every point and not only for its corners.

The largest square or rectangle inside a workspace, by branch and bound.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import UsageError
from scara_iso.robot.arm import Arm, Elbow
from scara_iso.run import FloatArray

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
