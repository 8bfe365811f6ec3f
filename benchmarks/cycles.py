"""What a number of cycles is worth: the tables of docs/why-31-cycles.md.

Gaussian scatter of one unit, no rounding, 200,000 tests a row; ``python
benchmarks/cycles.py --write`` puts them there.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import page

PAGE = Path(__file__).parent.parent / "docs" / "why-31-cycles.md"
TESTS = 200_000
COUNTS = (5, 10, 20, 30, 50, 100, 200)
OFFSETS = (0, 3, 5, 10)
Array = npt.NDArray[np.float64]


def figures(n: int, directions: int, rng: np.random.Generator, *, first: float = 0.0) -> Array:
    """Return RP of each of TESTS tests of n cycles; the first cycle is ``first`` off, along X."""
    found = []
    for _ in range(20):
        places = rng.standard_normal((TESTS // 20, n, directions))
        places[:, 0, 0] += first
        distance = np.linalg.norm(places - places.mean(axis=1, keepdims=True), axis=2)
        found.append(distance.mean(axis=1) + 3 * distance.std(axis=1, ddof=1))
    return np.concatenate(found)


def spread() -> Iterator[str]:
    """Yield where RP of n cycles lies, as a share of RP of endlessly many, per number of axes."""
    yield "| cycles that count | one axis | plane | space |"
    yield "|---|---|---|---|"
    for n in COUNTS:
        rng = np.random.default_rng(9283)
        yield f"| {n} | " + " | ".join(_range(n, d, rng) for d in (1, 2, 3)) + " |"


def _range(n: int, directions: int, rng: np.random.Generator) -> str:
    found = figures(n, directions, rng)
    low, high = np.quantile(found, [0.025, 0.975]) / found.mean() - 1
    return f"{low * 100:+.0f} .. {high * 100:+.0f} %"


def pairs() -> Iterator[str]:
    """Yield how far two tests of one unchanged robot lie apart."""
    yield "| cycles of each test | exceeded one time in two | one time in twenty |"
    yield "|---|---|---|"
    for n in COUNTS:
        rng = np.random.default_rng(9283)
        one, other = figures(n, 2, rng), figures(n, 2, rng)
        half, rare = np.quantile(np.abs(np.log(one / other)), [0.5, 0.95])
        yield f"| {n} | {np.exp(half):.2f} | {np.exp(rare):.2f} |"


def first_cycle() -> Iterator[str]:
    """Yield what one odd first arrival does to RP of one axis if it counts."""
    yield "| first arrival off by, in standard deviations | RP of 31 over RP of the last 30 |"
    yield "|---|---|"
    for offset in OFFSETS:
        counted = figures(31, 1, np.random.default_rng(9283), first=offset).mean()
        left_out = figures(30, 1, np.random.default_rng(9283)).mean()
        yield f"| {offset} | {counted / left_out:.2f} |"


if __name__ == "__main__":
    page.run({"spread": spread, "pairs": pairs, "first cycle": first_cycle}, PAGE, __doc__)
