"""Readings with and without a known structure, for benchmarks/diagnosis.py.

reading_j = round(mu + sigma (size shape_j + noise_j)), in divisions; mu uniform within a division,
noise of unit variance. The shapes are written here anew: they share no formula with the catalogue.
"""

from __future__ import annotations

import numpy as np

N = 30
CYCLE = np.arange(2, N + 2)
SIGMAS = (0.3, 0.5, 0.7, 1.0, None)
MIDDLE = (("step", 2), ("linear", 3), ("warm_up", 4), ("periodic", 1.5), ("alternating", 2),
          ("two_levels", 4), ("sticky", 3), ("outlier", 6))  # fmt: skip
HIGH = (("step", 3), ("linear", 4), ("warm_up", 6), ("periodic", 2), ("alternating", 3),
        ("two_levels", 6), ("sticky", 4), ("outlier", 8))  # fmt: skip
POWER = (("step", 2), ("step", 3), ("linear", 3), ("warm_up", 4), ("periodic", 1.5),
         ("periodic", 2), ("alternating", 2), ("two_levels", 6), ("sticky", 4),
         ("outlier", 8))  # fmt: skip
OUTSIDE = (("vee", 3), ("vee", 4), ("chirp", 2), ("chirp", 3), ("three_steps", 2),
           ("three_steps", 3), ("ar1", 2), ("ar1", 3), ("bump", 3), ("bump", 4))  # fmt: skip
TOGETHER = (("step", "linear"), ("step", "periodic"), ("warm_up", "step"),
            ("warm_up", "alternating"), ("linear", "alternating"), ("linear", "periodic"),
            ("step", "outlier"), ("periodic", "alternating"), ("step", "sticky"),
            ("linear", "outlier"))  # fmt: skip
"""Two at once, each of the size that HIGH has."""
NAME = {
    "step": "step",
    "linear": "linear_drift",
    "warm_up": "warm_up",
    "periodic": "periodic",
    "alternating": "contact_side",
    "two_levels": "contact_side",
    "sticky": "contact_side",
    "outlier": "outlier",
    "approach": "lost_motion",
    "payload": "compliance",
    "temperature": "temperature",
}
OUTSIDE_NAMES = {"bump": "transient", "ar1": "autocorrelated"}
"""Effects that came into the catalogue since; ``unknown`` is right too."""


def noise(rng, kind="normal", n=N):  # noqa: C901, PLR0911 - one line for each
    """Return scatter of unit variance."""
    if kind == "t5":
        return rng.standard_t(5, size=n) / np.sqrt(5 / 3)
    if kind == "t3":
        return rng.standard_t(3, size=n) / np.sqrt(3)
    if kind == "skewed":
        return rng.exponential(size=n) - 1
    if kind == "uniform":
        return rng.uniform(-1, 1, size=n) * np.sqrt(3)
    if kind == "arcsine":
        return np.sqrt(2) * np.sin(rng.uniform(0, 2 * np.pi, size=n))
    if kind == "Laplace":
        return rng.laplace(size=n) / np.sqrt(2)
    if kind == "lognormal":
        return (np.exp(rng.normal(size=n)) - np.exp(0.5)) / np.sqrt((np.e - 1) * np.e)
    if kind == "Cauchy":  # it has no variance: half of the readings within one sigma of Gauss
        return rng.standard_cauchy(size=n) * 0.6745
    if kind == "split":
        z = rng.normal(size=n)
        return (np.where(z > 0, 2 * z, z) - 1 / np.sqrt(2 * np.pi)) / np.sqrt(2.5 - 0.5 / np.pi)
    return rng.normal(size=n)


def shape(rng, kind, n=N):  # noqa: C901, PLR0911, PLR0912 - one line for each structure
    """Return one structure over n cycles."""
    j = np.arange(n)
    match kind:
        case "none":
            return np.zeros(n)
        case "step":
            return 1.0 * (j >= rng.integers(5, 26))
        case "linear":
            return j / (n - 1)
        case "warm_up":
            return np.exp(-j / np.exp(rng.uniform(np.log(2), np.log(10))))
        case "periodic":
            period = np.exp(rng.uniform(np.log(2.6), np.log(15)))
            return np.sin(2 * np.pi * (j / period + rng.random()))
        case "alternating":
            return j % 2 - 0.5
        case "two_levels":
            return 1.0 * (rng.random(n) < rng.uniform(0.3, 0.7))
        case "sticky":
            switch = rng.random(n) < rng.uniform(0.08, 0.25)
            return (np.cumsum(switch) + rng.integers(2)) % 2.0
        case "outlier":
            return 1.0 * (j == rng.integers(n))
        case "vee":
            return np.abs(2 * j / (n - 1) - 1)
        case "chirp":
            return np.sin(2 * np.pi * (j / n + 2.5 * (j / n) ** 2))
        case "three_steps":
            return rng.normal(size=4)[np.searchsorted(np.sort(rng.choice(24, 3, False) + 3), j)]
        case "ar1":
            course = [rng.normal()]
            for _ in range(n - 1):
                course.append(0.8 * course[-1] + 0.6 * rng.normal())
            return np.array(course)
        case "bump":
            return np.exp(-0.5 * ((j - rng.uniform(8, 22)) / rng.uniform(2, 4)) ** 2)
    raise KeyError(kind)


def readings(rng, kind, size, sigma, scatter="normal"):
    """Return one axis of readings in divisions; without rounding where ``sigma`` is None."""
    return dial(rng, course(rng, kind, size) + noise(rng, scatter), sigma)


def course(rng, kind, size):
    """Return one structure of either sign, in scatters."""
    return size * rng.choice([-1, 1]) * shape(rng, kind)


def dial(rng, course, sigma):
    """Return what a dial shows of a course given in sigmas."""
    return course if sigma is None else np.round(rng.uniform(-0.5, 0.5) + sigma * course)


def together(rng, kinds, axes, sigma):
    """Return readings (n, axes) with two structures: on one axis both, on two axes one each."""
    sizes = dict(HIGH)
    moved = [sizes[kind] * rng.choice([-1, 1]) * shape(rng, kind) for kind in kinds]
    courses = moved if axes == len(moved) else [sum(moved)]
    return np.stack([dial(rng, course + noise(rng), sigma) for course in courses], axis=1)


def scatter(rng, axes, rho, kind="normal"):
    """Return scatter of several axes (n, axes) with correlation ``rho``."""
    own = np.stack([noise(rng, kind) for _ in range(axes)], axis=1)
    return np.sqrt(1 - rho) * own + np.sqrt(rho) * noise(rng, kind)[:, np.newaxis]
