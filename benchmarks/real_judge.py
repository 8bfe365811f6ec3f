"""An independent judgement of a name: rounded readings, maximum likelihood, BIC.

No code of the program has a part in it. Every course is one of readings in whole divisions: those
with a mean by EM over what lies inside the divisions, hidden ones (walk, memory, two states) by the
forward or backward algorithm over a grid of positions. Scatter is not below LEAST divisions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import ndtr

WITHIN = 4.0
LEAST = 0.1
CLOSEST = 24
"""So many designs, the closest by least squares, are looked at as rounded."""


@dataclass(frozen=True)
class Test:
    """One window of a series in divisions, with up to as many readings before and after it."""

    series: str
    start: int
    y: np.ndarray
    before: np.ndarray
    after: np.ndarray


# courses with a mean


def best_bic(y: np.ndarray, designs: Sequence[np.ndarray], positions: int) -> float:
    """Return the least BIC of rounded readings (n,) about any of the designs (n, k).

    ``positions`` counts the parameters that tell the designs apart.
    """
    X = np.stack([np.column_stack([np.ones(len(y)), design]) for design in designs])
    X = X[np.argsort(_left(y, X), kind="stable")[:CLOSEST]]
    pinv = np.linalg.pinv(X)
    seen = np.broadcast_to(y, (len(X), len(y)))
    mean = np.einsum("dnk,dkm,dm->dn", X, pinv, seen, optimize=True)
    s = np.maximum(np.sqrt(((y - mean) ** 2).mean(axis=1)), LEAST)[:, None]
    for _ in range(150):
        a, b = (y - 0.5 - mean) / s, (y + 0.5 - mean) / s
        p = np.maximum(_between(a, b), 1e-290)
        fa, fb = _density(a), _density(b)
        inside = np.clip(mean + s * (fa - fb) / p, y - 0.5, y + 0.5)
        variance = np.clip(s**2 * (1 + (a * fa - b * fb) / p - ((fa - fb) / p) ** 2), 0, 0.25)
        mean = (X @ (pinv @ inside[..., None]))[..., 0]
        s = np.sqrt(((inside - mean) ** 2 + variance).mean(axis=1))[:, None]
        s = np.maximum(s, LEAST)
    p = np.maximum(_between((y - 0.5 - mean) / s, (y + 0.5 - mean) / s), 1e-290)
    likelihood = np.log(p).sum(axis=1).max()
    return float(-2 * likelihood + (X.shape[2] + 1 + positions) * np.log(len(y)))


def _left(y: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Return the squares that designs (d, n, k) leave of readings by least squares."""
    q, _ = np.linalg.qr(X)
    return y @ y - ((np.swapaxes(q, 1, 2) @ y) ** 2).sum(axis=1)


def _between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.where(a > 0, ndtr(-a) - ndtr(-b), ndtr(b) - ndtr(a))


def _density(x: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi)


def courses(n: int) -> dict[str, tuple[list[np.ndarray], int]]:
    """Return the designs (n, k) of every course of one cause, and how many numbers place them."""
    j = np.arange(n)
    t = (j / n)[:, None]
    periods = 1 / np.arange(1 / (0.7 * n), 0.45, 0.25 / n)
    widths = (1.0, 2, n / 12, n / 8, n / 5)
    waves = [np.column_stack([f(2 * np.pi * j / p) for f in (np.sin, np.cos)]) for p in periods]
    return {
        "line": ([t], 0),
        "step": ([1.0 * (j >= k)[:, None] for k in range(3, n - 2)], 1),
        "exponential": ([np.exp(-j / tau)[:, None] for tau in _taus(n)], 1),
        "onset": ([1.0 * np.maximum(j - k, 0)[:, None] for k in range(3, n - 3)], 1),
        "sine": (waves, 1),
        "bump": ([np.exp(-0.5 * ((j - c) / w) ** 2)[:, None]
                  for c in range(2, n - 2, 2) for w in widths], 2),
        "outlier": ([1.0 * (j == k)[:, None] for k in range(n)], 1),
    }  # fmt: skip


def _taus(n: int) -> np.ndarray:
    """Return time constants in cycles, up to three runs: a longer one is a line."""
    return np.geomspace(1.5, 3 * n, 20)


def joined(y: np.ndarray, one: Sequence[np.ndarray], other: Sequence[np.ndarray]) -> list:
    """Return the designs of one course beside another's that leave least by least squares."""
    best: list[tuple[float, np.ndarray]] = []
    others = np.stack(other)
    for design in one:
        q, _ = np.linalg.qr(np.column_stack([np.ones(len(y)), design]))
        free = others - q @ (q.T @ others)
        size = np.linalg.norm(free, axis=1).min(axis=1)
        turned, _ = np.linalg.qr(free)
        left = y - q @ (q.T @ y)
        gain = np.where(size > 1e-6, ((np.swapaxes(turned, 1, 2) @ left) ** 2).sum(axis=1), -1.0)
        best += [
            (float(left @ left - gain[i]), np.column_stack([design, other[i]]))
            for i in np.argsort(-gain)[:3]
        ]
    best.sort(key=lambda item: item[0])
    return [design for _, design in best[:CLOSEST]]


def pair_bic(y: np.ndarray, one: str, other: str) -> float:
    """Return the least BIC of two courses at once."""
    every = courses(len(y))
    (first, a), (second, b) = every[one], every[other]
    return best_bic(y, joined(y, first, second), a + b)


# hidden courses


def walk_bic(y: np.ndarray) -> float:
    """Return the least BIC of readings, each with scatter, about a Gaussian random walk.

    Start, scatter and the size of a step are the numbers. A walk over the points of a grid is one
    too: no step is taken for likelier than such a walk can make it.
    """
    x, width = _positions(y)
    moved = max(float(np.diff(y).std()), 0.3)
    best = -np.inf
    for s in np.unique(np.maximum(moved * np.array([0.1, 0.2, 0.35, 0.5, 0.7, 1.0]), LEAST)):
        p = _emission(y, x, s)
        for step in np.unique(np.maximum(moved * np.geomspace(0.03, 1.5, 9), 0.4 * width)):
            total, ahead = _backward(p, _moves(x, x, step))
            best = max(best, total + float(np.log((p[0] * ahead).max())))
    return float(-2 * best + 3 * np.log(len(y)))


def memory_bic(y: np.ndarray) -> float:
    """Return the least BIC of scatter that remembers: rounded AR(1) about a constant."""
    x, width = _positions(y)
    spread, best = max(float(y.std()), 0.3), -np.inf
    p = _emission(y, x, LEAST)
    for mean in y.mean() + (spread * np.linspace(-0.6, 0.6, 5) if len(x) < 200 else np.zeros(1)):
        for size in np.maximum(spread * np.array([0.5, 0.7, 0.85, 1.0, 1.2, 1.5]), width):
            start = np.exp(-0.5 * ((x - mean) / size) ** 2)
            for r in (0.15, 0.3, 0.45, 0.6, 0.75):
                at = mean + r * (x - mean)
                step = max(size * np.sqrt(1 - r**2), 0.4 * width)
                total, ahead = _backward(p, _moves(x, at, step))
                best = max(best, total + float(np.log(start / start.sum() @ (p[0] * ahead))))
    return float(-2 * best + 3 * np.log(len(y)))


def taken_back_bic(y: np.ndarray) -> float:
    """Return the least BIC of readings of which each deviation is taken back in the next one.

    A share g of it moves the correction from a to a' = a - g (reading - mean); corrections lie on a
    grid. Scatter, share and mean are the numbers.
    """
    spread, best = max(float(y.std()), 0.3), -np.inf
    for g in (0.4, 0.7, 1.0, 1.4, 1.7):
        for s in np.maximum(spread * (1 - g / 2) ** 0.5 * np.array([0.7, 0.85, 1.0, 1.2]), 0.2):
            own = s * (g / (2 - g)) ** 0.5
            a = own * np.linspace(-4, 4, 121)
            moved = np.subtract.outer(a, a) / g
            kernel = np.exp(-0.5 * ((moved - a[:, None]) / s) ** 2)
            kernel /= kernel.sum(axis=1, keepdims=True)
            blur = max(LEAST, 0.3 * (a[1] - a[0]) / g)
            seen = {v: kernel * _emission(y[:1] * 0 + v, moved.ravel(), blur).reshape(moved.shape)
                    for v in np.unique(y - y.mean())}  # fmt: skip
            start = np.exp(-0.5 * (a / own) ** 2)
            ahead, total = start / start.sum(), 0.0
            for v in y - y.mean():
                ahead = ahead @ seen[v]
                whole = ahead.sum()
                total, ahead = total + float(np.log(whole)), ahead / whole
            best = max(best, total)
    return float(-2 * best + 3 * np.log(len(y)))


def _positions(y: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the points of the grid and their distance, in divisions."""
    beyond = 2 + float(np.diff(y).std())
    width = max(0.125, (float(np.ptp(y)) + 2 * beyond) / 800)
    return np.arange(y.min() - beyond, y.max() + beyond + width, width), width


def _moves(x: np.ndarray, at: np.ndarray, step: float) -> np.ndarray:
    """Return the probability of each point (points, points) after a step from ``at``.

    What steps over an end of the grid is lost: a walk is not held by what the readings reach.
    """
    kernel = np.exp(-0.5 * ((x - at[:, np.newaxis]) / step) ** 2)
    inside = ndtr((x[-1] - at) / step) - ndtr((x[0] - at) / step)
    return kernel * (inside / kernel.sum(axis=1))[:, np.newaxis]


def _emission(y: np.ndarray, x: np.ndarray, s: float) -> np.ndarray:
    """Return the probability (n, points) of each reading at each position."""
    a = np.subtract.outer(y, x) / s
    return np.maximum(_between(a - 0.5 / s, a + 0.5 / s), 1e-290)


def _backward(p: np.ndarray, kernel: np.ndarray) -> tuple[float, np.ndarray]:
    """Return log factor and likelihood of all later readings from each position at the first."""
    ahead, total = np.ones(len(kernel)), 0.0
    for emitted in p[:0:-1]:
        ahead = kernel @ (emitted * ahead)
        largest = ahead.max()
        total += float(np.log(largest))
        ahead /= largest
    return total, ahead


def two_state_bic(y: np.ndarray) -> float:
    """Return the least BIC of two levels between which a symmetric chain switches."""
    levels, best = np.unique(y), -np.inf
    grid = np.linspace(levels[0], levels[-1], min(24, 2 * len(levels) + 1))
    low, high = (v.ravel() for v in np.meshgrid(grid, grid))
    low, high = low[high > low], high[high > low]
    for s in np.maximum(y.std() * np.array([0.1, 0.2, 0.35, 0.5, 0.7, 1.0]), 0.2):
        p = [_emission(y, m, s) for m in (low, high)]
        for q in (0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 0.95):
            a, b, total = 0.5 * np.ones_like(low), 0.5 * np.ones_like(low), 0.0
            for pa, pb in zip(*p, strict=True):
                a, b = ((1 - q) * a + q * b) * pa, ((1 - q) * b + q * a) * pb
                whole = a + b + 1e-290
                total, a, b = total + np.log(whole), a / whole, b / whole
            best = max(best, float(total.max()))
    return -2 * best + 4 * np.log(len(y))


def scatter_bic(y: np.ndarray) -> float:
    """Return the least BIC of a constant whose scatter changes once."""
    n, spread = len(y), max(float(y.std()), 0.3)
    sizes = np.unique(np.maximum(spread * np.geomspace(0.08, 3, 16), LEAST))
    best = -np.inf
    for mean in y.mean() + spread * np.linspace(-0.6, 0.6, 13):
        log_p = np.cumsum([np.log(_emission(y, np.array([mean]), s)[:, 0]) for s in sizes], axis=1)
        before = log_p[:, 4 : n - 5].max(axis=0)
        after = (log_p[:, -1:] - log_p[:, 4 : n - 5]).max(axis=0)
        best = max(best, float((before + after).max()))
    return -2 * best + 4 * np.log(n)


# judgement


def bics(y: np.ndarray) -> dict[str, float]:
    """Return the BIC of every course in readings (n,) in divisions."""
    n = len(y)
    j = np.arange(n)
    t = j / n
    single = courses(n)
    step = [design[:, 0] for design in single["step"][0]]
    apart = [np.column_stack([a, b]) for a, b in combinations(step[::2], 2)]
    between = [
        1.0 * ((j >= a) & (j < b)) for a in range(2, n - 3, 2) for b in range(a + 2, n - 1, 2)
    ]
    found = {name: best_bic(y, designs, k) for name, (designs, k) in single.items()}
    found["bump"] = min(found["bump"], best_bic(y, between, 2))
    return found | {
        "constant": best_bic(y, [np.empty((n, 0))], 0),
        "quadratic": best_bic(y, [np.column_stack([t, t**2])], 0),
        "cubic": best_bic(y, [np.column_stack([t, t**2, t**3])], 0),
        "two steps": best_bic(y, apart, 2),
        "step and line": best_bic(y, [np.column_stack([a, t]) for a in step], 1),
        "alternation": best_bic(y, [1.0 * (j % 2)], 0),
        "walk": walk_bic(y),
        "memory": memory_bic(y),
        "taken back": taken_back_bic(y),
        "two states": two_state_bic(y),
        "scatter": scatter_bic(y),
    }


MEANS = {
    "step": ("step", {"two steps", "step and line", "two states"}),
    "linear_drift": ("line", {"quadratic", "cubic", "exponential", "onset", "step and line"}),
    "warm_up": ("exponential", {"cubic"}),
    "onset": ("onset", {"cubic", "step and line"}),
    "periodic": ("sine", set()),
    "transient": ("bump", {"two states"}),
    "random_walk": ("walk", set()),
    "autocorrelated": ("memory", {"walk"}),
    "overcorrection": ("taken back", set()),
    "contact_side": ("two states", {"two steps"}),
    "outlier": ("outlier", set()),
    "scatter_change": ("scatter", set()),
}
"""The judge's course of each effect, and those that contain it and so come near it anyway."""

_TOGETHER = ("line", "step", "exponential", "onset", "sine", "bump")


def rivals_of(effects: Sequence[str], y: np.ndarray) -> dict[str, float]:
    """Return by how much the BIC of other courses exceeds the statement's, where that is little.

    The statement is the first of ``effects`` alone or, if that is nearer, beside the second; where
    there are two, so are the others: any two courses without the first are rivals as well.
    """
    own, containing = MEANS[effects[0]]
    found = bics(y)
    mine = found.pop(own)
    if effects[0] == "contact_side":
        mine = min(mine, found.pop("alternation"))
    parts = [MEANS[name][0] for name in effects[:2] if name in MEANS]
    every = courses(len(y))
    if len(parts) == 2 and all(part in every for part in parts):
        mine = min(mine, pair_bic(y, *parts))
        others = [name for name in _TOGETHER if name != own and name not in containing]
        found |= {f"{a} and {b}": pair_bic(y, a, b) for a, b in combinations(others, 2)}
    near = {name: v - mine for name, v in found.items() if name not in containing}
    return {name: d for name, d in near.items() if d <= WITHIN}


def in_context(effect: str, test: Test) -> bool:
    """Return whether a step stands out of the smooth trend of its neighbourhood."""
    if effect != "step" or not len(test.before) or not len(test.after):
        return True
    y = np.concatenate([test.before, test.y, test.after])
    t = np.linspace(-1, 1, len(y))
    smooth = [np.column_stack([t**p for p in range(1, degree + 1)]) for degree in range(1, 7)]
    first = len(test.before)
    step = [1.0 * (np.arange(len(y)) >= first + k) for k in range(3, len(test.y) - 2)]
    trends = [best_bic(y, [s], 0) for s in smooth]
    jumps = [best_bic(y, step, 1)]
    jumps += [best_bic(y, [np.column_stack([s, e]) for e in step], 1) for s in smooth[:4]]
    return min(jumps) < min(trends)


SMOOTH = {"linear_drift", "warm_up", "onset"}
JUMPS = {"two steps", "step and line"}
CURVES = {"quadratic": 2, "cubic": 3}


def not_refuted(effect: str, near: dict[str, float], test: Test) -> dict[str, float]:
    """Return those courses that are ``near`` and that the window's neighbours do not refute."""
    if effect not in SMOOTH or not near:
        return near
    jumps = near.keys() & JUMPS and len(test.before) and len(test.after) and not jumping(test)
    curves = {n for n in near.keys() & CURVES.keys() if len(test.after) and worse(effect, n, test)}
    return {n: d for n, d in near.items() if n not in curves and not (jumps and n in JUMPS)}


def jumping(test: Test) -> bool:
    """Return whether a smooth trend of the three windows wants two jumps in the middle one."""
    y = np.concatenate([test.before, test.y, test.after])
    t, first, n = np.linspace(-1, 1, len(y)), len(test.before), len(test.y)
    smooth = [np.column_stack([t**p for p in range(1, degree + 1)]) for degree in range(1, 7)]
    at = [1.0 * (np.arange(len(y)) >= first + k) for k in range(2, n - 1)]
    two = [np.column_stack([a, b]) for a, b in combinations(at[::2], 2)]
    beside = [best_bic(y, [np.column_stack([s, jump]) for jump in two], 2) for s in smooth[:3]]
    return min(best_bic(y, two, 2), *beside) < min(best_bic(y, [s], 0) for s in smooth)


def worse(effect: str, curve: str, test: Test) -> bool:
    """Return whether a curve foretells the next window worse than the named course does."""
    n, j = len(test.y), np.arange(len(test.y) + len(test.after))
    named = {
        "linear_drift": [j / n],
        "warm_up": [np.exp(-j / tau) for tau in _taus(n)],
        "onset": [np.maximum(j - k, 0) for k in range(3, n - 3)],
    }[effect]
    power = np.column_stack([(j / n) ** p for p in range(1, CURVES[curve] + 1)])
    return foretold(named, test) < foretold([power], test)


def foretold(designs: Sequence[np.ndarray], test: Test) -> float:
    """Return the squared error on the next window of the design that fits this one best."""
    n, found = len(test.y), []
    for design in designs:
        A = np.column_stack([np.ones(len(design)), design])
        at = A @ np.linalg.lstsq(A[:n], test.y, rcond=None)[0]
        found.append((((at[:n] - test.y) ** 2).sum(), ((at[n:] - test.after) ** 2).sum()))
    return min(found)[1]
