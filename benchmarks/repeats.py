"""How often rows are called repeated, where they are not and where they are.

    python benchmarks/repeats.py

Courses as a dial of one division shows them; benchmarks/results/other.md quotes the figures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from scara_iso.iso9283.core.slips import REPEATED_BY_CHANCE, find_copied, find_repeats

TESTS = 1000
Course = Callable[[], np.ndarray]


def called(course: Course) -> int:
    """Return how many of the tests are called repeated; a course has shape (n, axes)."""
    found = (find_repeats(np.round(course()), np.ones(1)) for _ in range(TESTS))
    return sum(one.p_value < REPEATED_BY_CHANCE for one in found)


def copied(course: Course) -> int:
    """Return in how many of the tests rows are called copied."""
    found = (find_copied(np.round(course()), np.ones(1)) for _ in range(TESTS))
    return sum(one is not None and one.p_value < REPEATED_BY_CHANCE for one in found)


def pasted(rng: np.random.Generator) -> Iterator[tuple[str, Course]]:
    """Yield courses of 30 rows whose last ones are others again, or one of them filled down."""
    for rows, behind in ((6, 20), (10, 20), (15, 15), (6, 1), (11, 1)):
        for axes in (1, 2):
            for s in (1, 3, 10):
                yield (
                    f"{rows} rows {behind} behind, {axes} axes, scatter {s}",
                    lambda r=rows, b=behind, a=axes, s=s: again(rng.normal(0, s, (30, a)), r, b),
                )


def again(course: np.ndarray, rows: int, behind: int) -> np.ndarray:
    """Return a course whose last rows are those so many before them."""
    for k in range(30 - rows, 30):
        course[k] = course[k - behind]
    return course


def without(n: int, rng: np.random.Generator) -> Iterator[tuple[str, Course]]:
    """Yield courses of n rows in which every row is a reading of its own."""
    for s in (0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 10):
        for axes in (1, 3):
            yield f"scatter {s}, {axes} axes", lambda s=s, axes=axes: rng.normal(0, s, (n, axes))
    for s in (0.1, 0.3, 0.5, 1, 2):
        for d in (5, 20, 60):
            ramp = np.linspace(0, d, n)[:, np.newaxis]
            yield f"drift {d}, scatter {s}", lambda s=s, r=ramp: r + rng.normal(0, s, (n, 1))
        yield f"random walk {s}", lambda s=s: np.cumsum(rng.normal(0, s, (n, 1)), axis=0)
    side = 5 * np.where(np.arange(n) % 4 < 2, 1, -1)[:, np.newaxis]
    wave = 50 * np.sin(np.arange(n) / 5)[:, np.newaxis]
    yield "sides ++--", lambda: side + rng.normal(0, 0.2, (n, 1))
    yield "a wave", lambda: wave + rng.normal(0, 0.2, (n, 1))
    yield "heavy tails", lambda: 0.3 * rng.standard_t(1.5, (n, 1))
    for s in (1, 3, 10):
        yield f"stuck, scatter {s}", lambda s=s: stuck(rng.normal(0, s, (n, 1)), rng)


def stuck(course: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a course with one reading held for twelve rows."""
    first = int(rng.integers(0, len(course) - 12))
    course[first : first + 12] = course[first]
    return course


def repeated(rng: np.random.Generator) -> Iterator[tuple[str, Course]]:
    """Yield courses in which each visit is written several times."""
    for times, visits in ((2, 15), (3, 10), (5, 6), (2, 31), (5, 31)):
        for axes in (1, 3):
            for s in (1, 2, 3, 5, 10):
                yield (
                    f"{visits} visits {times} times, {axes} axes, scatter {s}",
                    lambda t=times, v=visits, a=axes, s=s: np.repeat(
                        np.round(rng.normal(0, s, (v, a))), t, axis=0
                    ),
                )


def main() -> None:
    """Print the tables."""
    rng = np.random.default_rng(9283)
    total = total_copied = 0
    for n in (30, 100):
        for name, course in without(n, rng):
            wrong = called(course)
            total += wrong
            also = 0 if name.startswith("stuck") else copied(course)  # those are copies
            total_copied += also
            if wrong or also:
                print(f"{n} rows, {name}: called repeated {wrong}, copied {also} times in {TESTS}")
    tests = TESTS * sum(len(list(without(n, rng))) for n in (30, 100))
    print(f"no repeats: {total} of {tests} called repeated, {total_copied} copied")
    for name, course in repeated(rng):
        print(f"{name}: {called(course) / TESTS:.0%}")
    for name, course in pasted(rng):
        print(f"{name}: {copied(course) / TESTS:.0%} called copied")


if __name__ == "__main__":
    main()
