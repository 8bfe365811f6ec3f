"""Judge the diagnosis on hidden tables and real windows, and what each refinement brings.

    python -m benchmarks.ablation [--tables 6] [--windows 100] [--save FILE] [--against FILE]
    python -m benchmarks.ablation --without all [--write]

Tables as a laboratory has them: axes X, Y, Z, 30 cycles that count, a dial of 1 um. Their courses
are written by other equations than the catalogue's. Of each kind is counted: *found*, structure;
*right*, the first name is right (of two effects both are, of a course on no list no name is sure),
*sure wrong*, a wrong name of 0.9 or more; *after / before*, the true error of the completed model
over that of none, median; *Brier*, the squared distance of the stated probability from what was
right. ``--save`` keeps the answers, ``--against`` compares with those of another program in pairs.
``--without`` turns refinements off one by one: a switch puts something neutral in its place. Names
of real windows are judged by benchmarks/study.
"""

from __future__ import annotations

import argparse
import os
import pickle
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from unittest.mock import patch

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from benchmarks.page import RESULTS, put
from benchmarks.study.judge import NOTHING, UNEXPLAINED, judged
from benchmarks.study.windows import NEXT, SHIPPED, series_in, starts
from scara_iso import diagnose
from scara_iso.diagnosis.closed_loop import close_the_loop
from scara_iso.diagnosis.engine import hypotheses
from scara_iso.diagnosis.engine.naming import choose
from scara_iso.diagnosis.engine.residual import CyclesWanted
from scara_iso.run import Axis, Run

PAGE = RESULTS / "ablation.md"
SURE, N, DIVISION = 0.9, 30, 0.001
J = np.arange(N)
U = J / (N - 1)
TABLES = 6
Rng = np.random.Generator


@dataclass(frozen=True, eq=False)
class Table:
    """A run; the names that are right of it, all of them where ``both``; its course (n, axes)."""

    kind: str
    run: Run
    names: frozenset[str] = frozenset()
    both: bool = False
    course: np.ndarray | None = None
    cycles: frozenset[int] = frozenset()
    window: tuple | None = None
    silent: bool = False
    poses: bool = False


@dataclass(frozen=True)
class Answer:
    """What the program says of a table; nan where a figure does not apply."""

    found: float
    right: float
    sure_wrong: float
    error: float
    brier: float
    stated: float
    said: str
    seconds: float


def within(low, high):
    """Return a draw between two numbers, by a generator."""
    return lambda rng: rng.uniform(low, high)


def walked(rng: Rng, size=0.9):
    """Return a random walk."""
    return np.cumsum(rng.normal(0, size, N))


def remembered(rng: Rng, r=0.75, size=3.0):
    """Return readings that keep a share of the one before."""
    x = rng.normal(size=N)
    for k in range(1, N):
        x[k] = r * x[k - 1] + (1 - r * r) ** 0.5 * x[k]
    return size * x


def sides(rng: Rng, stay: float):
    """Return a hidden side that stays with a probability; at least five cycles on either."""
    while True:
        s = np.cumsum(rng.random(N) > stay) % 2
        if 5 <= s.sum() <= N - 5 and (s[1:] != s[:-1]).sum() >= 2:
            return s - 0.5


LISTED: Mapping[str, tuple[Callable[[Rng], np.ndarray], frozenset[str]]] = {
    "drift": (lambda g: g.uniform(4, 7) * U, frozenset({"linear_drift"})),
    "warm-up": (
        lambda g: g.uniform(5, 8) * np.exp(-J / g.uniform(3, 8)), frozenset({"warm_up"})),
    "step": (lambda g: g.uniform(3, 5) * (g.integers(6, 25) <= J), frozenset({"step"})),
    "sine": (
        lambda g: g.uniform(2, 3.5) * np.sin(2 * np.pi * (J / g.uniform(3, 12) + g.random())),
        frozenset({"periodic"})),
    "transient": (
        lambda g: g.uniform(4, 7) * np.exp(-(((J - g.uniform(7, 23)) / g.uniform(1.5, 3)) ** 2)),
        frozenset({"transient"})),
    "onset": (
        lambda g: g.uniform(5, 8) * np.clip(J - (k := g.integers(10, 18)), 0, None) / (29 - k),
        frozenset({"onset"})),
    "settles": (
        lambda g: g.uniform(5, 8) * (1 - np.exp(-np.clip(J - g.integers(8, 16), 0, None) / 4.0)),
        frozenset({"settles", "onset"})),
    "walk": (walked, frozenset({"random_walk", "autocorrelated"})),
    "memory": (remembered, frozenset({"autocorrelated", "random_walk"})),
    "sides that stay": (
        lambda g: g.uniform(5, 8) * sides(g, g.uniform(0.75, 0.9)), frozenset({"contact_side"})),
    "sides by lot": (lambda g: g.uniform(6, 9) * sides(g, 0.5), frozenset({"contact_side"})),
    "sides by turns": (lambda _: 3.5 * (J % 2 - 0.5), frozenset({"contact_side"})),
}  # fmt: skip


def chirp(g: Rng):
    """Return a sine whose period shrinks from 12 to 3 cycles, evenly or as its frequency grows."""
    even = np.log(12 / (12 - 9 * U)) / 9 * (N - 1)
    growing = N / 12 * U + (N / 3 - N / 12) * U**2 / 2
    return np.sin(2 * np.pi * ((even if g.random() < 0.5 else growing) + g.random()))


UNDECLARED: Mapping[str, Callable[[Rng], np.ndarray]] = {
    "chirp": chirp,
    "vee": lambda g: np.abs(U - g.uniform(0.35, 0.65)),
    "trapezoid": lambda g: np.clip(np.minimum(U - g.uniform(0, 0.1), 0.9 - U) * 5, 0, 1),
    "damped": lambda g: np.exp(-2.5 * U) * np.cos(2 * np.pi * J / g.uniform(5, 8)),
    "two bumps": lambda g: sum(
        np.exp(-(((J - m) / 2) ** 2) / 2) for m in (g.uniform(5, 10), g.uniform(19, 25))),
    "kinks": lambda g: np.interp(U, [0, 0.3, 0.6, 1], g.permutation([0, 1, 0.2, 0.8])),
    "square": lambda g: np.isin(
        np.searchsorted(np.cumsum(g.permutation([4, 5, 6, 8])), J, "right"), [0, 2]) * 1.0,
    "growing sine": lambda g: U * np.sin(2 * np.pi * J / g.uniform(5, 8)),
}  # fmt: skip
FAMILIES: Mapping[str, Callable[[Rng, tuple], np.ndarray]] = {
    "Gaussian": lambda g, s: g.normal(size=s),
    "t5": lambda g, s: g.standard_t(5, size=s) / np.sqrt(5 / 3),
    "Laplace": lambda g, s: g.laplace(size=s) / np.sqrt(2),
    "uniform": lambda g, s: g.uniform(-1, 1, size=s) * np.sqrt(3),
    "arcsine": lambda g, s: np.sqrt(2) * np.sin(g.uniform(0, 2 * np.pi, size=s)),
    "gamma": lambda g, s: (g.gamma(4, size=s) - 4) / 2,
}
COARSE = ("step", "drift", "warm-up", "sine", "sides that stay", "sides by lot")


def table(kind, g: Rng, course, names=frozenset(), *, sigma=None, columns=None, **more) -> Table:
    """Return a table of one course on one to three axes, scatter 2 to 8 um, in mm."""
    sigma = g.uniform(2, 8) if sigma is None else sigma
    along = np.append(1.0, g.uniform(0.4, 1, 2) * (g.random(2) < 0.5)) * g.choice([-1, 1], 3)
    if course.ndim == 1:
        course = np.outer(course, g.permutation(along))
    scatter = more.pop("scatter", g.normal(size=(N, 3)))
    values = g.uniform(200, 800, 3) + sigma * (course + scatter)
    return Table(kind, run_of(np.rint(values) * DIVISION, columns), names,
                 course=sigma * DIVISION * course if course.any() else None, **more)  # fmt: skip


def run_of(values, columns=None, division=DIVISION) -> Run:
    """Return the run of readings (n, axes) in mm."""
    names = ["X", "Y", "Z"][-values.shape[1] :]
    axes = {n: Axis(n, values[:, k], resolution=division) for k, n in enumerate(names)}
    return Run(np.arange(len(values)) + 2, axes, covariates=columns or {})


def listed(count: int) -> Iterator[Table]:
    """Yield tables of every effect of the list, of two at once and of odd readings."""
    for k, (kind, (course, names)) in enumerate(LISTED.items()):
        for i in range(count):
            g = np.random.default_rng([11, k, i])
            yield table(kind, g, course(g), names)
    for i in range(count):
        g = np.random.default_rng([12, i])
        wide = np.where(g.integers(10, 20) <= J, 3.5, 1.0)[:, np.newaxis]
        yield table("scatter change", g, np.zeros((N, 3)), frozenset({"scatter_change"}),
                    scatter=wide * g.normal(size=(N, 3)), sigma=g.uniform(2, 4))  # fmt: skip
        approach = g.permutation(J % 2 * 2.0 - 1)
        yield table("lost motion", g, g.uniform(1, 2) * approach, frozenset({"lost_motion"}),
                    columns={"approach": approach})  # fmt: skip
        room = np.cumsum(g.normal(0, 0.2, N)).round(2)
        yield table("temperature", g, 4 * (room - room.mean()) / np.ptp(room) * 1.5,
                    frozenset({"temperature", "temperature_lagged"}),
                    columns={"temperature_C": 20 + room})  # fmt: skip
    for i in range(2 * count):
        g = np.random.default_rng([13, i])
        pair = g.choice([k for k in LISTED if k not in ("walk", "memory", "settles")], 2, False)
        (one, a), (two, b) = (LISTED[kind] for kind in pair)
        yield table("two effects", g, one(g) + g.choice([-1, 1]) * two(g), a | b, both=True)
    for i in range(4 * count):
        g = np.random.default_rng([14, i])
        course, rows = np.zeros((N, 3)), g.choice(N, 1 + i % 3, replace=False)
        course[rows, g.integers(3)] = g.choice([-1, 1], len(rows)) * g.uniform(10, 20, len(rows))
        yield table("odd readings", g, course, frozenset({"outlier"}),
                    cycles=frozenset((rows + 2).tolist()))  # fmt: skip
    for k, kind in enumerate(COARSE):
        for i in range(count):
            g = np.random.default_rng([15, k, i])
            course, names = LISTED[kind]
            yield table(f"coarse {kind}", g, course(g), names, sigma=g.uniform(0.3, 0.7))


def unlisted(count: int) -> Iterator[Table]:
    """Yield tables of courses on no list, peak to peak 10 and 6 sigma."""
    for size in (10, 6):
        for k, (kind, make) in enumerate(UNDECLARED.items()):
            for i in range(count):
                g = np.random.default_rng([16, size, k, i])
                course = make(g)
                yield table(f"{kind} {size}", g, size * course / np.ptp(course))


AT_POSES = ", five poses"


def at_poses(count: int) -> Iterator[Table]:
    """Yield tables of five poses, X and Y: a course that all take, a step of each at its cycle."""
    for k, (kind, make) in enumerate(UNDECLARED.items()):
        for i in range(count):
            g = np.random.default_rng([18, k, i])
            course = make(g)
            along = g.uniform(0.3, 1, (5, 2)) * g.choice([-1, 1], (5, 2))
            yield poses_table(f"on no list{AT_POSES}: {kind}", g, (course / np.ptp(course), along))
    for k, kind in enumerate(("drift", "warm-up", "step", "sine", "walk")):
        for i in range(count):
            g = np.random.default_rng([19, k, i])
            course, names = LISTED[kind]
            along = g.uniform(0.3, 1, (5, 2)) * g.choice([-1, 1], (5, 2))
            moved = course(g)
            yield poses_table(
                f"listed{AT_POSES}: {kind}", g, (moved / np.ptp(moved), along), names=names
            )
    for i in range(count):
        g = np.random.default_rng([20, i])
        steps = [np.outer(g.integers(6, 25) <= J, g.uniform(0.4, 1, 2)) for _ in range(5)]
        yield poses_table(f"listed{AT_POSES}: steps of each", g, steps, names=frozenset({"step"}))
    for i in range(8 * count):
        g = np.random.default_rng([21, i])
        yield poses_table(f"scatter{AT_POSES}", g, [np.zeros((N, 2))] * 5, silent=True)


def poses_table(kind: str, g: Rng, moved, **more) -> Table:
    """Return a table of five poses that move 8 scatters: an outer product, or each by itself."""
    if isinstance(moved, tuple):
        moved = [np.outer(moved[0], own) for own in moved[1]]
    at = 100 + g.normal(size=(5, N, 2)) * 4 + 32 * np.array(moved)
    axes = {a: Axis(a, np.rint(at[..., k]).T.ravel() * DIVISION, resolution=DIVISION)
            for k, a in enumerate("XY")}  # fmt: skip
    pose = np.tile([f"P{p}" for p in range(1, 6)], N)
    run = Run(np.repeat(np.arange(N) + 2, 5), axes, pose=pose)
    return Table(kind, run, poses=True, **more)


def scatter(count: int) -> Iterator[Table]:
    """Yield tables of scatter alone, of every family, on fine and on coarse dials."""
    for k, (kind, draw) in enumerate(FAMILIES.items()):
        for i in range(4 * count):
            g = np.random.default_rng([17, k, i])
            sigma = g.uniform(0.3, 0.7) if i % 2 else g.uniform(2, 8)
            yield table(
                kind, g, np.zeros((N, 3)), silent=True, sigma=sigma, scatter=draw(g, (N, 3))
            )


def real(count: int) -> Iterator[Table]:
    """Yield windows of 30 real readings, each with the 30 that came next."""
    every = [(s, a) for folder in SHIPPED for s in series_in(folder) for a in starts(s, N)]
    for series, start in every[:: max(1, len(every) // count)] if count else ():
        y, z = np.split(series.divisions[start : start + N + NEXT], [N])
        if np.ptp(y) and np.ptp(z):
            values = (y * series.division)[:, np.newaxis]
            yield Table(f"real {series.set}", run_of(values, division=series.division),
                        window=(tuple(y), tuple(z)))  # fmt: skip


@cache
def judgement(statement: str, window: tuple, second: str | None) -> str:
    """Return what came of a statement about a real window."""
    return judged(statement, *map(np.array, window), second).verdict


def answer(one: Table) -> Answer:
    """Return what the program says of a table, now."""
    begun = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        said = (diagnose(one.run, first_cycle_discarded=True) if one.poses
                else close_the_loop(one.run, None, CyclesWanted(), seed=1))  # fmt: skip
    spent = time.process_time() - begun
    found = said.verdict.value != "nothing-to-explain"
    names = [e.effect for e in said.effects]
    stated = said.effects[0].probability if names else np.nan
    right = _right(one, said, names, found, stated)
    wrong = float(bool(names) and stated >= SURE and right == 0)
    judged_ = (one.names or one.window) and names and np.isfinite(right)
    return Answer(
        float(found) if not one.window else np.nan, right, wrong, _error(one, said),
        (stated - right) ** 2 if judged_ else np.nan, stated if judged_ else np.nan,
        "+".join(names) or said.verdict.value, spent,
    )  # fmt: skip


def _right(one: Table, said, names, found, stated) -> float:
    if one.window:
        word = names[0] if names else UNEXPLAINED if found else NOTHING
        came = judgement(word, one.window, names[1] if len(names) > 1 else None)
        return {"right": 1.0, "wrong": 0.0}.get(came, np.nan)
    if one.silent:
        return float(not found)
    if one.cycles:
        shown = [set(e.parameters["cycles"]) for e in said.effects if e.effect == "outlier"]
        return float(one.cycles in shown)
    if one.both:
        return float(set(names) <= one.names and len(set(names)) > 1)
    if one.names:
        return float(bool(names) and names[0] in one.names)
    return float(found and not (names and stated >= SURE))


def _error(one: Table, said) -> float:
    """Return the log of the true error after over that before, over the axes."""
    if one.course is None or one.cycles:
        return np.nan
    after = np.stack([said.series.predicted_after[a] for a in said.series.predicted_after], 1)
    before = one.course - one.course.mean(axis=0)
    left = before - (after - after.mean(axis=0))
    return float(np.log(np.sqrt((left**2).mean() / (before**2).mean())))


def _unrounded(hypotheses, views, beside=(), _=None, log_change=None):
    return choose(hypotheses, views, beside, None, log_change)


def _settled(lower, *_):
    """Return that no course has one change or none."""
    return np.full_like(lower[:1], -np.inf), np.zeros(1)


def switches() -> dict[str, list[tuple[str, object]]]:
    """Return what each switch puts in the place of what, by the path of an attribute."""
    return {
        "the unknown": [
            ("engine.hypotheses._unknown", lambda _: ()),
            ("engine.search.on_levels", lambda *_: []),
        ],
        "what comes round": [("engine.hypotheses.RECURRING", ())],
        "swings": [("engine.hypotheses.SWINGS", ((8.0, 8.0, 0.7),))],
        "rounded likelihood": [("engine.search.choose", _unrounded)],
        "tails": [("engine.rounded.HEAVY_SHARE", 1e-9), ("engine.naming.HEAVY_SHARE", 1e-9)],
        "amplitudes": [
            *((f"{module}.AMPLITUDES", (1.0,)) for module in ("evidence", "naming", "fit")),
            ("engine.naming.SHARES", np.ones(1)),
        ],
        "shared courses": [("engine.search.in_common", lambda *_: [])],
        "a part alone": [("engine.search._of_one_part", lambda *_: None)],
        "hidden states": [("engine.search.two_states", lambda *_, **__: [])],
        "courses on levels": [("engine.search.on_levels", lambda *_: [])],
        "one change is a step": [("engine.two_levels._at_most_one_change", _settled)],
        "persistence": [("engine.order.PERSISTENCE_SHARE", 0.0)],
        "forms between the grid's": [("engine.search._near", lambda *_: ())],
        "misfit": [("engine.search._misfit", lambda *_: 0.0), ("engine.naming.MISFIT", 0.0)],
        "gross ones drawn in": [("engine.search.drawn_in", lambda values, _: values)],
        "two levels test": [("engine.marginal._levels", lambda *_: (1.0, 1.0))],
        "what no evidence makes sure": [("findings._is_unsure", lambda *_: False)],
    }


def searched(tables: list[Table], switch: list[tuple[str, object]]) -> list[Answer]:
    """Return the answers under a switch."""
    with ExitStack() as stack:
        for path, new in switch:
            stack.enter_context(patch("scara_iso.diagnosis." + path, new))
        _forget()
        answers = [answer(one) for one in tables]
    _forget()
    return answers


def _forget() -> None:
    """Let hypotheses be made anew."""
    hypotheses._of_cycles.cache_clear()


def group_of(kind: str) -> str:
    """Return the group that a kind counts in."""
    if kind in FAMILIES:
        return "scatter alone"
    if kind.startswith("real"):
        return "real windows"
    if AT_POSES in kind:
        return kind.partition(":")[0]
    if kind.startswith("coarse"):
        return "listed, coarse dial"
    if kind.rpartition(" ")[2] in ("6", "10"):
        return f"on no list, {kind.rpartition(' ')[2]} sigma"
    return kind if kind in ("odd readings", "two effects") else "listed"


HEADS = ("kind", "tables", "found", "right", "sure wrong", "after / before", "Brier", "s")


def summary(tables: list[Table], answers: list[Answer]) -> list[str]:
    """Return the table of kinds, groups first."""
    lines = [f"| {' | '.join(HEADS)} |", "|" + "---|" * len(HEADS)]
    groups: dict[str, list[int]] = {}
    for i, one in enumerate(tables):
        groups.setdefault(f"**{group_of(one.kind)}**", []).append(i)
    kinds: dict[str, list[int]] = {}
    for i, one in enumerate(tables):
        kinds.setdefault(one.kind, []).append(i)
    for name, own in [*groups.items(), *kinds.items()]:
        some = [answers[i] for i in own]
        column = {f: np.array([getattr(a, f) for a in some]) for f in
                  ("found", "right", "sure_wrong", "error", "brier", "seconds")}  # fmt: skip
        words: dict[str, int] = {}
        for a in some:
            words[a.said] = words.get(a.said, 0) + 1
        often = sorted(words.items(), key=lambda item: -item[1])[:5]
        said = ", ".join(f"{w} {c}" for w, c in often)
        lines.append(
            f"| {name} | {len(own)} | {_sum(column['found'])} | {_sum(column['right'])} | "
            f"{_sum(column['sure_wrong'])} | {_median(np.exp(column['error']))} | "
            f"{_mean(column['brier'])} | {_mean(column['seconds'])} |"
            + ("" if name.startswith("**") else f" <!-- {said} -->")
        )
    return [*lines, "", *_as_stated(answers)]


def _as_stated(answers: list[Answer]) -> Iterator[str]:
    """Yield how often names are right, by what is stated of them."""
    stated = np.array([a.stated for a in answers])
    right = np.array([a.right for a in answers])
    for low, high in ((0.3, 0.5), (0.5, 0.6), (0.6, 0.7), (0.7, 0.8), (0.8, 0.9), (0.9, 1.01)):
        own = right[(stated >= low) & (stated < high)]
        yield f"stated {low:.1f}-{min(high, 1):.1f}: right {_sum(own)} of {len(own)}  "


def _sum(values) -> str:
    known = values[np.isfinite(values)]
    return f"{int(known.sum())}" + (f" of {len(known)}" if len(known) < len(values) else "")


def _median(values) -> str:
    known = values[np.isfinite(values)]
    return f"{np.median(known):.2f}" if len(known) else ""


def _mean(values) -> str:
    known = values[np.isfinite(values)]
    return f"{known.mean():.3f}" if len(known) else ""


COMPARED = ("found", "right", "sure_wrong", "alarm", "error", "brier", "seconds")
WORSE = {"found": -1, "right": -1, "sure_wrong": 1, "alarm": 1, "error": 1, "brier": 1}


def figures(tables: list[Table], answers: list[Answer]) -> np.ndarray:
    """Return the figures (tables, COMPARED) of answers."""
    rows = []
    for one, a in zip(tables, answers, strict=True):
        found, alarm = (np.nan, a.found) if one.silent else (a.found, np.nan)
        right = np.nan if one.silent else a.right
        rows.append([found, right, a.sure_wrong, alarm, a.error, a.brier, a.seconds])
    return np.array(rows)


def row(name: str, before: np.ndarray, after: np.ndarray) -> str:
    """Return a line: the change of the figures in pairs, worse ones in bold."""
    cells = []
    for k, figure in enumerate(COMPARED):
        change = (after - before)[:, k]
        change = change[np.isfinite(change)]
        if not len(change):
            cells.append("")
            continue
        mean, u = change.mean(), change.std(ddof=1) / len(change) ** 0.5
        scale = 1 if figure in ("error", "brier", "seconds") else 100
        text = (f"{mean:+.3f} ± {u:.3f}" if scale == 1
                else f"{scale * mean:+.1f} ± {scale * u:.1f}")  # fmt: skip
        cells.append(f"**{text}**" if u and WORSE.get(figure, 0) * mean > u else text)
    return f"| {name} | " + " | ".join(cells) + " |"


def main() -> None:
    """Print the tables, and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=int, default=TABLES)
    parser.add_argument("--windows", type=int, default=100)
    parser.add_argument("--save", type=Path)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--without", nargs="+", default=[])
    parser.add_argument("--kinds", nargs="+", default=[], help="only kinds that hold these words")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    begun = time.monotonic()
    n = given.tables
    tables = [*listed(n), *unlisted(n), *at_poses(n // 2), *scatter(n), *real(given.windows)]
    tables = [t for t in tables if not given.kinds or any(k in t.kind for k in given.kinds)]
    answers = searched(tables, [])
    lines = summary(tables, answers)
    print("\n".join(lines), flush=True)
    if given.save:
        given.save.write_bytes(pickle.dumps(answers))
    base = figures(tables, answers)
    changes = [f"| change | {' | '.join(COMPARED)} |", "|" + "---|" * (len(COMPARED) + 1)]
    if given.against:
        other = pickle.loads(given.against.read_bytes())  # noqa: S301 - one's own
        changes.append(row("against the other program", figures(tables, other), base))
        print(changes[-1])
    for name, switch in switches().items():
        if name in given.without or given.without == ["all"]:
            changes.append(row(f"without {name}", base, figures(tables, searched(tables, switch))))
            print(changes[-1], flush=True)
    print(f"{(time.monotonic() - begun) / 60:.1f} minutes")
    if given.write:
        text = PAGE.read_text(encoding="utf-8")
        text = put(text, "judged", "\n".join(lines))
        if len(changes) > 2:
            text = put(text, "ablation", "\n".join(changes))
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
