"""The largest square or rectangle inside a workspace, by branch and bound."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from scara_iso.errors import UsageError
from scara_iso.robot.workspace import Workspace
from scara_iso.run import FloatArray

SMALLEST_MM = 1.0
"""A side shorter than this is not a rectangle to test a robot in."""

_ASPECT = 4.0
"""Largest logarithm of a rectangle's aspect ratio that is searched (55 : 1)."""
_FINEST_MM = 1e-6
"""Half side of a cell at which the search of a place ends."""
_RIVALS = 4
"""How many separate places are compared finely: a workspace may be symmetric in two ways."""
_CERTAIN_MM = 0.25
"""Half side of a cell down to which the search leaves out no place that may hold the best."""
_PROMISING = 100
"""How many cells are followed where only the most promising are; of equal places, along which a
rectangle can slide, there may be any number."""


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle with its edges along x and y, in mm: centre and full sides."""

    x: float
    y: float
    width: float
    depth: float


def largest_rectangle(workspace: Workspace, *, square: bool) -> Rectangle:
    """Return the largest square, or rectangle by area, with edges along x and y inside.

    Branch and bound over centre and aspect ratio: the size that fits cannot change faster than the
    centre moves, so that a cell whose bound is below the best found is left out for certain. Of
    equal ones the foremost (largest x, then y) is taken. A square's side comes out to 1e-5 mm, a
    rectangle's area to one part in a thousand: its aspect ratio is settled last, about the places
    found. Raises `UsageError` where nothing with the area of `SMALLEST_MM` squared fits.
    """
    low, high = workspace.extent()
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, SMALLEST_MM)
    if square:
        return _foremost(*_search(workspace, (*middle, 0.0), (*half, 0.0), finest=_FINEST_MM))
    coarse = max(float(half.min()) / 150, _CERTAIN_MM)
    cells, size = _search(workspace, (*middle, 0.0), (*half, _ASPECT), finest=coarse)
    near = 20 * coarse
    found: list[Rectangle] = []
    while len(cells) and len(found) < _RIVALS:
        first = cells[np.argmax(size)]
        found.append(_with_best_aspect(workspace, first, near))
        apart = np.max(np.abs(cells - first) / (near, near, 0.1), axis=-1) > 1
        cells, size = cells[apart], size[apart]
    largest = max(r.width * r.depth for r in found)
    equal = [r for r in found if r.width * r.depth > largest * (1 - 1e-7)]
    return max(equal, key=lambda r: (round(r.x, 2), round(r.y, 2)))


def _with_best_aspect(workspace: Workspace, start: FloatArray, near: float) -> Rectangle:
    """Return the largest rectangle about a centre within ``near`` mm of one found coarsely."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 - only a box needs it

    x, y, aspect = start.tolist()

    def fit(other: float, finest: float = 1e-4) -> tuple[FloatArray, FloatArray]:
        return _search(workspace, (x, y, other), (near, near, 0.0), finest=finest)

    found = minimize_scalar(
        lambda other: -float(fit(other)[1].max()),
        bounds=(aspect - 0.1, aspect + 0.1),
        method="bounded",
        options={"xatol": 1e-4},
    )
    return _foremost(*fit(float(found.x), finest=_FINEST_MM))


def _search(
    workspace: Workspace,
    middle: tuple[float, ...],
    half_width: tuple[float, ...],
    *,
    finest: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the cells (n, 3) of centre and aspect that may hold the best, and the size in each.

    Where the aspect is free, a first pass follows only the most promising cells; what it finds lets
    the second, which leaves out nothing that may be better by `_CERTAIN_MM`, stay small. Raises
    `UsageError` where nothing fits.
    """
    counts = [24, 24, 8 if half_width[2] else 1]
    half = np.array(half_width) / counts
    steps = [m + np.arange(1 - n, n, 2) * h for m, n, h in zip(middle, counts, half, strict=True)]
    start, best = np.array(list(product(*steps))), SMALLEST_MM / 2
    for most in (_PROMISING, None) if half_width[2] else (None,):
        cells, size = _narrow(workspace, start, half, finest, best, most)
        best = max(best, float(size.max(initial=0.0)))
    if not len(cells):
        raise UsageError(
            f"the limits leave no area: not even a square of {SMALLEST_MM:g} mm fits the workspace",
            remedy="widen the limits of joint 1 and joint 2",
        )
    return cells, size


def _narrow(
    workspace: Workspace,
    cells: FloatArray,
    half: FloatArray,
    finest: float,
    best: float,
    most: int | None,
) -> tuple[FloatArray, FloatArray]:
    """Divide ``cells`` until they are ``finest``, leaving out those that cannot hold the best."""
    while len(cells):
        size = workspace.clearance(cells[:, :2], cells[:, 2])
        best = max(best, float(size.max()))
        bound = _bound(cells, size, half)
        kept = np.flatnonzero(bound >= best)
        limit = most if half[:2].max() > _CERTAIN_MM else _PROMISING
        kept = kept[np.argsort(-bound[kept], kind="stable")[:limit]]
        if half[:2].max() < finest:
            return cells[kept], size[kept]
        half = half / 2
        moves = np.array(list(product(*([-h, h] if h else [0.0] for h in half))))
        cells = (cells[kept, None] + moves).reshape(-1, 3)
    return cells, np.empty(0)


def _bound(cells: FloatArray, size: FloatArray, half: FloatArray) -> FloatArray:
    """Return the largest size that any place within each cell can have."""
    stretch = np.exp(cells[:, 2] / 2)
    moved = size + np.maximum(half[0] / stretch, half[1] * stretch)
    return np.asarray(moved * math.exp(half[2] / 2))


def _foremost(cells: FloatArray, size: FloatArray) -> Rectangle:
    equal = np.flatnonzero(size >= size.max() - 10 * _FINEST_MM)
    k = equal[np.lexsort((cells[equal, 1], cells[equal, 0]))[-1]]
    x, y, aspect = cells[k].tolist()
    t = 2 * (float(size[k]) - _FINEST_MM)  # keeps the corners inside in spite of rounding
    return Rectangle(x, y, t * math.exp(aspect / 2), t * math.exp(-aspect / 2))
