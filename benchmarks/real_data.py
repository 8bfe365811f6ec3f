"""What the diagnosis says of readings that others measured, and an independent judgement of it.

    python benchmarks/real_data.py [--data FOLDER] [--rows 30] [--first 0] [--processes 2] [--list]

FOLDER holds series by kind: probe_thermal/*.json (touches of a probe), nist_dataplot/*.DAT,
nist_strd/*.dat, columns/*.txt (one number a line); without it the series of tests/fixtures are
taken. Each is cut into tests of --rows readings, one after the other from reading --first on.

A name stated with 0.9 or more is judged by real_judge.py, by maximum likelihood of readings in
whole divisions and BIC: the name alone or beside the second effect found, whichever is nearer. It
is *doubtful* where a course that does not contain it comes within 4 of it. It is *wrong* where the
window's neighbours do not refute all of these: jumps beside a smooth name are refuted where a
smooth trend of all three windows does not need them, a parabola or cubic where it foretells the
next window worse. A step is wrong also where it does not stand out of the smooth trend of the
three.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
from collections import Counter
from collections.abc import Iterator
from multiprocessing import Pool
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from real_judge import MEANS, Test, in_context, not_refuted, rivals_of

from scara_iso.diagnosis.problem import problem_of
from scara_iso.diagnosis.search import find
from scara_iso.diagnosis.tuning import SEED
from scara_iso.effects import find_effects
from scara_iso.run import Axis, Run

FIXTURES = Path(__file__).parents[1] / "tests" / "fixtures"
SURE = 0.9
STATISTICS = {"Lew": 200, "Lottery": 218, "Mavro": 50, "Michelso": 100}


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


def said_of(test: Test) -> dict[str, object]:
    """Return the first name that the diagnosis gives, and the judgement where it is sure."""
    axis = Axis("Z", test.y, resolution=1.0)
    run = Run(np.arange(1, len(test.y) + 1), {"Z": axis})
    problem = problem_of(run, directions={}, effects=find_effects())
    terms, stages = find(problem, np.random.default_rng(SEED))
    choice = stages[0].choice
    said = {"series": test.series, "start": test.start, "name": None, "sure": False}
    if choice is None:
        return said
    name, p = choice.best, choice.probability[choice.best]
    said |= {"name": name, "p": p, "sure": p >= SURE and name in MEANS}
    if said["sure"]:
        near = rivals_of([term.effect for term in terms] or [name], test.y)
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
