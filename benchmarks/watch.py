"""The watch over a recording: false alarms where nothing acts, and how soon it sees what does.

``python -m benchmarks.watch`` prints the tables of benchmarks/results/watch.md, ``--write`` puts
them there. OPENBLAS_NUM_THREADS=1 in the environment saves most of its time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.stats import norm, t as student

from benchmarks import page
from scara_iso.diagnosis.engine.order import drawn_in
from scara_iso.diagnosis.live import (
    ALARM,
    explained,
    level_of,
    look,
)
from scara_iso.diagnosis.verdict import Choice
from scara_iso.run import FloatArray, IntArray

RUNS, LONG_RUNS, FOUND, AXIS_RUNS, NAMED = 200, 80, 100, 60, 50
CUSUMS = 4000
PLANNED = 30
SIGMA = 0.7
"""Scatter in divisions of the dial, where readings are rounded."""
PAGE = page.RESULTS / "watch.md"
K = np.arange(PLANNED)

SCATTER: dict[str, Callable[[np.random.Generator, tuple[int, int]], FloatArray]] = {
    "normal": lambda rng, size: rng.normal(size=size),
    "t3": lambda rng, size: rng.standard_t(3, size=size),
    "skewed (exponential)": lambda rng, size: rng.exponential(size=size),
    "flat": lambda rng, size: rng.random(size),
    "rounded, 0.7 division": lambda rng, size: rounded(rng.normal(size=size), rng),
}
COURSES = {
    "step 2 after 15": 2.0 * (K >= 15),
    "step 3 after 12": 3.0 * (K >= 12),
    "step 3 after 16": 3.0 * (K >= 16),
    "step 3 after 22": 3.0 * (K >= 22),
    "drift 0.1 a cycle": 0.1 * K,
    "drift 0.2 a cycle": 0.2 * K,
    "warm-up 4, tau 5": -4.0 * np.expm1(-K / 5),
    "warm-up 4, tau 10": -4.0 * np.expm1(-K / 10),
    "alternating 2": 2.0 * (K % 2),
    "alternating 2 from 15 on": 2.0 * (K % 2) * (K >= 15),
}
KINDS = {
    "step": "step", "drift": "linear_drift", "warm-up": "warm_up", "alternating": "contact_side",
}  # fmt: skip
SURE = 0.9
BEGINS = {name: next((int(k) for k in K if course[k]), 0) for name, course in COURSES.items()}


def rounded(values: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return values on a dial, each run's mean anywhere between two divisions."""
    return np.round(SIGMA * values + rng.random((len(values), 1)))


def alarms(values: FloatArray, planned: int | None) -> IntArray:
    """Return the reading of the first alarm in each recording (runs, n, axes), 0 for none."""
    first = np.zeros(len(values), dtype=np.int64)
    for k, run in enumerate(values):
        for n in range(1, len(run) + 1):
            level = level_of(n, planned)
            if level and look(run[:n], level, np.random.default_rng([k, n])) >= ALARM:
                first[k] = n
                break
    return first


def at_the_end(values: FloatArray) -> FloatArray:
    """Return whether one test of each whole recording (runs, n, axes) finds structure."""
    return np.array(
        [look(run, 1 / ALARM, np.random.default_rng(k)) >= ALARM for k, run in enumerate(values)]
    )


def cusum(values: FloatArray) -> FloatArray:
    """Return Hawkins' self-starting CUSUM, k = 0.5, either direction, after each reading."""
    runs, n = values.shape
    up, down, found = np.zeros(runs), np.zeros(runs), np.zeros(values.shape)
    for k in range(2, n):
        mean, sd = values[:, :k].mean(axis=1), np.maximum(values[:, :k].std(axis=1, ddof=1), 1e-9)
        T = (values[:, k] - mean) / sd * (k / (k + 1)) ** 0.5
        z = np.clip(norm.ppf(student.cdf(T, k - 1)), -8, 8)
        up, down = np.maximum(0, up + z - 0.5), np.maximum(0, down - z - 0.5)
        found[:, k] = np.maximum(up, down)
    return found


@cache
def cusum_limit(scatter: str) -> float:
    """Return the limit that 5 % of runs of the planned length reach in such scatter."""
    values = SCATTER[scatter](np.random.default_rng(0), (CUSUMS, PLANNED))
    return float(np.quantile(cusum(values).max(axis=1), 0.95))


def level() -> Iterator[str]:
    """Yield a row for each scatter: how many runs in which nothing acts have an alarm."""
    yield "| scatter | looks, 30 | looks, 60 | open, 30 | open, 100 | CUSUM | fixed, 30 |"
    yield "|---|---|---|---|---|---|---|"
    rows = []
    for k, (name, draw) in enumerate(SCATTER.items()):
        values = draw(np.random.default_rng(k), (RUNS, 100))[:, :, np.newaxis]
        rows.append(
            [
                alarms(values[:, :30], 30) > 0,
                alarms(values[:LONG_RUNS, :60], 60) > 0,
                alarms(values[:, :30], None) > 0,
                alarms(values[:LONG_RUNS], None) > 0,
                cusum(values[:, :30, 0]).max(axis=1) >= cusum_limit("normal"),
                at_the_end(values[:, :30]),
            ]
        )
        yield f"| {name} | {' | '.join(f'{100 * one.mean():.1f}' for one in rows[-1])} |"
    means = (100 * np.mean([one.mean() for one in cell]) for cell in zip(*rows, strict=True))
    yield f"| mean | {' | '.join(f'{one:.1f}' for one in means)} |"


def found() -> Iterator[str]:
    """Yield a row for each course: how many are found, and how many cycles after it began."""
    yield "| effect [scatters] | looks | open | CUSUM | fixed, 30 | cycles used |"
    yield "|---|---|---|---|---|---|"
    for k, (name, course) in enumerate(COURSES.items()):
        rng = np.random.default_rng(100 + k)
        readings = rounded(rng.normal(size=(FOUND, PLANNED)) + course, rng)
        values, begin = readings[:, :, np.newaxis], BEGINS[name]
        seen = cusum(readings) >= cusum_limit("rounded, 0.7 division")
        by_looks = alarms(values, PLANNED)
        cells = [
            _cell(by_looks, begin),
            _cell(alarms(values, None), begin),
            _cell(np.where(seen.any(axis=1), seen.argmax(axis=1) + 1, 0), begin),
        ]
        used = np.where(by_looks, by_looks, PLANNED).mean()
        fixed = 100 * at_the_end(values).mean()
        yield f"| {name} | {' | '.join(cells)} | {fixed:.0f} | {used:.1f} |"


def _cell(first: IntArray, begin: int) -> str:
    seen = first > 0
    later = np.median(first[seen] - begin) if seen.any() else np.nan
    return f"{100 * seen.mean():.0f}, {later:.0f}"


def axes() -> Iterator[str]:
    """Yield a row for each case of several axes."""
    yield "| axes | looks | open |"
    yield "|---|---|---|"
    cases = {
        "three, scatter only, independent": (3, 0.0, 0.0, 0, 0),
        "three, scatter only, correlated 0.9": (3, 0.9, 0.0, 0, 0),
        "ten, scatter only, correlated 0.5": (10, 0.5, 0.0, 0, 0),
        "step 3 on all three after 12": (3, 0.0, 3.0, 3, 12),
        "step 3 on all three after 22": (3, 0.0, 3.0, 3, 22),
        "step 3 on one of three after 12": (3, 0.0, 3.0, 1, 12),
        "step 3 on one of three after 22": (3, 0.0, 3.0, 1, 22),
    }
    for k, (name, (count, together, size, moved, at)) in enumerate(cases.items()):
        rng = np.random.default_rng(200 + k)
        common = rng.normal(size=(AXIS_RUNS, PLANNED, 1)) * together**0.5
        values = common + rng.normal(size=(AXIS_RUNS, PLANNED, count)) * (1 - together) ** 0.5
        values[:, at:, :moved] += size
        cells = [_cell(alarms(values, planned), at) for planned in (PLANNED, None)]
        yield f"| {name} | {' | '.join(cells)} |"


def names() -> Iterator[str]:
    """Yield a row for each course: what is said at the alarm, and how often it is right."""
    yield "| effect [scatters] | alarms | named right | of shares above 90 % | or a rival |"
    yield "|---|---|---|---|---|"
    for name, told in _at_alarms().items():
        right = KINDS[name.split()[0]]
        named = [one.best == right for one in told]
        sure = [ok for ok, one in zip(named, told, strict=True) if _share(one) > SURE]
        among = [right in (one.best, *(rival.effect for rival in one.rivals)) for one in told]
        cells = (named, sure, among)
        shares = " | ".join(f"{sum(one)} of {len(one)}" for one in cells)
        yield f"| {name} | {len(told)} | {shares} |"


def shares() -> Iterator[str]:
    """Yield a row for each range of shares: how many of the names at the alarm are right."""
    yield "| share stated | names | mean of it | right |"
    yield "|---|---|---|---|"
    told = [
        (_share(one), one.best == KINDS[name.split()[0]])
        for name, own in _at_alarms().items()
        for one in own
    ]
    for low, high in pairwise((0.0, 0.5, 0.7, 0.8, 0.9, 1.01)):
        here = np.array([one for one in told if low <= one[0] < high]).reshape(-1, 2)
        stated, right = 100 * here.mean(axis=0)
        among = f"{100 * low:.0f} to {min(100, 100 * high):.0f} %"
        yield f"| {among} | {len(here)} | {stated:.0f} | {right:.0f} |"


def _share(choice: Choice) -> float:
    return choice.probability[choice.best]


@cache
def _at_alarms() -> dict[str, list[Choice]]:
    """Return what is known at the first alarm of the recordings of each course."""
    return {
        name: [_explained(values) for values, _ in _alarms(300 + k, name, NAMED)]
        for k, name in enumerate(COURSES)
    }


def _explained(values: FloatArray) -> Choice:
    return explained(drawn_in(values), _cycles(len(values)))


def _cycles(n: int) -> IntArray:
    return np.arange(2, n + 2)


def _alarms(seed: int, name: str, runs: int) -> Iterator[tuple[FloatArray, float]]:
    """Yield each recording's readings (n, 1) up to its first alarm, and its place on the dial."""
    rng = np.random.default_rng(seed)
    place = rng.random((runs, 1))
    values = np.round(SIGMA * (rng.normal(size=(runs, PLANNED)) + COURSES[name]) + place)
    for run, first in enumerate(alarms(values[:, :, np.newaxis], PLANNED).tolist()):
        if first:
            yield values[run, :first, np.newaxis], float(place[run, 0])


if __name__ == "__main__":
    tables = {"level": level, "found": found, "axes": axes, "names": names, "shares": shares}
    page.run(tables, PAGE, __doc__)
