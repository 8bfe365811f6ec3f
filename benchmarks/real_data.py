"""What the diagnosis says of readings that others measured, and an independent judgement of it.

    python benchmarks/real_data.py [--data FOLDER] [--rows 30] [--first 0] [--processes 2] [--list]

FOLDER holds series by kind: probe_thermal/*.json (touches of a probe), nist_dataplot/*.DAT,
nist_strd/*.dat, columns/*.txt (one number a line); without it the series of tests/fixtures are
taken. Each is cut into tests of --rows readings, one after the other from reading --first on.

A name stated with 0.9 or more is judged by maximum likelihood of rounded Gaussian readings (EM,
scatter not below a tenth of a division) and BIC. It is *doubtful* where a course that does not
contain it comes within 4 of it. It is *wrong* where the window's neighbours do not refute all of
these: jumps beside a smooth name are refuted where a smooth trend of all three windows does not
need them, a parabola or cubic where it foretells the next window worse. A step is wrong also where
it does not stand out of the smooth trend of the three.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing import Pool
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.special import ndtr

from scara_iso.diagnosis.problem import problem_of
from scara_iso.diagnosis.search import chosen
from scara_iso.diagnosis.tuning import SEED
from scara_iso.effects import find_effects
from scara_iso.run import Axis, Run

FIXTURES = Path(__file__).parents[1] / "tests" / "fixtures"
WITHIN = 4.0
SURE = 0.9
LEAST = 0.1
STATISTICS = {"Lew": 200, "Lottery": 218, "Mavro": 50, "Michelso": 100}


@dataclass(frozen=True)
class Test:
    """One window of a series in divisions, with up to as many readings before and after it."""

    series: str
    start: int
    y: np.ndarray
    before: np.ndarray
    after: np.ndarray


def series_of(folder: Path) -> Iterator[tuple[str, np.ndarray]]:
    """Yield every series in whole divisions."""
    for file in sorted(folder.glob("probe_thermal/*.json")):
        rows = map(json.loads, file.read_text().splitlines())
        z = np.array([row["z"] for row in rows if "z" in row])
        yield file.stem.removeprefix("probe_accuracy_"), np.rint(z / 0.00125)
    for file in sorted(folder.glob("probe_thermal/touches.csv")):
        rows = list(csv.DictReader(file.open()))
        for run in dict.fromkeys(row["run"] for row in rows):
            yield run, np.array([float(row["steps"]) for row in rows if row["run"] == run])
    for file in sorted(folder.glob("nist_dataplot/*.DAT")):
        lines = file.read_text(errors="replace").splitlines()[25:]
        rows = [row for row in map(_numbers, lines) if row]
        y = [row[-1] for row in rows] if file.stem == "DZIUBA1" else [v for r in rows for v in r]
        yield file.stem, divisions(np.array(y))
    for file in sorted(folder.glob("nist_strd/*.dat")):
        if file.stem in STATISTICS:
            rows = [row for row in map(_numbers, file.read_text().splitlines()[60:]) if row]
            yield file.stem, divisions(np.array([v for row in rows for v in row]))
    for file in sorted(folder.glob("columns/*.txt")):
        yield file.stem, divisions(np.loadtxt(file))


def _numbers(line: str) -> list[float]:
    try:
        return [float(word) for word in line.split()]
    except ValueError:
        return []


def divisions(y: np.ndarray) -> np.ndarray:
    """Return readings in units of the last written digit."""
    written = max(len(f"{v:.9f}".rstrip("0").split(".")[1]) for v in y)
    return np.rint(y * 10**written)


def tests_of(folder: Path, rows: int, first: int) -> list[Test]:
    """Return the windows, from reading ``first`` on, of every series in which anything moves."""
    found = [
        Test(name, k, y[k : k + rows], y[max(0, k - rows) : k], y[k + rows : k + 2 * rows])
        for name, y in series_of(folder)
        for k in range(first, len(y) - rows + 1, rows)
    ]
    return [test for test in found if np.ptp(test.y)]


# the judge


def best_bic(y: np.ndarray, designs: list[np.ndarray], positions: int) -> float:
    """Return the least BIC of rounded readings (n,) about any of the designs (n, k).

    ``positions`` counts the parameters that tell the designs apart.
    """
    X = np.stack([np.column_stack([np.ones(len(y)), design]) for design in designs])
    pinv = np.linalg.pinv(X)
    seen = np.broadcast_to(y, (len(X), len(y)))
    mean = np.einsum("dnk,dkm,dm->dn", X, pinv, seen)
    s = np.maximum(np.sqrt(((y - mean) ** 2).mean(axis=1)), LEAST)[:, None]
    for _ in range(150):
        a, b = (y - 0.5 - mean) / s, (y + 0.5 - mean) / s
        p = np.maximum(_between(a, b), 1e-290)
        fa, fb = _density(a), _density(b)
        inside = np.clip(mean + s * (fa - fb) / p, y - 0.5, y + 0.5)
        variance = np.clip(s**2 * (1 + (a * fa - b * fb) / p - ((fa - fb) / p) ** 2), 0, 0.25)
        mean = np.einsum("dnk,dkm,dm->dn", X, pinv, inside)
        s = np.sqrt(((inside - mean) ** 2 + variance).mean(axis=1))[:, None]
        s = np.maximum(s, LEAST)
    p = np.maximum(_between((y - 0.5 - mean) / s, (y + 0.5 - mean) / s), 1e-290)
    likelihood = np.log(p).sum(axis=1).max()
    return float(-2 * likelihood + (X.shape[2] + 1 + positions) * np.log(len(y)))


def _between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.where(a > 0, ndtr(-a) - ndtr(-b), ndtr(b) - ndtr(a))


def _density(x: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi)


def gaussian_bic(y: np.ndarray, covariances: list[np.ndarray], parameters: int) -> float:
    """Return the least BIC over covariances (n, n) of readings about a constant, any scale.

    Rounding adds a twelfth to every variance.
    """
    n, one = len(y), np.ones(len(y))
    spread = max(y.var(), 0.1)
    best = -np.inf
    for covariance in covariances:
        values, vectors = np.linalg.eigh(covariance)
        turned, level = vectors.T @ y, vectors.T @ one
        for scale in spread * np.geomspace(0.003, 4, 30):
            variance = scale * values + 1 / 12
            mean = (level * turned / variance).sum() / (level**2 / variance).sum()
            squares = ((turned - mean * level) ** 2 / variance).sum()
            best = max(best, -0.5 * (squares + np.log(2 * np.pi * variance).sum()))
    return -2 * best + (2 + parameters) * np.log(n)


def two_state_bic(y: np.ndarray) -> float:
    """Return the least BIC of two levels between which a symmetric chain switches."""
    levels, best = np.unique(y), -np.inf
    grid = np.linspace(levels[0], levels[-1], min(24, 2 * len(levels) + 1))
    low, high = (v.ravel() for v in np.meshgrid(grid, grid))
    low, high = low[high > low], high[high > low]
    for s in np.maximum(y.std() * np.array([0.1, 0.2, 0.35, 0.5, 0.7, 1.0]), 0.2):
        p = [_between((y[:, None] - 0.5 - m) / s, (y[:, None] + 0.5 - m) / s) for m in (low, high)]
        for q in (0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 0.95):
            a, b, total = 0.5 * np.ones_like(low), 0.5 * np.ones_like(low), 0.0
            for pa, pb in zip(*p, strict=True):
                a, b = ((1 - q) * a + q * b) * pa, ((1 - q) * b + q * a) * pb
                total, a, b = (
                    total + np.log(a + b + 1e-290),
                    a / (a + b + 1e-290),
                    b / (a + b + 1e-290),
                )
            best = max(best, float(total.max()))
    return -2 * best + 4 * np.log(len(y))


def bics(y: np.ndarray) -> dict[str, float]:
    """Return the BIC of every course in readings (n,) in divisions."""
    n = len(y)
    j = np.arange(n)
    t = j / n
    step = [1.0 * (j >= k) for k in range(3, n - 2)]
    lag = np.abs(np.subtract.outer(j, j))
    walk = np.minimum.outer(j, j) + 1.0
    lone = [1.0 * (j == k) for k in range(n)]
    periods = 1 / np.arange(1 / (0.7 * n), 0.45, 0.25 / n)
    bump = [np.exp(-0.5 * ((j - c) / w) ** 2) for c in range(2, n - 2, 2)
            for w in (1.0, 2, n / 12, n / 8, n / 5)]  # fmt: skip
    between = [
        1.0 * ((j >= a) & (j < b)) for a in range(2, n - 3, 2) for b in range(a + 2, n - 1, 2)
    ]
    rows = np.column_stack
    wide = [np.diag(np.where(j >= k, r, 1.0)) for k in range(5, n - 4) for r in (0.1, 0.3, 3, 10)]
    return {
        "constant": best_bic(y, [np.empty((n, 0))], 0),
        "line": best_bic(y, [t], 0),
        "quadratic": best_bic(y, [rows([t, t**2])], 0),
        "cubic": best_bic(y, [rows([t, t**2, t**3])], 0),
        "step": best_bic(y, step, 1),
        "two steps": best_bic(y, [rows([a, b]) for a in step[::2] for b in step[::2] if a @ b < a @ a], 2),  # noqa: E501
        "step and line": best_bic(y, [rows([a, t]) for a in step], 1),
        "exponential": best_bic(y, [np.exp(-j / tau) for tau in np.geomspace(1.5, n / 2, 12)], 1),
        "onset": best_bic(y, [np.maximum(j - k, 0) for k in range(3, n - 3)], 1),
        "sine": best_bic(y, [rows([np.sin(2 * np.pi * j / p), np.cos(2 * np.pi * j / p)]) for p in periods], 1),  # noqa: E501
        "alternation": best_bic(y, [1.0 * (j % 2)], 0),
        "bump": min(best_bic(y, bump, 2), best_bic(y, between, 2)),
        "outlier": best_bic(y, lone, 1),
        "walk": gaussian_bic(y, [np.eye(n) + v * walk for v in (0.01, 0.03, 0.1, 0.3, 1, 3, 10)], 1),  # noqa: E501
        "memory": gaussian_bic(y, [r**lag for r in (0.15, 0.3, 0.45, 0.6, 0.75)], 1),
        "two states": two_state_bic(y),
        "scatter": gaussian_bic(y, wide, 2),
    }  # fmt: skip


MEANS = {
    "step": ("step", {"two steps", "step and line", "two states"}),
    "linear_drift": ("line", {"quadratic", "cubic", "exponential", "onset", "step and line"}),
    "warm_up": ("exponential", {"cubic"}),
    "onset": ("onset", {"cubic", "step and line"}),
    "periodic": ("sine", set()),
    "transient": ("bump", {"two states"}),
    "random_walk": ("walk", set()),
    "autocorrelated": ("memory", {"walk"}),
    "contact_side": ("two states", {"two steps"}),
    "outlier": ("outlier", set()),
    "scatter_change": ("scatter", set()),
}
"""The judge's course of each effect, and those that contain it and so come near it anyway."""


def rivals_of(effect: str, y: np.ndarray) -> dict[str, float]:
    """Return by how much the BIC of other courses exceeds the effect's, where that is little."""
    own, containing = MEANS[effect]
    found = bics(y)
    mine = found.pop(own)
    if effect == "contact_side":
        mine = min(mine, found.pop("alternation"))
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
    two = [np.column_stack([a, b]) for a in at[::2] for b in at[::2] if a @ b < a @ a]
    beside = [best_bic(y, [np.column_stack([s, jump]) for jump in two], 2) for s in smooth[:3]]
    return min(best_bic(y, two, 2), *beside) < min(best_bic(y, [s], 0) for s in smooth)


def worse(effect: str, curve: str, test: Test) -> bool:
    """Return whether a curve foretells the next window worse than the named course does."""
    n, j = len(test.y), np.arange(len(test.y) + len(test.after))
    named = {
        "linear_drift": [j / n],
        "warm_up": [np.exp(-j / tau) for tau in np.geomspace(1.5, n / 2, 12)],
        "onset": [np.maximum(j - k, 0) for k in range(3, n - 3)],
    }[effect]
    power = np.column_stack([(j / n) ** p for p in range(1, CURVES[curve] + 1)])
    return foretold(named, test) < foretold([power], test)


def foretold(designs: list[np.ndarray], test: Test) -> float:
    """Return the squared error on the next window of the design that fits this one best."""
    n, found = len(test.y), []
    for design in designs:
        A = np.column_stack([np.ones(len(design)), design])
        at = A @ np.linalg.lstsq(A[:n], test.y, rcond=None)[0]
        found.append((((at[:n] - test.y) ** 2).sum(), ((at[n:] - test.after) ** 2).sum()))
    return min(found)[1]


def said_of(test: Test) -> dict[str, object]:
    """Return the first name that the diagnosis gives, and the judgement where it is sure."""
    axis = Axis("Z", test.y, resolution=1.0)
    run = Run(np.arange(1, len(test.y) + 1), {"Z": axis})
    problem = problem_of(run, directions={}, effects=find_effects())
    choice = chosen(problem, (), np.random.default_rng(SEED))[0].choice
    said = {"series": test.series, "start": test.start, "name": None, "sure": False}
    if choice is None:
        return said
    name, p = choice.best, choice.probability[choice.best]
    said |= {"name": name, "p": p, "sure": p >= SURE and name in MEANS}
    if said["sure"]:
        near = rivals_of(name, test.y)
        alone = not in_context(name, test)
        said |= {"near": near, "wrong": bool(alone or not_refuted(name, near, test))}
        said["doubtful"] = bool(alone or near)
    return said


def main() -> None:
    """Print names of 0.9 or more, and how many of them the judge does not allow."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=FIXTURES)
    parser.add_argument("--rows", type=int, default=30)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--every", type=int, default=1, help="take each such window only")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--list", action="store_true", help="print each judged name")
    options = parser.parse_args()
    tests = tests_of(options.data, options.rows, options.first)[:: options.every]
    with Pool(options.processes, initializer=os.nice, initargs=(10,)) as pool:
        said = pool.map(said_of, tests, chunksize=4)
    report(said, listed=options.list)


def counted(sure: list[dict]) -> str:
    """Return how many names there are, doubtful by their window and wrong by its neighbours."""
    doubtful, wrong = (sum(one[key] for one in sure) for key in ("doubtful", "wrong"))
    return f"{len(sure)}, doubtful {doubtful}, wrong {wrong}"


def report(said: list[dict], *, listed: bool) -> None:
    """Print a row for each series and each name."""
    print(f"{len(said)} tests")
    for series in dict.fromkeys(one["series"] for one in said):
        names = Counter(one["name"] or "nothing" for one in said if one["series"] == series)
        print(f"{series}: {', '.join(f'{n} {c}' for n, c in names.most_common())}")
    sure = [one for one in said if one["sure"]]
    for effect in sorted({one["name"] for one in sure}):
        own = [one for one in sure if one["name"] == effect]
        print(f"{effect}: 0.9 or more {counted(own)}")
        for one in own if listed else ():
            near = sorted(one["near"].items(), key=lambda item: item[1])
            why = ", ".join(f"{name} {d:+.1f}" for name, d in near)
            wrong = "WRONG " * one["wrong"]
            print(f"    {one['series']} {one['start']} p {one['p']:.3f} {wrong}{why}")
    print(f"names of 0.9 or more: {counted(sure)}")


if __name__ == "__main__":
    main()
