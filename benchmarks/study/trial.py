"""Tables of known cause, on which the judge is judged.

Each is a test of 30 readings and the 30 that came next, in divisions of the dial. A true statement
that is judged wrong, and a false one judged right, are the judge's own errors. The false one is
the likeliest mistake: FALSE.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from benchmarks.study.courses import Array
from benchmarks.study.judge import NOTHING, judged

N, SIGMAS = 30, (0.4, 1.0, 5.0)
FALSE: Mapping[str, str] = {
    NOTHING: "contact_side", "linear_drift": "periodic", "warm_up": "step", "onset": "linear_drift",
    "step": "linear_drift", "periodic": "step", "transient": "step", "outlier": "contact_side",
    "random_walk": "step", "autocorrelated": "periodic", "contact_side": "step",
    "scatter_change": "outlier",
}  # fmt: skip


Verdicts = Mapping[str, Mapping[str, Counter[str]]]
"""Of each cause, of its own name, a false one and NOTHING: how many right, wrong, undecided."""


def course(cause: str, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return the course (2 N,) of a cause in standard deviations of scatter, and that scatter."""
    j, flat = np.arange(2.0 * N), np.ones(2 * N)
    k, size, sign = int(rng.integers(8, 22)), rng.uniform(4, 7), rng.choice([-1.0, 1.0])
    chain = np.cumsum(rng.random(2 * N) < 0.3) % 2
    drawn = {
        NOTHING: 0 * j,
        "linear_drift": size * j / N,
        "warm_up": size * np.exp(-j / rng.uniform(4, 12)),
        "onset": size * np.maximum(j - k, 0) / (N - k),
        "step": size * (j >= k),
        "periodic": size / 2 * np.sin(2 * np.pi * (j / rng.uniform(4, 12) + rng.random())),
        "transient": size * np.exp(-0.5 * ((j - k) / 2.5) ** 2),
        "outlier": 1.6 * size * (j == k),
        "random_walk": np.cumsum(rng.normal(0, 1.2, 2 * N)),
        "autocorrelated": _remembered(0.8, rng),
        "contact_side": size * chain,
        "scatter_change": 0 * j,
    }
    scatter = {"scatter_change": np.where(j >= k, size, 1.0), "autocorrelated": 0 * j}
    return sign * drawn[cause], scatter.get(cause, flat)


def _remembered(r: float, rng: np.random.Generator) -> Array:
    x = 2 * rng.normal(size=2 * N)
    for k in range(1, 2 * N):
        x[k] = r * x[k - 1] + (1 - r * r) ** 0.5 * x[k]
    return x


def table(cause: str, sigma: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return a test of a cause, scatter ``sigma`` divisions, and the readings that come next."""
    mean, scatter = course(cause, rng)
    readings = np.rint(sigma * (mean + scatter * rng.normal(size=2 * N)) + rng.uniform(-0.5, 0.5))
    return readings[:N], readings[N:]


def of_cause(cause: str, tables: int, seed: int = 1) -> tuple[str, dict[str, Counter[str]]]:
    """Return the cause, and the verdicts on its name ("true"), a false one, and NOTHING."""
    rng = np.random.default_rng([seed, list(FALSE).index(cause)])
    found = {kind: Counter[str]() for kind in ("true", "false", NOTHING)}
    for k in range(tables):
        y, z = table(cause, SIGMAS[k % len(SIGMAS)], rng)
        for kind, name in (("true", cause), ("false", FALSE[cause]), (NOTHING, NOTHING)):
            found[kind][judged(name, y, z).verdict] += 1
    return cause, found
