"""What each refinement of the diagnosis brings: it is turned off, and the same tables are searched.

    python -m benchmarks.ablation [--tables 8] [--windows 60] [--only SWITCH ...] [--write]

A switch puts something neutral in the place of one refinement. Every table is searched with and
without it; counted is what changes, in pairs, with its standard error. *found*: structure in tables
that hold some. *right*: the first name is right, or none is sure where none can be. *sure wrong*: a
wrong name of 0.9 or more. *alarms*: structure in scatter alone. *error*: mean log of the true error
of the completed model, where the course is known. *Brier*: squared distance of the stated
probability from what was right. Names of real windows are judged by benchmarks/study.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from unittest.mock import patch

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from diagnosis_data import HIGH, MIDDLE, NAME, TOGETHER, dial, noise, shape
from undeclared import FAMILIES

from benchmarks.page import RESULTS, put
from benchmarks.study.judge import NOTHING, UNEXPLAINED, judged
from benchmarks.study.windows import NEXT, SHIPPED, series_in, starts
from scara_iso.diagnosis import LEVEL, UNKNOWN
from scara_iso.diagnosis.fit import fit
from scara_iso.diagnosis.problem import problem_of
from scara_iso.diagnosis.search import find
from scara_iso.diagnosis.unexplained import learn
from scara_iso.effects import Process, find_effects
from scara_iso.run import Axis, Run

PAGE = RESULTS / "ablation.md"
SURE = 0.9
N = 30
J = np.arange(N)
U = J / (N - 1)
warnings.filterwarnings("ignore")


def chirp(u):
    """Return a sine whose period shrinks from 12 to 3 cycles."""
    return np.sin(2 * np.pi * (N / 12 * u + (N / 3 - N / 12) * u**2 / 2))


OUTSIDE = {
    "chirp": lambda rng: 3.5 * chirp(U + rng.random()),
    "vee": lambda rng: 3.5 * (2 * np.abs(2 * U - rng.uniform(0.7, 1.3)) - 1),
    "trapezoid": lambda rng: 6 * np.clip(np.minimum(U, 1 - U) * 5 - rng.uniform(0, 0.5), 0, 1),
    "damped": lambda rng: 5 * np.exp(-2.5 * U) * np.cos(2 * np.pi * J / rng.uniform(5, 8)),
    "two bumps": lambda rng: 5 * sum(
        np.exp(-(((J - m) / 2) ** 2) / 2) for m in (rng.uniform(5, 10), rng.uniform(19, 25))
    ),
    "kinks": lambda rng: 6 * np.interp(U, [0, 0.3, 0.6, 1], rng.permutation([0, 1, 0.2, 0.8])),
    "square": lambda rng: 2.5 * np.where(
        np.isin(np.searchsorted(np.cumsum(rng.permutation([3, 4, 6, 7])), J, "right"), [0, 2]),
        1, -1),
    "growing sine": lambda rng: 4.5 * U * np.sin(2 * np.pi * J / rng.uniform(5, 8)),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Table:
    """Readings, the names that are right of them (none: no name is), and their course if known."""

    kind: str
    run: Run
    names: frozenset[str] = frozenset()
    course: np.ndarray | None = None
    silent: bool = False
    window: tuple | None = None


@dataclass(frozen=True)
class Answer:
    """What a search says of one table; nan where a figure does not apply."""

    found: float
    right: float
    sure_wrong: float
    alarm: float
    error: float
    brier: float


FIGURES = tuple(Answer.__dataclass_fields__)
WORSE = {"found": -1, "right": -1, "sure_wrong": 1, "alarm": 1, "error": 1, "brier": 1}


def run_of(values, resolution=1.0):
    """Return the run of columns (n, axes)."""
    names = "XYZ"[: values.shape[1]]
    axes = {n: Axis(n, values[:, k], resolution=resolution) for k, n in enumerate(names)}
    return Run(np.arange(len(values)) + 2, axes)


def simulated(count: int) -> Iterator[Table]:  # noqa: C901 - a loop for each kind
    """Yield ``count`` tables of each kind."""
    for k, (kind, size) in enumerate((*HIGH, *MIDDLE)):
        for i in range(count):
            rng, sigma = np.random.default_rng([1, k, i]), (0.3, 0.6, 1.0, 4.0)[i % 4]
            course = size * rng.choice([-1, 1]) * shape(rng, kind)
            values = dial(rng, course + noise(rng), sigma)[:, np.newaxis]
            yield Table("listed", run_of(values), frozenset({NAME[kind]}), sigma * course)
    for family in FAMILIES:
        for i in range(count):
            kind = "scatter" if family.silent else "other equations"
            yield Table(kind, family.table(i), family.names, silent=family.silent)
    for k, kinds in enumerate(TOGETHER):
        for i in range(count):
            rng, sizes = np.random.default_rng([2, k, i]), dict(HIGH)
            course = sum(sizes[kind] * rng.choice([-1, 1]) * shape(rng, kind) for kind in kinds)
            values = dial(rng, course + noise(rng), 1.0)[:, np.newaxis]
            yield Table("two effects", run_of(values), frozenset(NAME[k] for k in kinds), course)
    for k, (_, make) in enumerate(OUTSIDE.items()):
        for i in range(count):
            rng, sigma = np.random.default_rng([3, k, i]), (1.0, 4.0)[i % 2]
            course = make(rng)
            values = dial(rng, course + noise(rng), sigma)[:, np.newaxis]
            yield Table("undeclared", run_of(values), course=sigma * course)
    for i in range(2 * count):
        rng = np.random.default_rng([4, i])
        course = np.zeros((N, 2))
        rows = rng.choice(N, 1 + i % 2, replace=False)
        course[rows, 0] = rng.choice([-1, 1], len(rows)) * rng.uniform(8, 15, len(rows))
        values = np.round(2 * (course + rng.normal(size=(N, 2))))
        yield Table("odd readings", run_of(values), frozenset({"outlier"}), 2 * course)
    for k, kind in enumerate(("normal", "t5", "Laplace", "uniform", "arcsine", "split")):
        for i in range(2 * count):
            rng = np.random.default_rng([5, k, i])
            values = np.stack([dial(rng, noise(rng, kind), (0.4, 3.0)[i % 2]) for _ in range(2)], 1)
            yield Table("scatter", run_of(values), silent=True)


def real(count: int) -> Iterator[Table]:
    """Yield windows of 30 real readings, each with the 30 that came next."""
    every = [(s, a) for folder in SHIPPED for s in series_in(folder) for a in starts(s, N)]
    for series, start in every[:: max(1, len(every) // count)]:
        y, z = np.split(series.divisions[start : start + N + NEXT], [N])
        if np.ptp(y) and np.ptp(z):
            yield Table("real", run_of(y[:, np.newaxis]), window=(tuple(y), tuple(z)))


@cache
def judgement(statement: str, window: tuple, second: str | None) -> str:
    """Return what came of a statement about a real window."""
    return judged(statement, *map(np.array, window), second).verdict


def answer(table: Table) -> Answer:
    """Return what the search says of a table, now."""
    if all(np.ptp(a.readings) == 0 for a in table.run.axes.values()):
        return Answer(*[np.nan] * len(FIGURES))
    problem = problem_of(table.run, directions={}, effects=find_effects())
    terms, stages = find(problem, np.random.default_rng(1), level=LEVEL)
    choice, ended = stages[0].choice, stages[-1].choice is None
    found = choice is not None
    named = [t.effect for t in terms]
    explained = ended or bool(terms and isinstance(terms[-1].form, Process))
    stated = choice.probability[choice.best] if found and named else None
    if table.window:
        said = named[0] if named else UNEXPLAINED if found else NOTHING
        verdict = judgement(said, table.window, named[1] if len(named) > 1 else None)
        right = {"right": 1.0, "wrong": 0.0}.get(verdict, np.nan)
    elif table.silent:
        right = float(not found)
    elif table.names:
        right = float(found and bool(named) and named[0] in table.names)
    else:
        right = float(found and not (explained and stated and stated >= SURE))
    wrong = float(stated is not None and stated >= SURE and right == 0 and choice.best != UNKNOWN)
    brier = (
        (stated - right) ** 2 if stated is not None and (table.names or table.window) else np.nan
    )
    return Answer(
        np.nan if table.silent or table.window else float(found),
        np.nan if table.silent else right,
        wrong,
        float(found) if table.silent else np.nan,
        error(problem, terms, found and not explained, table),
        brier,
    )


def error(problem, terms, unexplained, table) -> float:
    """Return the log of the true error of the completed model over that of none."""
    if table.course is None:
        return np.nan
    learned = learn(problem, terms, problem.rows) if unexplained else ()
    values = problem.residual.values
    predicted = fit((*terms, *learned), values, problem.rows, len(values)).predicted
    course = table.course if table.course.ndim == 2 else table.course[:, np.newaxis]
    names = list(table.run.axes)
    course = course[:, [names.index(axis) for axis in problem.residual.axes]]
    before, left = (c - c.mean(axis=0) for c in (course, course - predicted))
    return float(np.log(np.sqrt((left**2).mean()) / np.sqrt((before**2).mean())))


def nothing(*_, **__):
    """Return nothing found."""
    return []


def _unrounded(choose):
    def without(hypotheses, views, beside=(), _=None, log_change=None, finer=None):
        return choose(hypotheses, views, beside, None, log_change, finer)

    return without


def switches() -> dict[str, list[tuple[str, object]]]:
    """Return what each switch puts in the place of what, by the path of an attribute."""
    from scara_iso.diagnosis import search  # noqa: PLC0415 - as patched

    room = "scara_iso.diagnosis."
    every = {
        "rounded likelihood": [("search.choose", _unrounded(search.choose))],
        "tails": [("likelihood.rounded.HEAVY_SHARE", 1e-9)],
        "near rivals": [("naming.choice._near", lambda *_: {})],
        "stated probabilities": [("naming.choice.as_stated", lambda posterior, _: posterior)],
        "two-state model": [("search.two_states", nothing)],
        "misfit": [("search.without_misfit", lambda _p, _t, left: (left, 0.0))],
        "widening": [("significance.permutation.WIDENING_SHARE", 0.0)],
        "persistence": [("significance.permutation.PERSISTENCE_SHARE", 0.0)],
        "pairs": [("search.pairs", nothing)],
        "refined term": [("search.refined", lambda _p, _n, form, _l: form)],
        "refined rivals": [("search.refined_courses", nothing)],
        "refined members": [("search.refined_members", nothing)],
        "best levels": [("search.with_levels", lambda hypotheses, _l, _n: hypotheses)],
        "likeliest unknown": [("significance.permutation.UNKNOWN_SHARE", 0.0)],
        "amplitudes": [("naming.choice.AMPLITUDES", ((1.0, 1.0),)),
                       ("likelihood.evidence.AMPLITUDES", ((1.0, 1.0),)),
                       ("likelihood.on_dial.AMPLITUDES", ((1.0, 1.0),)),
                       ("naming.off_the_grid.AMPLITUDES", ((1.0, 1.0),))],
        "gross ones drawn in": [("search._drawn_in", lambda left: left.values)],
        "two levels test": [("significance.marginal._levels", lambda *_: 1.0)],
        "out of reach": [("problem._reached", lambda *_: 1.0)],
    }  # fmt: skip
    return {name: [(room + path, new) for path, new in own] for name, own in every.items()}


def searched(tables: list[Table], switch: list[tuple[str, object]]) -> np.ndarray:
    """Return the figures (tables, figures) under a switch."""
    with ExitStack() as stack:
        for path, new in switch:
            stack.enter_context(patch(path, new))
        return np.array([list(vars(answer(t)).values()) for t in tables])


def row(name: str, with_it: np.ndarray, without: np.ndarray) -> str:
    """Return a line: the figures' change without the refinement, worse ones in bold."""
    cells = []
    for k, figure in enumerate(FIGURES):
        change = (without - with_it)[:, k]
        change = change[np.isfinite(change)]
        mean, u = change.mean(), change.std(ddof=1) / len(change) ** 0.5
        scale = 1 if figure in ("error", "brier") else 100
        text = (
            f"{scale * mean:+.3f} ± {scale * u:.3f}"
            if scale == 1
            else f"{scale * mean:+.1f} ± {scale * u:.1f}"
        )
        cells.append(f"**{text}**" if u and WORSE[figure] * mean > u else text)
    return f"| {name} | " + " | ".join(cells) + " |"


def main() -> None:
    """Print the table, and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=int, default=8)
    parser.add_argument("--windows", type=int, default=60)
    parser.add_argument("--only", nargs="+", default=[])
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    os.nice(10)
    begun = time.monotonic()
    tables = [*simulated(given.tables), *real(given.windows)]
    base = searched(tables, [])
    kinds = Counter(t.kind for t in tables)
    counts = ", ".join(f"{kind} {count}" for kind, count in kinds.items())
    lines = [f"{len(tables)} tables: {counts}."]
    heads = ("without", "found [%]", "right [%]", "sure wrong [%]", "alarms [%]", "error", "Brier")
    lines += ["", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    means = np.nanmean(base, axis=0)
    lines.append("| *nothing turned off* | " + " | ".join(f"{m:.3f}" for m in means) + " |")
    print("\n".join(lines), flush=True)
    for name, switch in switches().items():
        if given.only and name not in given.only:
            continue
        t = time.monotonic()
        lines.append(row(name, base, searched(tables, switch)))
        print(lines[-1], f"{time.monotonic() - t:.0f} s", flush=True)
    lines.append(f"\n{(time.monotonic() - begun) / 60:.0f} minutes.")
    if given.write:
        PAGE.write_text(
            put(PAGE.read_text(encoding="utf-8"), "ablation", "\n".join(lines)), encoding="utf-8"
        )


if __name__ == "__main__":
    main()
