"""Courses that readings may take, and their likelihood where readings are whole divisions.

Those with a mean are columns, fitted by EM over what lies inside the divisions; hidden ones (walk,
memory, two states) by the forward algorithm over a grid of positions. Scatter is at least LEAST.
A likelihood of a hidden course is given as BIC of the test, and of test and next readings together.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr, stdtr

Array = npt.NDArray[np.float64]
LEAST = 0.1
"""Scatter is not below so many divisions."""
NEXT = 30
"""Readings that came next: a test of the standard. Frequencies are so near to each other that one
of them keeps its phase to the last of them."""
TINY = 1e-290


def means(n: int, m: int) -> Iterator[tuple[str, Array, int]]:
    """Yield label, column (n + m,) and how many numbers it takes, of every course with a mean."""
    j = np.arange(n + m, dtype=float)
    yield "line", j / n, 1
    yield "alternation", j % 2, 1
    yield from (("curve", (j / n - 0.5) ** p, 1) for p in (2, 3))
    yield from (("slow", np.exp(-j / tau), 2) for tau in np.geomspace(n, 3 * n, 4))
    yield from (("exponential", np.exp(-j / tau), 2) for tau in np.geomspace(1.5, 0.9 * n, 14))
    for k in range(3, n - 2):
        yield "step", 1.0 * (j >= k), 2
        yield "onset", np.maximum(j - k, 0.0), 2
    yield from (("outlier", 1.0 * (j == k), 2) for k in range(n))
    for frequency in np.arange(1 / (0.7 * n), 0.45, 0.25 / (n + NEXT)):
        for phase in np.arange(6) * np.pi / 6:
            yield "sine", np.sin(2 * np.pi * frequency * j + phase), 3
    yield from (("bump", column, 3) for column in _bumps(j, n))


def _bumps(j: Array, n: int) -> Iterator[Array]:
    for centre in range(2, n - 2, 2):
        yield from (
            np.exp(-0.5 * ((j - centre) / width) ** 2) for width in (1.0, 2, n / 12, n / 8, n / 5)
        )
    yield from (1.0 * ((j >= a) & (j < n)) for a in range(3, n - 2))
    step = max(2, n // 15)
    for a in range(2, n - 3, step):
        yield from (1.0 * ((j >= a) & (j < b)) for b in range(a + 2, n - 1, step))


def rounded_likelihood(y: Array, X: Array) -> Array:
    """Return the greatest log likelihood (d,) of rounded Gaussian readings about designs (d, n, k).

    A column of zeros in a design takes no part.
    """
    pinv = np.linalg.pinv(X)
    mean = (X @ (pinv @ y)[..., None])[..., 0]
    s = np.maximum(np.sqrt(((y - mean) ** 2).mean(axis=1)), LEAST)[:, None]
    for _ in range(60):
        a, b = (y - 0.5 - mean) / s, (y + 0.5 - mean) / s
        p = np.maximum(_between(a, b), TINY)
        fa, fb = _density(a), _density(b)
        inside = np.clip(mean + s * (fa - fb) / p, y - 0.5, y + 0.5)
        variance = np.clip(s**2 * (1 + (a * fa - b * fb) / p - ((fa - fb) / p) ** 2), 0, 0.25)
        mean = (X @ (pinv @ inside[..., None]))[..., 0]
        s = np.maximum(np.sqrt(((inside - mean) ** 2 + variance).mean(axis=1)), LEAST)[:, None]
    p = _between((y - 0.5 - mean) / s, (y + 0.5 - mean) / s)
    return np.log(np.maximum(p, TINY)).sum(axis=1)


def _between(a: Array, b: Array) -> Array:
    return ndtr(np.where(a > 0, -a, b)) - ndtr(np.where(a > 0, -b, a))


def _density(x: Array) -> Array:
    return np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi)


Bics = dict[str, tuple[float, float]]


def hidden(y: Array, z: Array) -> Bics:
    """Return the BIC of every course without columns, of y and of both."""
    smooth = free(y)
    found = constants(y, z) | {"free": (smooth, np.inf), "scatter": scatter(y, z)}
    return found | {
        "walk": walk(y, z), "memory": memory(y, z), "taken back": taken_back(y, z),
        "two states": two_states(y, z),
    }  # fmt: skip


def constants(y: Array, z: Array) -> Bics:
    """Return the BIC of a constant with Gaussian scatter, and with that of Student's t of 3."""
    both, found = np.concatenate([y, z]), []
    for part in (y, both):
        spread, n = max(float(part.std()), 0.3), len(part)
        gauss = rounded_likelihood(part, np.ones((1, n, 1)))[0]
        middle = np.median(part) + spread * np.linspace(-0.5, 0.5, 11)[:, None, None]
        scale = spread * np.geomspace(0.08, 1.2, 12)[:, None]
        lower, upper = (part - 0.5 - middle) / scale, (part + 0.5 - middle) / scale
        p = (stdtr(3, np.where(lower > 0, -lower, upper))
             - stdtr(3, np.where(lower > 0, -upper, lower)))  # fmt: skip
        heavy = np.log(np.maximum(p, TINY)).sum(axis=-1).max()
        found.append((_bic(gauss, 2, n), _bic(heavy, 2, n)))
    (a, c), (b, d) = found
    return {"constant": (a, b), "heavy tails": (c, d)}


def _bic(likelihood: float, numbers: int, n: int) -> float:
    return float(-2 * likelihood + numbers * np.log(n))


def free(y: Array) -> float:
    """Return the least BIC of a smooth course of no form: cosines of the first 3 to 7 orders."""
    n = len(y)
    order = np.arange(8)
    cosines = np.cos(np.pi * np.outer(np.arange(n) + 0.5, order) / n)
    X = np.stack([np.where(order <= k, cosines, 0.0) for k in range(3, 8)])
    return float((-2 * rounded_likelihood(y, X) + (np.arange(3, 8) + 2) * np.log(n)).min())


def scatter(y: Array, z: Array) -> tuple[float, float]:
    """Return the BIC of a constant whose scatter changes once within y."""
    n, both = len(y), np.concatenate([y, z])
    spread = max(float(y.std()), 0.3)
    sizes = np.unique(np.maximum(spread * np.geomspace(0.08, 3, 16), LEAST))
    best = np.full(2, -np.inf)
    for mean in np.median(y) + spread * np.linspace(-0.5, 0.5, 11):
        log_p = np.cumsum([np.log(_emission(both, np.array([mean]), s)[:, 0]) for s in sizes], 1)
        before = log_p[:, 4 : n - 5].max(axis=0)
        for which, end in enumerate((n, len(both))):
            after = (log_p[:, end - 1 : end] - log_p[:, 4 : n - 5]).max(axis=0)
            best[which] = max(best[which], float((before + after).max()))
    return _bic(best[0], 4, n), _bic(best[1], 4, len(both))


def _positions(y: Array, z: Array) -> tuple[Array, float, Array]:
    """Return the points of the grid, their distance, and the share of each that y starts with."""
    beyond = 2 + float(np.diff(y).std())
    both = np.concatenate([y, z])
    width = max(0.125, (float(np.ptp(both)) + 2 * beyond) / 160)
    x = np.arange(both.min() - beyond, both.max() + beyond + width, width)
    start = 1.0 * ((x >= y.min() - beyond) & (x <= y.max() + beyond))
    return x, width, start / start.sum()


def _emission(y: Array, x: Array, s: float) -> Array:
    """Return the probability (n, points) of each reading at each position."""
    a = np.subtract.outer(y, x) / s
    return np.maximum(_between(a - 0.5 / s, a + 0.5 / s), TINY)


def _forward(start: Array, kernel: Array, p: Array, n: int) -> Array:
    """Return the log likelihood of the first n readings and of all, by a chain over the grid.

    ``kernel`` (points, points) moves the state from row to column, p (readings, points) emits.
    """
    ahead, total, first = start * p[0], 0.0, 0.0
    for k in range(1, len(p) + 1):
        whole = max(float(ahead.sum()), TINY)
        total += np.log(whole)
        if k == n:
            first = total
        if k < len(p):
            ahead = (ahead / whole @ kernel) * p[k]
    return np.array([first, total])


def _both_bics(best: Array, numbers: int, y: Array, z: Array) -> tuple[float, float]:
    return _bic(best[0], numbers, len(y)), _bic(best[1], numbers, len(y) + len(z))


def _moves(x: Array, at: Array, step: float) -> Array:
    """Return the probability of each point (points, points) after a step from ``at``.

    What steps over an end of the grid is lost: a walk is not kept by what the readings reach.
    """
    kernel = np.exp(-0.5 * ((x - at[:, np.newaxis]) / step) ** 2)
    inside = ndtr((x[-1] - at) / step) - ndtr((x[0] - at) / step)
    return kernel * (inside / np.maximum(kernel.sum(axis=1), TINY))[:, np.newaxis]


def walk(y: Array, z: Array) -> tuple[float, float]:
    """Return the BIC of readings, each with scatter, about a Gaussian random walk."""
    x, width, start = _positions(y, z)
    both, moved = np.concatenate([y, z]), max(float(np.diff(y).std()), 0.3)
    steps = np.unique(np.maximum(moved * np.geomspace(0.04, 1.3, 7), 0.4 * width))
    kernels = [_moves(x, x, step) for step in steps]
    best = np.full(2, -np.inf)
    for s in np.unique(np.maximum(moved * np.array([0.1, 0.3, 0.5, 0.7, 1.0]), LEAST)):
        p = _emission(both, x, s)
        for kernel in kernels:
            best = np.maximum(best, _forward(start, kernel, p, len(y)))
    return _both_bics(best, 2, y, z)


def memory(y: Array, z: Array) -> tuple[float, float]:
    """Return the BIC of scatter that remembers: rounded AR(1) about a constant."""
    x, width, _ = _positions(y, z)
    both, spread = np.concatenate([y, z]), max(float(y.std()), 0.3)
    p, best = _emission(both, x, max(LEAST, 0.4 * width)), np.full(2, -np.inf)
    for mean in y.mean() + spread * np.array([-0.5, 0.0, 0.5]):
        for size in np.maximum(spread * np.array([0.6, 0.9, 1.5]), width):
            start = np.exp(-0.5 * ((x - mean) / size) ** 2)
            for r in (0.25, 0.45, 0.65, 0.85):
                step = max(size * np.sqrt(1 - r**2), 0.4 * width)
                kernel = _moves(x, mean + r * (x - mean), step)
                best = np.maximum(best, _forward(start / start.sum(), kernel, p, len(y)))
    return _both_bics(best, 3, y, z)


def taken_back(y: Array, z: Array) -> tuple[float, float]:
    """Return the BIC of readings of which each deviation is taken back in the next one.

    A share g of it moves the correction from a to a' = a - g (reading - mean).
    """
    both = np.concatenate([y, z]) - y.mean()
    spread, best = max(float(y.std()), 0.3), np.full(2, -np.inf)
    for g in (0.4, 0.8, 1.2, 1.7):
        for s in np.maximum(spread * (1 - g / 2) ** 0.5 * np.array([0.75, 0.95, 1.2]), 0.2):
            own = s * (g / (2 - g)) ** 0.5
            best = np.maximum(best, _correction(both, len(y), g, s, own))
    return _both_bics(best, 3, y, z)


def _correction(both: Array, n: int, g: float, s: float, own: float) -> Array:
    """Return the log likelihoods of a correction of size ``own`` that moves by g a reading."""
    a = own * np.linspace(-4, 4, 41)
    moved = np.subtract.outer(a, a) / g
    kernel = np.exp(-0.5 * ((moved - a[:, None]) / s) ** 2)
    kernel /= kernel.sum(axis=1, keepdims=True)
    blur = max(LEAST, 0.3 * (a[1] - a[0]) / g)
    ahead, total, first = np.exp(-0.5 * (a / own) ** 2), 0.0, 0.0
    ahead /= ahead.sum()
    for k, v in enumerate(both, 1):
        low, high = (v - 0.5 - moved) / blur, (v + 0.5 - moved) / blur
        ahead = ahead @ (kernel * np.maximum(_between(low, high), TINY))
        whole = max(float(ahead.sum()), TINY)
        total, ahead = total + np.log(whole), ahead / whole
        first = total if k == n else first
    return np.array([first, total])


def two_states(y: Array, z: Array) -> tuple[float, float]:
    """Return the BIC of two levels between which a symmetric chain switches."""
    both = np.concatenate([y, z])
    grid = np.linspace(y.min(), y.max(), min(20, 2 * len(np.unique(y)) + 1))
    low, high = (v.ravel() for v in np.meshgrid(grid, grid))
    low, high = low[high > low], high[high > low]
    best = np.full(2, -np.inf)
    if not len(low):
        return np.inf, np.inf
    for s in np.maximum(y.std() * np.array([0.1, 0.2, 0.35, 0.5, 0.7]), 0.2):
        p = np.stack([_emission(both, m, s) for m in (low, high)], axis=-1)
        for q in (0.05, 0.15, 0.35, 0.5, 0.75, 0.95):
            state, total, first = np.full((len(low), 2), 0.5), 0.0, 0.0
            for k, emitted in enumerate(p, 1):
                state = ((1 - q) * state + q * state[:, ::-1]) * emitted
                whole = np.maximum(state.sum(axis=1, keepdims=True), TINY)
                total, state = total + np.log(whole[:, 0]), state / whole
                first = total if k == len(y) else first
            best = np.maximum(best, [np.max(first), np.max(total)])
    return _both_bics(best, 4, y, z)
